// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compiler/check/signatures.h"
#include "compiler/server/answers.h"
#include "compiler/server/reference.h"

namespace openfab::server {

namespace {

/// CompletionItemKind of the protocol.
enum class Kind : int32_t {
    kMethod = 2,
    kFunction = 3,
    kField = 5,
    kVariable = 6,
    kModule = 9,
    kProperty = 10,
    kKeyword = 14,
    kSnippet = 15,
    kConstant = 21,
    kStruct = 22,
    kTypeParameter = 25,
};

class Items {
  public:
    explicit Items(JsonText* out) : out_(out) { out_->begin_array(); }
    ~Items() { out_->end_array(); }
    Items(const Items&) = delete;
    Items& operator=(const Items&) = delete;

    /// Adds an item; `rank` sorts, and of equal labels the first counts, but for overloads.
    void add(const std::string& label, Kind kind, const std::string& detail,
             const std::string& text, char rank, const std::string& snippet = {}) {
        if (!known_.insert(label + "\n" + detail).second) return;
        out_->begin_object().member("label", label).member("kind", static_cast<int32_t>(kind));
        if (!detail.empty()) out_->member("detail", detail);
        if (!text.empty())
            out_->key("documentation")
                .begin_object()
                .member("kind", "markdown")
                .member("value", text)
                .end_object();
        out_->member("sortText", std::string(1, rank) + label);
        if (!snippet.empty()) out_->member("insertText", snippet).member("insertTextFormat", 2);
        out_->end_object();
    }
    bool has(const std::string& label) const {
        const auto found = known_.lower_bound(label + "\n");
        return found != known_.end() && found->starts_with(label + "\n");
    }

