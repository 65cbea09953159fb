// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/parser.h"

#include <algorithm>

#include "compiler/diag/suggest.h"
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

namespace {

std::string describe(const Token& token) {
    if (token.kind == TokenKind::kEnd) return "the end of the file";
    if (token.kind == TokenKind::kString) return "a string";
    constexpr size_t kMaxShown = 40;
    const std::string_view shown = token.text.substr(0, kMaxShown);
    return "`" + std::string(shown) + (shown.size() < token.text.size() ? "…`" : "`");
}

}  // namespace

// --- errors

void Parser::expected(std::string_view what) {
    if (gave_up_ || last_error_ == at_) return;
    last_error_ = at_;
    sink_->report(peek().span, diag::kExpected, what, describe(peek()));
}

bool Parser::expect(std::string_view text, const char* after) {
    if (accept(text)) return true;
    if (gave_up_ || last_error_ == at_) return false;
    last_error_ = at_;
    // The place where it belongs: behind what came before.
    source::Span span = peek().span;
    if (at_ > 0) span.begin = span.end = tokens_[at_ - 1].span.end;
    const std::string what = "`" + std::string(text) + "` after " + after;
    diag::Diagnostic& d = sink_->report(span, diag::kExpected, what, describe(peek()));
    if (text == ";") d.insert_before(span, ";");
    return false;
}

void Parser::give_up() {
    if (!gave_up_) sink_->report(peek().span, diag::kTooDeep, kMaxDepth);
    gave_up_ = true;
    at_ = tokens_.size() - 1;
}

/// Over one token, or from an opening bracket to the one that closes it.
void Parser::skip_balanced() {
    size_t open = 0;
    do {
        if (at("(") || at("{") || at("[")) ++open;
        if (open > 0 && (at(")") || at("}") || at("]"))) --open;
        take();
    } while (open > 0 && !at_end());
}

void Parser::skip_to_statement_end() {
    while (!at_end() && !at("}")) {
        if (accept(";")) return;
        const bool block = at("{");
        skip_balanced();
        if (block) return;
    }
}

/// To the next thing that can start a member of a fablet.
void Parser::skip_to_member() {
    while (!at_end() && !at("}") && !at("@") && !at("fablet")) {
        if (accept(";")) return;
        const bool block = at("{");
        skip_balanced();
        if (block) return;
    }
}

// --- declarations

ast::File Parser::parse_file() {
    ast::File file;
    while (!at_end()) {
        const size_t before = at_;
        if (at("fablet")) {
            parse_fablet(&file);
        } else if (at("import")) {
            parse_import(&file);
        } else if (at("@")) {
            expected("`fablet`: a stage or a uniform stands inside one");
            take();
            skip_to_member();
        } else {
            parse_member(nullptr, &file.scope);
        }
        if (at_ == before) take();
    }
    file.end = peek().span;
    return file;
}

void Parser::parse_import(ast::File* file) {
    take();
    if (!at_identifier()) {
        expected("a module's name after `import`");
        // `import "name"` and `import a.b` are habits from elsewhere.
        while (!at(";") && !at_end() && !on_fresh_line())
            take();
        accept(";");
        return;
    }
    file->imports.push_back({peek().text, peek().span});
    take();
    expect(";", "the module's name");
}

void Parser::parse_fablet(ast::File* file) {
    take();
    ast::Fablet fablet;
    fablet.span = peek().span;
    if (at_identifier()) {
        fablet.name = take().text;
    } else {
        expected("the fablet's name");
    }
    if (!expect("{", "the fablet's name")) {
        skip_to_member();
        return;
    }
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (at("fablet")) break;
        if (!parse_marker(&fablet)) parse_member(&fablet, &fablet.scope);
        if (at_ == before) take();
    }
    expect("}", "the fablet's members");
    accept(";");
    file->fablets.push_back(std::move(fablet));
}

