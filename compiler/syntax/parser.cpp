// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/parser.h"

#include <algorithm>
#include <cctype>

#include "compiler/syntax/foreign_syntax.h"
#include "compiler/syntax/operators.h"
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

ast::File Parser::parse_file() {
    ast::File file;
    file.begin = peek().span;
    while (!at_end()) {
        const size_t before = at_;
        if (at("fablet")) {
            parse_fablet(&file);
        } else if (at_foreign_fablet()) {
            begin_item();
            if (diag::Diagnostic* d = expected("`fablet`")) d->replace(peek().span, "fablet");
            parse_fablet(&file);
        } else if (at("import") || at_from_import()) {
            parse_import(&file);
        } else if (at("@")) {
            begin_item();
            if (diag::Diagnostic* d = expected("`fablet`")) {
                d->help("stages and uniforms belong inside a fablet: `fablet Name { … }`");
            }
            last_error_ = ~size_t{0};
            take();
            skip_to_member();
            while (at("@")) {
                take();
                skip_to_member();
            }
        } else {
            parse_member(nullptr, &file.scope);
        }
        if (at_ == before) take();
    }
    begin_item();
    file.end = peek().span;
    file.damaged = std::move(damaged_);
    return file;
}

/// `enum` is a word of the language only before what declares one, so that it may still be a name.
bool Parser::at_enum() const {
    return at_identifier() && peek().text == "enum" && (at_identifier(1) || peek(1).is("{"));
}

/// Recognizes `from color import skin_of`.
bool Parser::at_from_import() const {
    return at_identifier() && peek().text == "from" && at_identifier(1) && peek(2).is("import");
}

void Parser::parse_import(ast::File* file) {
    begin_item();
    if (at_from_import()) {
        file->imports.push_back({peek(1).text, peek(1).span});
        diag::Diagnostic* d = expected("`import`");
        const size_t name = at_ + 1;
        while (!at(";") && !at_end() && (at_ <= name + 1 || !on_fresh_line()))
            take();
        if (d != nullptr)
            d->replace(between(first_, at_ - 1), "import " + std::string(tokens_[name].text));
        accept(";");
        return;
    }
    take();
    if (!at_identifier()) {
        if (diag::Diagnostic* d = expected("a module's name after `import`")) {
            d->help("write the name alone: `import color;`");
            std::string name(peek().text);
            if (name.ends_with(".fl")) name.resize(name.size() - 3);
            const bool word = std::all_of(name.begin(), name.end(), [](char c) {
                return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
            });
            if (peek().kind == TokenKind::kString && word && !name.empty())
                d->replace(peek().span, name);
        }
        // Reports `import "name"` and `import a.b`, the syntax of other languages.
        while (!at(";") && !at_end() && !on_fresh_line())
            take();
        accept(";");
        return;
    }
    file->imports.push_back({peek().text, peek().span});
    take();
    parse_import_tail();
    expect(";", "the module's name");
}

void Parser::parse_fablet(ast::File* file) {
    begin_item();
    take();
    ast::Fablet fablet;
    fablet.span = peek().span;
    if (at_identifier()) {
        fablet.name = take().text;
    } else {
        expected("the fablet's name");
    }
    if (!at("{") && last_error_ != at_) {
        if (diag::Diagnostic* d = expected("`{` after the fablet's name")) {
            d->help("a fablet has no parameters and no parent: `fablet Name { … }`");
        }
        while (!at("{") && !at(";") && !at("}") && !at_end())
            take();
    }
    const size_t open = at_;
    if (!accept("{")) {
        skip_to_member();
        return;
    }
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (at("fablet")) break;
        if (!parse_marker(&fablet)) parse_member(&fablet, &fablet.scope);
        if (at_ == before) take();
    }
    if (!braces_differ_ || at("}")) expect_close("}", "the fablet's members", open);
    accept(";");
    file->fablets.push_back(std::move(fablet));
}