  private:
    JsonText* out_;
    std::set<std::string> known_;
};

constexpr const char* kSnippets[][2] = {
    {"fablet",
     "fablet ${1:Name} {\n    @uniform {\n        Material ${2:body};\n    }\n\n    "
     "@Volume(@varying { "
     "VolumeAttributes attr })\n    {\n        MaterialComposition mc;\n        mc.Set(${2:body}, "
     "1);\n"
     "        return mc;\n    }\n}"},
    {"@Surface",
     "@Surface(@varying { SurfaceAttributes attr })\n{\n    return attr.n * ${1:0};\n}"},
    {"@Volume",
     "@Volume(@varying { VolumeAttributes attr })\n{\n    MaterialComposition mc;\n    $0\n    "
     "return mc;\n}"},
    {"@Dither",
     "@Dither(@varying { DitherAttributes attr })\n{\n    int largest = 0;\n    for (int i = 1; i "
     "< "
     "attr.count; ++i) {\n        if (attr.Fraction(i) > attr.Fraction(largest)) largest = i;\n    "
     "}\n    return ${0:largest};\n}"},
    {"@Shape",
     "@Shape(@varying { ShapeAttributes attr })\n{\n    return length(attr.p) - ${1:10};\n}"},
    {"@Grow",
     "struct Node {\n    float3 end[2];\n    float radius;\n    int children;\n    float "
     "reach;\n};\n"
     "@Grow(@varying { GrowAttributes attr, Node parent })\n{\n    Node node = parent;\n    $0\n   "
     " "
     "return node;\n}"},
    {"@uniform", "@uniform {\n    $0\n}"},
    {"for", "for (int ${1:i} = 0; ${1:i} < ${2:4}; ++${1:i}) {\n    $0\n}"},
    {"if", "if (${1:condition}) {\n    $0\n}"},
};

constexpr const char* kKeywords[] = {"break",  "case",   "const",  "continue", "default",
                                     "do",     "else",   "fablet", "false",    "for",
                                     "if",     "import", "in",     "inout",    "out",
                                     "return", "struct", "switch", "true",     "while"};

void add_reference(const std::string& name, Kind kind, char rank, Items* items) {
    for (const ReferenceEntry& entry : reference_of(name))
        items->add(name, kind, entry.form, entry.text, rank);
    if (!items->has(name)) items->add(name, kind, "", "", rank);
}

void complete_members(const Analysis& analysis, const check::Type& type, Items* items) {
    const auto add = [&](const std::vector<check::StructMember>& members) {
        for (const check::StructMember& m : members)
            items->add(m.name, Kind::kField, check::type_name(m.type),
                       m.span.file == 0 ? std::string() : analysis.comment_above(m.span), '0');
    };
    if (type.is_attributes()) add(check::attribute_members(type));
    if (type.is(check::Base::kDitherAttributes)) {
        for (const char* name : {"Fraction", "BlueNoise"})
            add_reference(name, Kind::kMethod, '0', items);
    }
    if (type.is(check::Base::kStruct) && type.record != nullptr) add(type.record->members);
    if (type.is(check::Base::kSurfacePoint)) {
        add(check::common_point_members());
        for (const check::Fablet& fablet : analysis.program().fablets)
            add(fablet.point_members);
    }
    if (type.is(check::Base::kComposition)) {
        for (const char* name : {"Set", "Add", "Get", "Total", "Clear"})
            add_reference(name, Kind::kMethod, '0', items);
    }
    if (type.is(check::Base::kTexture2D) || type.is(check::Base::kTexture3D)) {
        for (const char* name : {"Sample1", "Sample2", "Sample3", "Sample4"})
            add_reference(name, Kind::kMethod, '0', items);
    }
    if (type.is_vector()) {
        check::Type scalar = type;
        scalar.size = 1;
        for (const char* set : {"xyzw", "rgba"}) {
            for (int i = 0; i < type.size; ++i)
                items->add(std::string(1, set[i]), Kind::kField, check::type_name(scalar), "",
                           set[0] == 'x' ? '0' : '1');
            std::string all = std::string(set).substr(0, static_cast<size_t>(type.size));
            items->add(all, Kind::kField, check::type_name(type), "", set[0] == 'x' ? '0' : '1');
        }
    }
}

Kind kind_of(const check::Use& use) {
    if (use.symbol == check::SymbolKind::kType) return Kind::kStruct;
    if (use.symbol == check::SymbolKind::kUniform) return Kind::kProperty;
    return use.is_const ? Kind::kConstant : Kind::kVariable;
}

/// Adds the names that are declared and can be used here.
void complete_names(const Query& query, Items* items) {
    const Analysis& analysis = *query.analysis;
    for (const check::Use& use : analysis.names()) {
        if (use.kind != check::UseKind::kSymbol || use.span != use.declared) continue;
        if (use.span.file != Analysis::kDocument) {
            const bool shared = use.symbol == check::SymbolKind::kConstant ||
                                use.symbol == check::SymbolKind::kType;
            if (!shared || !analysis.is_imported(use.span, use.name)) continue;
        } else {
            const source::Span scope = analysis.scope_of(use.span.begin);
            const bool later =
                use.span.begin >= query.offset && use.symbol != check::SymbolKind::kUniform;
            if (later || query.offset < scope.begin || query.offset > scope.end) continue;
        }
        items->add(use.name, kind_of(use), check::type_name(use.type), describe(analysis, use),
                   '1');
    }
    for (const check::Function* f : analysis.functions(""))
        items->add(f->name, Kind::kFunction, signature(*f), analysis.comment_above(f->span), '2');
}

void complete_modules(const Query& query, Items* items) {
    for (const std::string& name : frontend::modules_beside(query.document->path.parent_path())) {
        if (name != query.document->path.stem())
            items->add(name, Kind::kModule, name + ".fl", "", '0');
    }
    for (const std::string& name : frontend::library_modules())
        items->add(name, Kind::kModule, "standard library", "", '1');
}

}  // namespace

void complete(const Query& query, JsonText* out) {
    const Analysis& analysis = *query.analysis;
    Items items(out);
    if (analysis.in_comment_or_string(query.offset)) return;
    const std::vector<syntax::Token>& tokens = analysis.tokens();
    size_t before = analysis.token_before(query.offset);
    // The word that is being typed does not count.
    const auto is_word = [](const syntax::Token& t) {
        return t.kind == syntax::TokenKind::kIdentifier || t.kind == syntax::TokenKind::kKeyword;
    };
    if (before < tokens.size() && tokens[before].span.end == query.offset &&
        is_word(tokens[before]))
        before = before == 0 ? tokens.size() : before - 1;
    const syntax::Token none;
    const syntax::Token& left = before < tokens.size() ? tokens[before] : none;
    if (left.is(".")) {
        const uint32_t end = before > 0 ? tokens[before - 1].span.end : 0;
        if (const auto type = analysis.type_ending_at(end))
            complete_members(analysis, *type, &items);
        return;
    }
    if (left.is("@")) {
        for (std::string_view name : markers())
            items.add(std::string(name), Kind::kKeyword, "", std::string(marker_text(name)), '0');
        return;
    }
    if (left.is("import")) return complete_modules(query, &items);
    complete_names(query, &items);
    for (const std::string& name : check::function_names())
        add_reference(name, Kind::kFunction, '3', &items);
    for (const std::string& name : check::type_names())
        items.add(name, Kind::kTypeParameter, "type", "", '3');
    for (const char* word : kKeywords)
        items.add(word, Kind::kKeyword, "", "", '4');
    for (const auto& [label, text] : kSnippets)
        items.add(label, Kind::kSnippet, "…", "", '5', text);
}

void signature_help(const Query& query, JsonText* out) {
    const Analysis& analysis = *query.analysis;
    const std::vector<syntax::Token>& tokens = analysis.tokens();
    // The innermost bracket that is open here and follows a name.
    int argument = 0;
    int depth = 0;
    size_t at = analysis.token_before(query.offset);
    size_t callee = tokens.size();
    for (; at < tokens.size() && callee == tokens.size(); --at) {
        const syntax::Token& t = tokens[at];
        if (t.is(";") || t.is("{") || t.is("}")) break;
        if (t.is(")") || t.is("]")) ++depth;
        if (t.is("(") || t.is("[")) --depth;
        if (t.is(",") && depth == 0) ++argument;
        if (depth >= 0) continue;
        if (t.is("(") && at > 0 && tokens[at - 1].kind == syntax::TokenKind::kIdentifier)
            callee = at - 1;
        argument = callee == tokens.size() ? 0 : argument;
        depth = 0;
    }
    if (callee == tokens.size()) {
        out->null();
        return;
    }
    const std::string name(tokens[callee].text);
    const bool method = callee > 0 && tokens[callee - 1].is(".");
    int32_t active = -1;
    int32_t count = 0;
    out->begin_object().key("signatures").begin_array();
    const auto functions =
        method ? std::vector<const check::Function*>() : analysis.functions(name);
    for (const check::Function* f : functions) {
        if (active < 0 && static_cast<size_t>(argument) < f->parameters.size()) active = count;
        ++count;
        out->begin_object().member("label", signature(*f)).key("parameters").begin_array();
        for (const std::string& p : parameters(*f))
            out->begin_object().member("label", p).end_object();
        out->end_array().key("documentation").begin_object().member("kind", "markdown");
        out->member("value", analysis.comment_above(f->span)).end_object().end_object();
    }
    for (const ReferenceEntry& entry : reference_of(name)) {
        const std::vector<std::string_view> parameters = check::parameters_of(entry.form);
        if (active < 0 && static_cast<size_t>(argument) < parameters.size()) active = count;
        ++count;
        out->begin_object().member("label", entry.form).key("parameters").begin_array();
        for (std::string_view p : parameters)
            out->begin_object().member("label", std::string(p)).end_object();
        out->end_array().key("documentation").begin_object().member("kind", "markdown");
        out->member("value", entry.text).end_object().end_object();
    }
    out->end_array()
        .member("activeSignature", std::max(active, 0))
        .member("activeParameter", argument)
        .end_object();
}

}  // namespace openfab::server