/// The word behind `@`, or a known word whose `@` was left out; takes both. Empty where there is
/// neither.
std::string_view Parser::marker_word(std::initializer_list<const char*> known) {
    if (at("@")) {
        const source::Span begin = take().span;
        if (!at_identifier()) {
            expected("a marker's name behind `@`");
            return "?";
        }
        const Token& word = take();
        for (const char* candidate : known) {
            if (word.text == candidate) return word.text;
        }
        const std::vector<std::string> candidates(known.begin(), known.end());
        const std::string near = diag::suggest(word.text, candidates);
        diag::Diagnostic& d =
            sink_->report(span_to_previous(begin), diag::kUnknownMarker, word.text);
        if (near.empty()) return "?";
        d.help("did you mean `@" + near + "`?").replace(word.span, near);
        for (const char* candidate : known) {
            if (near == candidate) return candidate;  // go on as if it were right
        }
        return "?";
    }
    for (const char* candidate : known) {
        const bool starts =
            peek(1).is("{") || peek(1).is("(") || (at_identifier(1) && at_identifier(2));
        if (at_identifier() && peek().text == candidate && starts) {
            const Token& word = take();
            sink_->report(word.span, diag::kMissingAt, word.text)
                .help("write `@" + std::string(word.text) + "`")
                .insert_before(word.span, "@");
            last_error_ = at_;  // what is not right behind it is no second mistake
            return word.text;
        }
    }
    return "";
}

bool Parser::parse_marker(ast::Fablet* fablet) {
    const source::Span begin = peek().span;
    const std::string_view word = marker_word({"uniform", "Surface", "Volume"});
    if (word.empty()) return false;
    if (word == "uniform") {
        parse_uniforms(fablet);
    } else if (word == "Surface" || word == "Volume") {
        parse_stage(fablet, word == "Surface", span_to_previous(begin));
    } else {
        while (at("(") || at("{"))
            skip_balanced();
    }
    return true;
}

void Parser::parse_uniforms(ast::Fablet* fablet) {
    if (!expect("{", "`@uniform`")) return skip_to_member();
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (!at_identifier()) {
            expected("a uniform's type");
            skip_to_statement_end();
        } else if (!parse_variables(false, &fablet->uniforms)) {
            skip_to_statement_end();
        }
        if (at_ == before) take();
    }
    expect("}", "the uniforms");
    accept(";");
}

void Parser::parse_stage(ast::Fablet* fablet, bool surface, const source::Span& span) {
    ast::Stage stage;
    stage.surface = surface;
    stage.span = span;
    if (expect("(", surface ? "`@Surface`" : "`@Volume`")) {
        parse_varyings(&stage);
        while (!at(")") && !at("{") && !at("}") && !at_end()) {
            expected("`)` after the varyings");
            skip_balanced();
        }
        accept(")");
    }
    if (at("{")) {
        stage.body = parse_block();
    } else {
        expected("the stage's body in `{ }`");
        skip_to_member();
    }
    fablet->stages.push_back(std::move(stage));
}

void Parser::parse_varyings(ast::Stage* stage) {
    if (at(")")) return;
    const std::string_view word = marker_word({"varying"});
    if (word != "varying") {
        if (word.empty()) expected("`@varying`");
        return;
    }
    if (!expect("{", "`@varying`")) return;
    while (!at("}") && !at_end()) {
        if (!parse_varying(stage)) {
            while (!at(",") && !at(";") && !at("}") && !at_end())
                skip_balanced();
        }
        if (at(";")) {
            expected("`,` between varyings");
            take();
            continue;
        }
        if (!accept(",")) break;
    }
    expect("}", "the varyings");
}

bool Parser::parse_varying(ast::Stage* stage) {
    ast::Variable v;
    if (marker_word({"nearest"}) == "nearest") v.nearest = true;
    parse_direction(&v);
    if (!at_identifier()) {
        expected("a varying's type");
        return false;
    }
    const ast::TypeRef type{peek().text, peek().span};
    take();
    const bool ok = parse_declarator(type, &v);
    if (ok) stage->varyings.push_back(std::move(v));
    return ok;
}