/// Recognizes `shader Name {`, `class Name {`, `Fablet Name {`.
bool Parser::at_foreign_fablet() const {
    if (!at_identifier() || !at_identifier(1) || !(peek(2).is("{") || peek(2).is("(")))
        return false;
    if (at_enum() || peek().text == "class") return false;
    for (const char* word : {"Fablet", "FABLET", "shader", "surface", "material", "volume"}) {
        if (peek().text == word) return true;
    }
    return peek(2).is("{");
}

void Parser::parse_direction(ast::Variable* v) {
    while (at("in") || at("out") || at("inout") || at("const")) {
        const Token& word = take();
        if (word.text == "const") v->is_const = true;
        if (word.text == "in" || word.text == "inout") v->is_in = true;
        if (word.text == "out" || word.text == "inout") v->is_out = true;
    }
}

/// Parses `struct Name { … } variables;` with its semicolon.
bool Parser::parse_struct(ast::Struct* out, std::vector<ast::Variable>* variables, bool is_const) {
    take();
    out->span = peek().span;
    if (!at_identifier()) {
        expected("the struct's name");
        return false;
    }
    out->name = take().text;
    const size_t open = at_;
    if (!expect("{", "the struct's name")) return false;
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        begin_item();
        if (parse_method(out->name)) continue;
        if (!at_identifier()) {
            expected("a member's type");
            skip_to_statement_end();
        } else if (!parse_variables(false, &out->members)) {
            skip_to_statement_end();
        }
        if (at_ == before) take();
    }
    if (!expect_close("}", "the struct's members", open)) return false;
    if (accept(";")) return true;
    if (!at_identifier()) return expect(";", "the struct");
    return parse_declarators({out->name, out->span}, is_const, variables);
}

/// Skips `static`, which is redundant for a constant.
bool Parser::parse_static() {
    const bool found =
        at_identifier() && peek().text == "static" && (at_identifier(1) || peek(1).is("const"));
    if (found) take();
    return found;
}

/// Parses a constant or a function, of a fablet or of the file (fablet null).
void Parser::parse_member(ast::Fablet* fablet, ast::Scope* scope) {
    if (accept(";")) return;
    begin_item();
    if (parse_operator()) return;
    if (at("import")) {
        expected("a fablet's member");
        return skip_to_member();
    }
    if (at_identifier() && peek(1).is("@") && fablet != nullptr) {
        if (diag::Diagnostic* d = expected("a member of the fablet")) {
            d->help("a stage has no type before it").replace(peek().span, "");
        }
        take();
        return;
    }
    if (at_enum()) {
        ast::Enum item;
        const bool ok = parse_enum(&item);
        if (!item.name.empty()) scope->enums.push_back(std::move(item));
        if (!ok) skip_to_member();
        return;
    }
    // `inline float f(…)`: a declaration follows the word.
    const bool foreign_word =
        at_identifier() && at_identifier(1) && at_identifier(2) && peek().text != "class" &&
        !foreign_syntax({peek().text, {}, {}, {}}).help.empty() && peek().text != "uniform";
    if (foreign_word) {
        expected("a declaration");
        take();
    }
    parse_static();
    if (fablet == nullptr && at_identifier() && peek().text == "uniform" && at_identifier(1) &&
        at_identifier(2)) {
        sink_->report(peek().span, diag::kMissingAt, "uniform")
            .help("uniforms go inside the fablet: `@uniform { float x; }`");
        return skip_to_member();
    }
    if (at_identifier() && at_identifier(1) && peek(2).is("(")) return parse_function(scope);
    const bool is_const = accept("const");
    if (is_const) parse_static();
    const bool of_class =
        at_identifier() && peek().text == "class" && at_identifier(1) && peek(2).is("{");
    if (of_class) expected("`struct`");
    if (at("struct") || of_class) {
        ast::Struct record;
        const bool ok = parse_struct(&record, &scope->constants, is_const);
        if (!record.name.empty()) scope->structs.push_back(std::move(record));
        if (!ok) skip_to_member();
        return;
    }
    if (at_identifier() && at_identifier(1)) {
        if (!parse_variables(is_const, &scope->constants)) skip_to_member();
        return;
    }
    if (!braces_differ_) {
        diag::Diagnostic* d = expected_declaration(
            fablet != nullptr ? "a stage, `@uniform`, a constant, a struct or a function"
                              : "`fablet`, a constant, a struct or a function");
        if (at("}")) braces_differ_ = true;
        if (d != nullptr && at_ > 0 && tokens_[at_ - 1].is("}") && d->helps.empty()) {
            d->note(tokens_[at_ - 1].span,
                    "this `}` closes the block before it; is it one too many?");
            braces_differ_ = true;
        }
    }
    if (at("}")) take();
    skip_to_member();
}

