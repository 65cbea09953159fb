// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <utility>

#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

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
    const size_t open = at_;
    take();
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (at_member_marker() || at("fablet")) break;  // a brace is missing
        block->body.push_back(parse_statement());
        if (at_ == before) take();
    }
    block->span = peek().span;
    if (!braces_differ_) {
        const bool uniform = at_member_marker() && peek(1).text == "uniform";
        expect_close("}", "the statements of the block", open,
                     uniform ? "`@uniform` belongs in the fablet, outside its stages" : nullptr);
    } else {
        accept("}");
    }
    return block;
}

ast::StmtPtr Parser::parse_statement() {
    const Level level(this);
    if (!level.ok) return stmt(ast::StmtKind::kBad);
    begin_item();
    skip_attribute();
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

/// Parses a condition in parentheses; if both are missing, one message says so.
void Parser::parse_condition(const char* after, ast::Stmt* out) {
    const size_t open = at_;
    const size_t errors = sink_->errors();
    if (!at("(") && !is_follow_up()) {
        // `if x > 0 {`
        diag::Diagnostic& d = sink_->report(peek().span, diag::kExpected,
                                            std::string("`(` after ") + after, describe(peek()));
        d.help(std::string("a condition stands in parentheses, what follows in braces: ") +
               "`if (x > 0) { … }`");
        note_error(first_);
        const size_t found = sink_->errors();
        const size_t begin = at_;
        out->expr = parse_expression();
        if (found == errors + 1 && sink_->errors() == found && at_ > begin && at("{"))
            d.insert_before(tokens_[begin].span, "(").insert_after(tokens_[at_ - 1].span, ")");
        if (!accept(")")) accept(":");
        return;
    }
    const bool bracket = accept("(");
    out->expr = parse_expression();
    if (bracket) {
        if (!expect_close(")", "the condition", open)) {
            // Skips the rest of a condition that does not parse.
            while (!at(")") && !at("{") && !at("}") && !at(";") && !at_end())
                skip_balanced();
            accept(")");
        }
    } else {
        accept(")");
    }
    if (!at(":")) return;
    if (diag::Diagnostic* d = expected("a statement")) {
        d->helps.clear();
        d->help(std::string("what follows stands in braces: `") +
                (std::string_view(after) == "`while`" ? "while" : "if") + " (x > 0) { … }`");
    }
    take();
}

ast::StmtPtr Parser::parse_if() {
    ast::StmtPtr out = stmt(ast::StmtKind::kIf);
    take();
    parse_condition("`if`", out.get());
    if (at_identifier() && peek().text == "then") {
        expected("a statement");
        take();
    }
    out->body.push_back(parse_body());
    if (accept("else")) out->body.push_back(parse_body());
    return out;
}

ast::StmtPtr Parser::parse_for() {
    ast::StmtPtr out = stmt(ast::StmtKind::kFor);
    take();
    if (parse_foreign_loop(out.get())) return out;
    if (!at("(")) {
        diag::Diagnostic* d = expected("`(` after `for`");
        if (d != nullptr) d->help("a loop is written `for (int i = 0; i < 4; ++i) { … }`");
        while (!at("{") && !at("}") && !at(";") && !at_end())
            skip_balanced();
        out->kind = ast::StmtKind::kBad;
        if (at("{")) parse_block();
        return out;
    }
    take();
    if (at_declaration()) {
        out->init = stmt(ast::StmtKind::kDeclaration);
        const bool is_const = parse_local_qualifiers();
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
    parse_condition("`while`", out.get());
    out->body.push_back(parse_body());
    return out;
}

ast::StmtPtr Parser::parse_do() {
    ast::StmtPtr out = stmt(ast::StmtKind::kDo);
    take();
    out->body.push_back(parse_body());
    if (!accept("while")) {
        expected("`while` after the body of `do`");
        if (!on_fresh_line()) skip_to_statement_end();
        return out;
    }
    parse_condition("`while`", out.get());
    expect(";", "`do … while (…)`");
    return out;
}

/// Parses `@bound(n)` and the loop that it applies to.
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
    const size_t open = at_;
    if (!expect("{", "the value of `switch`")) return out;
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        if (at_member_marker() || at("fablet")) break;
        out->body.push_back(parse_statement());
        if (at_ == before) take();
    }
    expect_close("}", "the cases", open);
    return out;
}

/// Parses the label alone; the statements after it belong to the `switch`.
ast::StmtPtr Parser::parse_case() {
    ast::StmtPtr out = stmt(ast::StmtKind::kCase);
    out->text = take().text;
    if (out->text == "case") out->expr = parse_conditional();
    expect(":", out->text == "case" ? "the value of `case`" : "`default`");
    return out;
}

bool Parser::at_member_marker() const {
    const std::string_view word = peek(1).text;
    return at("@") && (stage_of(word) || word == "uniform");
}

/// Reports `float[3] a`, the array syntax of other languages.
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
    // `float in = 1;`: a word of the language in place of a name
    if (at_identifier() && peek(1).kind == TokenKind::kKeyword && !peek(1).is("const") &&
        (peek(2).is("=") || peek(2).is(";")))
        return true;
    return at("const") || (at_identifier() && (at_identifier(1) || peek(1).is("const")));
}

/// Parses `const` and `static` before a local variable's type, in any order; returns whether it is
/// `const`.
bool Parser::parse_local_qualifiers() {
    const source::Span first = peek().span;
    const bool is_static = parse_static();
    const bool is_const = accept("const");
    if (is_const) parse_static();
    if (is_static && !is_const) {
        sink_
            ->report(first, diag::kBadDeclaration,
                     "`static` without `const`: nothing is kept from voxel to voxel")
            .help("leave out `static`, or write `static const` for what does not change")
            .replace(first, "");
    }
    return is_const;
}

/// After a missing semicolon at the end of a line nothing is skipped: a statement follows.
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
        const bool is_const = parse_local_qualifiers();
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

}  // namespace openfab::syntax