void Parser::parse_direction(ast::Variable* v) {
    while (at("in") || at("out") || at("inout") || at("const")) {
        const Token& word = take();
        if (word.text == "const") v->is_const = true;
        if (word.text == "in" || word.text == "inout") v->is_in = true;
        if (word.text == "out" || word.text == "inout") v->is_out = true;
    }
}

/// `struct Name { … } variables;` with its semicolon.
bool Parser::parse_struct(ast::Struct* out, std::vector<ast::Variable>* variables, bool is_const) {
    take();
    out->span = peek().span;
    if (!at_identifier()) {
        expected("the struct's name");
        return false;
    }
    out->name = take().text;
    if (!expect("{", "the struct's name")) return false;
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (!at_identifier()) {
            expected("a member's type");
            skip_to_statement_end();
        } else if (!parse_variables(false, &out->members)) {
            skip_to_statement_end();
        }
        if (at_ == before) take();
    }
    if (!expect("}", "the struct's members")) return false;
    if (accept(";")) return true;
    if (!at_identifier()) return expect(";", "the struct");
    return parse_declarators({out->name, out->span}, is_const, variables);
}

/// Over `static`, which says of a constant what `const` says.
bool Parser::parse_static() {
    const bool found =
        at_identifier() && peek().text == "static" && (at_identifier(1) || peek(1).is("const"));
    if (found) take();
    return found;
}

/// A constant or a function, of a fablet or of the file (fablet null).
void Parser::parse_member(ast::Fablet* fablet, ast::Scope* scope) {
    if (accept(";")) return;
    if (at("import")) {
        expected("a fablet's member: an `import` stands outside the fablet");
        return skip_to_member();
    }
    parse_static();
    if (fablet == nullptr && at_identifier() && peek().text == "uniform" && at_identifier(1) &&
        at_identifier(2)) {
        sink_->report(peek().span, diag::kMissingAt, "uniform")
            .help("uniforms stand in a fablet: `@uniform { float x; }`");
        return skip_to_member();
    }
    if (at_identifier() && at_identifier(1) && peek(2).is("(")) return parse_function(scope);
    const bool is_const = accept("const");
    if (at("struct")) {
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
    expected(fablet != nullptr ? "a stage, `@uniform`, a constant, a struct or a function"
                               : "`fablet`, a constant, a struct or a function");
    skip_to_member();
}

void Parser::parse_function(ast::Scope* scope) {
    ast::Function f;
    f.return_type = {peek().text, peek().span};
    take();
    f.span = peek().span;
    f.name = take().text;
    take();
    while (!at(")") && !at_end()) {
        if (!parse_parameter(&f)) {
            while (!at(",") && !at(")") && !at("{") && !at("}") && !at_end())
                skip_balanced();
        }
        if (!accept(",")) break;
    }
    expect(")", "the parameters");
    if (!at("{")) {
        expected("the function's body in `{ }`");
        return skip_to_member();
    }
    f.body = parse_block();
    scope->functions.push_back(std::move(f));
}

bool Parser::parse_parameter(ast::Function* function) {
    ast::Variable v;
    parse_direction(&v);
    if (!at_identifier()) {
        expected("a parameter's type");
        return false;
    }
    const ast::TypeRef type{peek().text, peek().span};
    take();
    const bool ok = parse_declarator(type, &v);
    if (ok) function->parameters.push_back(std::move(v));
    return ok;
}

/// `type a = 1, b;` with its semicolon.
bool Parser::parse_variables(bool is_const, std::vector<ast::Variable>* out) {
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
    return expect(";", "the declaration");
}

bool Parser::parse_declarator(const ast::TypeRef& type, ast::Variable* out) {
    out->type = type;
    out->span = peek().span;
    if (!at_identifier()) {
        expected(at("[") ? "a name: the size of an array stands behind it, `float a[3]`"
                         : "a name");
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
        if (!at_identifier() || !at_identifier(1)) {
            expected("an annotation, such as `float min = 0`");
            while (!at("]") && !at(";") && !at("}") && !at_end())
                take();
            break;
        }
        take();
        a.span = peek().span;
        a.name = take().text;
        if (expect("=", "the annotation's name")) a.value = parse_assignment();
        variable->annotations.push_back(std::move(a));
        if (!accept(",")) break;
    }
    if (expect("]", "the annotations")) expect("]", "`]`: annotations end with `]]`");
}

// --- statements

ast::StmtPtr Parser::stmt(ast::StmtKind kind) const {
    auto out = std::make_unique<ast::Stmt>();
    out->kind = kind;
    out->span = peek().span;
    return out;
}

ast::StmtPtr Parser::parse_block() {
    const Level level(this);
    ast::StmtPtr block = stmt(ast::StmtKind::kBlock);
    if (!level.ok) return block;
    take();
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (at_member_marker()) break;  // a stage begins: a brace was forgotten
        block->body.push_back(parse_statement());
        if (at_ == before) take();
    }
    block->span = peek().span;
    expect("}", "the statements of the block");
    return block;
}