void Parser::parse_function(ast::Scope* scope) {
    ast::Function f;
    f.return_type = {peek().text, peek().span};
    take();
    f.span = peek().span;
    f.name = take().text;
    const size_t open = at_;
    take();
    bool understood = true;
    while (!at(")") && !at_end()) {
        if (!parse_parameter(&f)) {
            understood = false;
            while (!at(",") && !at(")") && !at("{") && !at("}") && !at_end())
                skip_balanced();
        }
        if (!accept(",")) break;
    }
    expect_close(")", "the parameters", open);
    if (!at("{")) {
        diag::Diagnostic* d = understood ? expected("the function's body in `{ }`") : nullptr;
        if (d != nullptr && at(";")) {
            d->help("functions may be called before they are defined: remove this declaration");
        }
        return skip_to_member();
    }
    f.body = parse_block();
    scope->functions.push_back(std::move(f));
}

bool Parser::parse_parameter(ast::Function* function) {
    ast::Variable v;
    refuse_static();
    parse_direction(&v);
    if (!at_identifier()) {
        expected("a parameter's type");
        return false;
    }
    const ast::TypeRef type{peek().text, peek().span};
    take();
    parse_reference(type, &v);
    if (!at_identifier()) {
        diag::Diagnostic* d = expected("a name");
        if (d != nullptr && d->helps.empty()) {
            d->help("a parameter is a type and a name: `float x`");
            if (at(":") && at_identifier(1)) {
                const std::string right = std::string(peek(1).text) + " " + std::string(type.text);
                d->replace(between(at_ - 1, at_ + 1), right);
            }
        }
        return false;
    }
    const bool ok = parse_declarator(type, &v);
    if (ok) function->parameters.push_back(std::move(v));
    return ok;
}

/// Skips a `static` that has no meaning here.
void Parser::refuse_static() {
    const source::Span word = peek().span;
    if (!parse_static()) return;
    sink_->report(word, diag::kBadDeclaration, "only a constant or a function can be `static`")
        .help("leave out `static`")
        .replace(word, "");
}

/// Parses `type a = 1, b;` with its semicolon.
bool Parser::parse_variables(bool is_const, std::vector<ast::Variable>* out) {
    refuse_static();
    const ast::TypeRef type{peek().text, peek().span};
    take();
    return parse_declarators(type, is_const, out);
}

