// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compiler/server/answers.h"
#include "compiler/server/reference.h"

namespace openfab::server {

namespace {

/// SymbolKind of the protocol.
enum class Symbol : int32_t {
    kClass = 5,
    kMethod = 6,
    kProperty = 7,
    kEnum = 10,
    kFunction = 12,
    kConstant = 14,
    kEnumMember = 22,
    kStruct = 23,
};

/// Semantic tokens by their number.
constexpr const char* kTokenTypes[] = {"namespace", "class",    "struct",   "type",   "parameter",
                                       "variable",  "property", "function", "method", "decorator"};
enum class Token : int32_t {
    kNamespace,
    kClass,
    kStruct,
    kType,
    kParameter,
    kVariable,
    kProperty,
    kFunction,
    kMethod,
    kDecorator,
    kNone = -1,
};
constexpr const char* kTokenModifiers[] = {"declaration", "readonly", "defaultLibrary"};
constexpr int32_t kDeclaration = 1, kReadonly = 2, kDefaultLibrary = 4;

class Outline {
  public:
    Outline(const Query& query, JsonText* out)
        : query_(query), analysis_(*query.analysis), out_(out) {}

    void file() {
        out_->begin_array();
        scope(analysis_.tree().scope, Symbol::kFunction);
        for (const ast::Fablet& fablet : analysis_.tree().fablets) {
            begin(fablet.name, Symbol::kClass, fablet.span, "fablet");
            for (const ast::Variable& v : fablet.uniforms)
                leaf(v.name, Symbol::kProperty, v.span, "uniform " + std::string(v.type.text));
            scope(fablet.scope, Symbol::kMethod);
            for (const ast::Stage& stage : fablet.stages)
                leaf(fmt::format("@{}", ast::stage_name(stage.kind)), Symbol::kMethod, stage.span,
                     "stage");
            end();
        }
        out_->end_array();
    }

  private:
    void scope(const ast::Scope& scope, Symbol function) {
        for (const ast::Struct& record : scope.structs) {
            begin(record.name, Symbol::kStruct, record.span, "struct");
            for (const ast::Variable& v : record.members)
                leaf(v.name, Symbol::kProperty, v.span, std::string(v.type.text));
            end();
        }
        for (const ast::Enum& names : scope.enums) {
            begin(names.name, Symbol::kEnum, names.span, "enum");
            for (const ast::Variable& v : names.items)
                leaf(v.name, Symbol::kEnumMember, v.span, "int");
            end();
        }
        for (const ast::Variable& v : scope.constants)
            leaf(v.name, Symbol::kConstant, v.span, std::string(v.type.text));
        for (const ast::Function& f : scope.functions)
            leaf(f.name, function, f.span, std::string(f.return_type.text));
    }

    void leaf(std::string_view name, Symbol kind, const source::Span& at,
              const std::string& detail) {
        begin(name, kind, at, detail);
        end();
    }

    void begin(std::string_view name, Symbol kind, const source::Span& at,
               const std::string& detail) {
        // The protocol allows no empty name.
        out_->begin_object().member("name", name.empty() ? "?" : std::string(name));
        out_->member("detail", detail).member("kind", static_cast<int32_t>(kind));
        const source::Span all = extent(at);
        out_->key("range");
        query_.write_range(out_, all.begin, all.end);
        out_->key("selectionRange");
        query_.write_range(out_, at.begin, at.end);
        out_->key("children").begin_array();
    }
    void end() { out_->end_array().end_object(); }

    /// Returns a declaration's bytes, from the start of its line's code to its last brace or semicolon.
    source::Span extent(const source::Span& name) const {
        const std::vector<syntax::Token>& tokens = analysis_.tokens();
        size_t first = analysis_.token_at(name.begin);
        while (tokens[first].span.begin > name.begin && first > 0)
            --first;
        size_t last = first;
        while (first > 0 && !tokens[first - 1].is(";") && !tokens[first - 1].is("}") &&
               !tokens[first - 1].is("{") && !tokens[first - 1].is(","))
            --first;
        while (last + 1 < tokens.size()) {
            if (tokens[last].is(";") || tokens[last].is("}") || tokens[last].is(",")) break;
            const bool body = tokens[last].is("{");
            if (tokens[last].is("(") || tokens[last].is("[") || body)
                last = std::max(last, analysis_.matching(last));
            if (body) break;
            // What is not closed matches the last token.
            if (last + 1 < tokens.size()) ++last;
        }
        return {name.file, std::min(tokens[first].span.begin, name.begin),
                std::max(tokens[last].span.end, name.end)};
    }