ast::StmtPtr Parser::parse_statement() {
    const Level level(this);
    if (!level.ok) return stmt(ast::StmtKind::kBad);
    if (at("{")) return parse_block();
    if (at("if")) return parse_if();
    if (at("for")) return parse_for();
    if (at("while")) return parse_while();
    if (at("do")) return parse_do();
    if (at("switch")) return parse_switch();
    if (at("case") || at("default")) return parse_case();
    if (at("@")) return parse_bounded();
    if (at(";")) {
        ast::StmtPtr out = stmt(ast::StmtKind::kEmpty);
        take();
        return out;
    }
    return parse_simple();
}

ast::StmtPtr Parser::parse_body() {
    return parse_statement();
}

ast::StmtPtr Parser::parse_if() {
    ast::StmtPtr out = stmt(ast::StmtKind::kIf);
    take();
    expect("(", "`if`");
    out->expr = parse_expression();
    expect(")", "the condition");
    out->body.push_back(parse_body());
    if (accept("else")) out->body.push_back(parse_body());
    return out;
}

ast::StmtPtr Parser::parse_for() {
    ast::StmtPtr out = stmt(ast::StmtKind::kFor);
    take();
    expect("(", "`for`");
    if (at_declaration()) {
        out->init = stmt(ast::StmtKind::kDeclaration);
        const bool is_const = accept("const");
        if (!parse_variables(is_const, &out->init->variables)) skip_to_statement_end();
    } else if (!accept(";")) {
        out->init = stmt(ast::StmtKind::kExpression);
        out->init->expr = parse_expression();
        expect(";", "the start of `for`");
    }
    if (!at(";")) out->expr = parse_expression();
    expect(";", "the condition of `for`");
    if (!at(")")) out->step = parse_expression();
    expect(")", "the step of `for`");
    out->body.push_back(parse_body());
    return out;
}

ast::StmtPtr Parser::parse_while() {
    ast::StmtPtr out = stmt(ast::StmtKind::kWhile);
    take();
    expect("(", "`while`");
    out->expr = parse_expression();
    expect(")", "the condition");
    out->body.push_back(parse_body());
    return out;
}

ast::StmtPtr Parser::parse_do() {
    ast::StmtPtr out = stmt(ast::StmtKind::kDo);
    take();
    out->body.push_back(parse_body());
    if (!accept("while")) {
        expected("`while` after the body of `do`");
        return out;
    }
    expect("(", "`while`");
    out->expr = parse_expression();
    expect(")", "the condition");
    expect(";", "`do … while (…)`");
    return out;
}

