// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "compiler/server/answers.h"
#include "compiler/server/reference.h"

namespace openfab::server {

namespace {

std::string code(const std::string& text) {
    return "```openfl\n" + text + "\n```\n";
}

const char* name_of_kind(const check::Use& use) {
    switch (use.symbol) {
        case check::SymbolKind::kUniform:
            return "uniform";
        case check::SymbolKind::kConstant:
            return "constant";
        case check::SymbolKind::kLocal:
            return "local variable";
        case check::SymbolKind::kParameter:
            return "parameter";
        case check::SymbolKind::kSurfaceInput:
            return "varying of the mesh";
        case check::SymbolKind::kSurfaceOutput:
            return "varying that the surface stage writes";
        case check::SymbolKind::kShapeOutput:
            return "varying that the shape stage writes";
        case check::SymbolKind::kGrowParent:
            return "node that another grows of";
        case check::SymbolKind::kNearest:
            return "varying at the nearest point of the surface";
        case check::SymbolKind::kAttributes:
            return "attributes";
        case check::SymbolKind::kVoid:
            return "the built-in material of empty space";
        case check::SymbolKind::kType:
            return "struct";
    }
    return "";
}

/// Returns the declaration of an enum, one name a line; empty if it is none.
std::string enum_text(const Analysis& analysis, const check::Use& use) {
    for (const check::Unit& unit : analysis.units()) {
        std::vector<const ast::Scope*> scopes = {&unit.file->scope};
        for (const ast::Fablet& fablet : unit.file->fablets)
            scopes.push_back(&fablet.scope);
        for (const ast::Scope* scope : scopes) {
            for (const ast::Enum& one : scope->enums) {
                if (one.span != use.declared) continue;
                std::string out = fmt::format("enum {} {{\n", one.name);
                for (const ast::Variable& item : one.items) {
                    const std::string value =
                        item.init == nullptr
                            ? ""
                            : fmt::format(" = {}", analysis.sources().text(item.init->span));
                    out += fmt::format("    {}{},\n", item.name, value);
                }
                return out + "};";
            }
        }
    }
    return "";
}

std::string record_text(const check::StructType& record) {
    std::string out = "struct " + record.name + " {\n";
    for (const check::StructMember& m : record.members)
        out += fmt::format("    {} {};\n", check::type_name(m.type), m.name);
    return out + "};";
}

/// Returns the default and the annotations of a uniform.
std::string uniform_text(const Analysis& analysis, const check::Use& use) {
    const ast::Variable* v = analysis.uniform_at(use.declared);
    if (v == nullptr) return {};
    std::string out;
    if (v->init != nullptr)
        out += fmt::format("\nDefault: `{}`\n", analysis.sources().text(v->init->span));
    for (const ast::Annotation& a : v->annotations) {
        if (a.value == nullptr) continue;
        const bool text = a.value->kind == ast::ExprKind::kStringLiteral;
        const std::string_view value =
            text ? a.value->text : analysis.sources().text(a.value->span);
        out += text ? fmt::format("\n{}: {}\n", a.name, value)
                    : fmt::format("\n{}: `{}`\n", a.name, value);
    }
    return out;
}

std::string marked(const std::string& comment) {
    return comment.empty() ? "" : "\n" + comment + "\n";
}

/// Returns what the reference says of a built-in name.
std::string built_in(std::string_view name) {
    std::string out;
    for (const ReferenceEntry& entry : reference_of(name)) {
        out += code(entry.form);
        if (!entry.text.empty()) out += entry.text + "\n";
    }
    if (out.empty() && !check::find_type(name).is_error())
        out = code(std::string(name)) + "built-in type\n";
    return out;
}

void write_hover(const Query& query, const std::string& text, const source::Span& at,
                 JsonText* out) {
    if (text.empty()) {
        out->null();
        return;
    }
    out->begin_object().key("contents").begin_object();
    out->member("kind", "markdown").member("value", text).end_object().key("range");
    query.write_range(out, at.begin, at.end);
    out->end_object();
}

}  // namespace

std::string describe(const Analysis& analysis, const check::Use& use) {
    const std::string comment =
        use.declared.file == 0 ? std::string() : analysis.comment_above(use.declared);
    if (use.kind == check::UseKind::kFunction)
        return code(signature(*use.function)) + marked(comment);
    if (use.kind == check::UseKind::kMember)
        return code(fmt::format("{} {}", check::type_name(use.type), use.name)) + "member\n" +
               marked(comment);
    if (use.symbol == check::SymbolKind::kType && use.type.record != nullptr)
        return code(record_text(*use.type.record)) + marked(comment);
    if (use.symbol == check::SymbolKind::kType && use.kind == check::UseKind::kSymbol)
        return code(enum_text(analysis, use)) + marked(comment);
    return code(fmt::format("{} {}", check::type_name(use.type), use.name)) + name_of_kind(use) +
           "\n" + uniform_text(analysis, use) + marked(comment);
}

void hover(const Query& query, JsonText* out) {
    const Analysis& analysis = *query.analysis;
    if (const check::Use* use = analysis.name_at(query.offset); use != nullptr)
        return write_hover(query, describe(analysis, *use), use->span, out);
    const size_t at = analysis.token_at(query.offset);
    const syntax::Token& token = analysis.tokens()[at];
    const bool touches = token.span.begin <= query.offset && query.offset <= token.span.end;
    if (!touches || token.kind != syntax::TokenKind::kIdentifier)
        return write_hover(query, {}, token.span, out);
    if (at > 0 && analysis.tokens()[at - 1].is("@")) {
        const std::string_view text = marker_text(token.text);
        return write_hover(
            query, text.empty() ? "" : code("@" + std::string(token.text)) + std::string(text),
            token.span, out);
    }
    for (const ast::Import& import : analysis.tree().imports) {
        const std::optional<uint32_t> file =
            import.span == token.span ? analysis.file_of_import(import) : std::nullopt;
        if (file)
            return write_hover(query,
                               code("import " + std::string(import.name) + ";") +
                                   marked(analysis.head_comment(*file)),
                               token.span, out);
    }
    write_hover(query, built_in(token.text), token.span, out);
}

}  // namespace openfab::server