    const Query& query_;
    const Analysis& analysis_;
    JsonText* out_;
};

struct Look {
    Token type = Token::kNone;
    int32_t modifiers = 0;
};

Look look_of(const check::Use& use) {
    Look out;
    if (use.span == use.declared) out.modifiers |= kDeclaration;
    if (use.kind == check::UseKind::kFunction) {
        out.type = Token::kFunction;
        return out;
    }
    if (use.is_const) out.modifiers |= kReadonly;
    if (use.kind == check::UseKind::kMember) {
        out.type = Token::kProperty;
        return out;
    }
    switch (use.symbol) {
        case check::SymbolKind::kType:
            out.type = Token::kStruct;
            break;
        case check::SymbolKind::kUniform:
            out.type = Token::kProperty;
            out.modifiers |= kReadonly;
            break;
        case check::SymbolKind::kVoid:
            out.type = Token::kVariable;
            out.modifiers |= kDefaultLibrary;
            break;
        case check::SymbolKind::kConstant:
        case check::SymbolKind::kLocal:
            out.type = Token::kVariable;
            break;
        case check::SymbolKind::kParameter:
        case check::SymbolKind::kSurfaceInput:
        case check::SymbolKind::kSurfaceOutput:
        case check::SymbolKind::kShapeOutput:
        case check::SymbolKind::kGrowParent:
        case check::SymbolKind::kNearest:
        case check::SymbolKind::kAttributes:
            out.type = Token::kParameter;
            break;
    }
    return out;
}

/// Returns how to show a name that refers to no declaration.
Look built_in_look(const std::vector<syntax::Token>& tokens, size_t at) {
    const auto before = [&](std::string_view text) { return at > 0 && tokens[at - 1].is(text); };
    if (before("@")) return {Token::kDecorator, 0};
    if (before("import")) return {Token::kNamespace, 0};
    if (before("fablet")) return {Token::kClass, kDeclaration};
    const bool called = at + 1 < tokens.size() && tokens[at + 1].is("(");
    if (before(".")) return {called ? Token::kMethod : Token::kProperty, 0};
    if (!check::find_type(tokens[at].text).is_error()) return {Token::kType, kDefaultLibrary};
    if (called && !reference_of(tokens[at].text).empty())
        return {Token::kFunction, kDefaultLibrary};
    return {};
}

}  // namespace

void document_symbols(const Query& query, JsonText* out) {
    Outline(query, out).file();
}

void semantic_legend(JsonText* out) {
    out->begin_object().key("tokenTypes").begin_array();
    for (const char* name : kTokenTypes)
        out->value(name);
    out->end_array().key("tokenModifiers").begin_array();
    for (const char* name : kTokenModifiers)
        out->value(name);
    out->end_array().end_object();
}

void semantic_tokens(const Query& query, JsonText* out) {
    std::map<uint32_t, const check::Use*> uses;
    for (const check::Use& use : query.analysis->names()) {
        if (use.span.file == Analysis::kDocument) uses.emplace(use.span.begin, &use);
    }
    const std::vector<syntax::Token>& tokens = query.analysis->tokens();
    out->begin_object().key("data").begin_array();
    Position last;
    for (size_t i = 0; i < tokens.size(); ++i) {
        if (tokens[i].kind != syntax::TokenKind::kIdentifier) continue;
        const auto use = uses.find(tokens[i].span.begin);
        const Look look = use != uses.end() ? look_of(*use->second) : built_in_look(tokens, i);
        if (look.type == Token::kNone) continue;
        const Position at =
            query.document->text.position(tokens[i].span.begin, query.workspace->encoding);
        const bool same_line = at.line == last.line;
        out->value(at.line - last.line)
            .value(same_line ? at.character - last.character : at.character);
        out->value(static_cast<int64_t>(tokens[i].text.size()));  // names are ASCII
        out->value(static_cast<int32_t>(look.type)).value(look.modifiers);
        last = at;
    }
    out->end_array().end_object();
}

}  // namespace openfab::server