/// `@bound(n)` and the loop that it is about.
ast::StmtPtr Parser::parse_bounded() {
    const source::Span begin = peek().span;
    const bool known = marker_word({"bound"}) == "bound";
    const source::Span span = span_to_previous(begin);
    ast::ExprPtr bound;
    if (known && expect("(", "`@bound`")) {
        bound = parse_conditional();
        expect(")", "the bound");
    } else if (at("(")) {
        skip_balanced();
    }
    const bool loop = at("for") || at("while") || at("do");
    if (known && !loop) expected("a loop after `@bound(…)`");
    ast::StmtPtr out = parse_statement();
    if (loop) {
        out->bound = std::move(bound);
        out->bound_span = span;
    }
    return out;
}

ast::StmtPtr Parser::parse_switch() {
    ast::StmtPtr out = stmt(ast::StmtKind::kSwitch);
    take();
    expect("(", "`switch`");
    out->expr = parse_expression();
    expect(")", "the value of `switch`");
    if (!expect("{", "the value of `switch`")) return out;
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        out->body.push_back(parse_statement());
        if (at_ == before) take();
    }
    expect("}", "the cases");
    return out;
}

/// The label alone; what follows it are statements of the `switch`.
ast::StmtPtr Parser::parse_case() {
    ast::StmtPtr out = stmt(ast::StmtKind::kCase);
    out->text = take().text;
    if (out->text == "case") out->expr = parse_conditional();
    expect(":", out->text == "case" ? "the value of `case`" : "`default`");
    return out;
}

bool Parser::at_member_marker() const {
    const std::string_view word = peek(1).text;
    return at("@") && (word == "Surface" || word == "Volume" || word == "uniform");
}

/// `float[3] a`, which declares an array elsewhere.
bool Parser::at_array_type() const {
    if (!at_identifier() || !peek(1).is("[")) return false;
    size_t ahead = 2;
    while (at_ + ahead < tokens_.size() && !peek(ahead).is(";") &&
           (!peek(ahead).is("]") || peek(ahead + 1).is("["))) {
        ++ahead;
    }
    return peek(ahead).is("]") && at_identifier(ahead + 1);
}

bool Parser::at_declaration() const {
    if (at_array_type()) return true;
    return at("const") || (at_identifier() && (at_identifier(1) || peek(1).is("const")));
}

/// After a forgotten semicolon at the end of a line nothing is skipped: what follows is a
/// statement.
bool Parser::on_fresh_line() const {
    if (at_ == 0) return false;
    const source::Span& before = tokens_[at_ - 1].span;
    return sources_.locate(peek().span.file, peek().span.begin).line >
           sources_.locate(before.file, before.end).line;
}

ast::StmtPtr Parser::parse_simple() {
    ast::StmtPtr out = stmt(ast::StmtKind::kExpression);
    bool ok = true;
    if (at("return")) {
        out->kind = ast::StmtKind::kReturn;
        take();
        if (!at(";")) out->expr = at("{") ? parse_init_list() : parse_expression();
        ok = expect(";", "`return`");
    } else if (at("break") || at("continue")) {
        out->kind = at("break") ? ast::StmtKind::kBreak : ast::StmtKind::kContinue;
        out->text = take().text;
        ok = expect(";", out->kind == ast::StmtKind::kBreak ? "`break`" : "`continue`");
    } else if (at("struct")) {
        out->kind = ast::StmtKind::kDeclaration;
        out->record = std::make_unique<ast::Struct>();
        ok = parse_struct(out->record.get(), &out->variables, false);
    } else if (at_declaration()) {
        out->kind = ast::StmtKind::kDeclaration;
        parse_static();
        const bool is_const = accept("const");
        if (!at_identifier()) {
            expected("a type");
            ok = false;
        } else {
            ok = parse_variables(is_const, &out->variables);
        }
    } else {
        out->expr = parse_expression();
        ok = expect(";", "the statement");
    }
    if (!ok && !on_fresh_line()) skip_to_statement_end();
    return out;
}

ast::File parse(const source::SourceManager& sources, const std::vector<Token>& tokens,
                diag::Sink* sink) {
    return Parser(sources, tokens, sink).parse_file();
}

}  // namespace openfab::syntax