bool Parser::parse_declarators(const ast::TypeRef& type, bool is_const,
                               std::vector<ast::Variable>* out) {
    do {
        ast::Variable v;
        v.is_const = is_const;
        if (!parse_declarator(type, &v)) return false;
        out->push_back(std::move(v));
    } while (accept(","));
    if (at(";")) return expect(";", "the declaration");
    const ast::Variable& last = out->back();
    const bool hyphen = at("-") && at_identifier(1) && touch(at_ - 1) && touch(at_);
    const bool another = at_identifier() && !on_fresh_line() && last.init == nullptr;
    const bool annotation = at("[");
    const bool value = !on_fresh_line() && last.init == nullptr &&
                       (peek().kind == TokenKind::kInt || peek().kind == TokenKind::kFloat);
    if (!at("(") && !at("{") && !hyphen && !another && !annotation && !value)
        return expect(";", "the declaration");
    diag::Diagnostic* d = expected("`;` after the declaration");
    if (d == nullptr || !d->helps.empty()) return false;
    if (hyphen) {
        d->help("a name has letters, digits and `_`").replace(peek().span, "_");
    } else if (annotation) {
        d->help("annotations stand in two brackets, each with a type: `[[ float min = 0 ]]`");
    } else if (value) {
        d->help("a value stands behind `=`").insert_before(peek().span, "= ");
    } else if (another && is_builtin_type_name(last.name) && out->size() > 1) {
        // `float a, int b;`
        d->help("a `;` stands between declarations of different types")
            .replace({last.span.file, tokens_[at_ - 2].span.begin, tokens_[at_ - 2].span.end}, ";");
    } else if (another && is_builtin_type_name(last.name)) {
        // `constexpr float x`
        d->help("a declaration begins with its type: leave out `" + std::string(type.text) + "`");
    } else if (another) {
        d->help("a comma stands between names").insert_after(tokens_[at_ - 1].span, ",");
    } else {
        help_with_initializer(type, last, d);
    }
    return false;
}

bool Parser::parse_declarator(const ast::TypeRef& type, ast::Variable* out) {
    out->type = type;
    parse_type_parameters();
    if (at("[") && !parse_size_first(out)) return false;
    out->span = peek().span;
    if (!at_identifier()) {
        diag::Diagnostic* d = expected("a name");
        if (d == nullptr) return false;
        if (peek().kind == TokenKind::kKeyword && !at("const"))
            d->help("`" + std::string(peek().text) +
                    "` is a word of the language: choose another name");
        if (at("*") || at("&")) d->help("there are no pointers or references");
        if (at("const")) d->help("`const` stands before the type: `const float a = 1`");
        if (peek().kind == TokenKind::kInt || peek().kind == TokenKind::kFloat) {
            d->help("a vector is written `float3(1, 2, 3)`, a decimal point is `.`");
            const bool comma =
                at_ > 1 && tokens_[at_ - 1].is(",") && tokens_[at_ - 2].kind == TokenKind::kInt;
            if (comma) d->replace(tokens_[at_ - 1].span, ".");
        }
        return false;
    }
    out->name = take().text;
    const source::Span brackets = peek().span;
    while (at("[") && !peek(1).is("[")) {
        take();
        out->extents.push_back(at("]") ? nullptr : parse_conditional());
        if (!expect("]", "the array's size")) return false;
        out->array_span = span_to_previous(brackets);
    }
    if (accept("=")) out->init = parse_initializer();
    if (at("[") && peek(1).is("[")) parse_annotations(out);
    return !gave_up_;
}

void Parser::parse_annotations(ast::Variable* variable) {
    take();
    take();
    while (!at("]") && !at_end()) {
        ast::Annotation a;
        a.type = {peek().text, peek().span};
        if (at_identifier() && peek(1).is("=")) {
            diag::Diagnostic* d = expected("an annotation, such as `float min = 0`");
            const bool text = peek(2).kind == TokenKind::kString;
            if (d != nullptr) d->insert_before(peek().span, text ? "string " : "float ");
        } else if (!at_identifier() || !at_identifier(1)) {
            expected("an annotation, such as `float min = 0`");
            while (!at("]") && !at(";") && !at("}") && !at_end())
                take();
            break;
        } else {
            take();
        }
        a.span = peek().span;
        a.name = take().text;
        if (expect("=", "the annotation's name")) a.value = parse_assignment();
        variable->annotations.push_back(std::move(a));
        if (at(";") && at_identifier(1)) {
            if (diag::Diagnostic* d = expected("`,` between annotations"))
                d->replace(peek().span, ",");
            take();
            continue;
        }
        if (!accept(",")) break;
    }
    if (expect("]", "the annotations")) expect("]", "`]`: annotations end with `]]`");
}

ast::File parse(const source::SourceManager& sources, const std::vector<Token>& tokens,
                diag::Sink* sink) {
    return Parser(sources, tokens, sink).parse_file();
}

}  // namespace openfab::syntax
