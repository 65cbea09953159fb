// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The recursive-descent parser, private to compiler/syntax: declarations in parser.cpp, stages in
// parse_stage.cpp, statements in parse_stmt.cpp, expressions in parse_expr.cpp. After an error it
// skips to where it can resume; nesting deeper than kMaxDepth ends it.

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "compiler/syntax/foreign_syntax.h"
#include "compiler/syntax/parser.h"

namespace openfab::syntax {

/// Returns the stage that a marker begins, if any: "Surface" without its `@`.
std::optional<ast::StageKind> stage_of(std::string_view marker);

/// Returns a token as a message names it.
std::string describe(const Token& token);

class Parser {
  public:
    Parser(const source::SourceManager& sources, const std::vector<Token>& tokens, diag::Sink* sink)
        : sources_(sources), tokens_(tokens), sink_(sink) {}

    ast::File parse_file();

  private:
    /// Counts a level of nesting during its lifetime; `ok` is false beyond the limit.
    class Level {
      public:
        explicit Level(Parser* parser) : parser_(parser), ok(++parser->depth_ <= kMaxDepth) {
            if (!ok) parser_->give_up();
        }
        ~Level() { --parser_->depth_; }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;

      private:
        Parser* parser_;

      public:
        const bool ok;
    };

    const Token& peek(size_t ahead = 0) const {
        const size_t at = at_ + ahead;
        return at < tokens_.size() ? tokens_[at] : tokens_.back();
    }
    bool at(std::string_view text) const { return peek().is(text); }
    bool at_end() const { return peek().kind == TokenKind::kEnd; }
    bool at_identifier(size_t ahead = 0) const {
        return peek(ahead).kind == TokenKind::kIdentifier;
    }
    const Token& take() {
        const Token& token = peek();
        if (at_ + 1 < tokens_.size()) ++at_;
        return token;
    }
    bool accept(std::string_view text) {
        if (!at(text)) return false;
        take();
        return true;
    }
    source::Span span_to_previous(const source::Span& begin) const {
        source::Span span = begin;
        if (at_ > 0) span.end = std::max(span.end, tokens_[at_ - 1].span.end);
        return span;
    }

    // Errors. In a run of tokens that do not parse, only the first error is reported.
    bool expect(std::string_view text, const char* after);
    /// Expects the bracket that closes the one at token `open`, to which an error points.
    bool expect_close(std::string_view text, const char* after, size_t open,
                      const char* help = nullptr);
    /// Reports what was expected. Returns the message, to add help; null if it is suppressed.
    diag::Diagnostic* expected(std::string_view what);
    void begin_item();
    void note_error(size_t from);
    bool is_follow_up();
    void note_opening(size_t open, diag::Diagnostic* d) const;
    size_t suspicious_brace(size_t open) const;
    source::Location location(size_t token) const;
    size_t indentation(size_t token) const;
    void give_up();
    void skip_balanced();
    void skip_to_statement_end();
    void skip_to_member();

    // parser.cpp
    void parse_import(ast::File* file);
    void parse_fablet(ast::File* file);
    void parse_member(ast::Fablet* fablet, ast::Scope* scope);
    void parse_function(ast::Scope* scope);
    bool parse_parameter(ast::Function* function);
    bool parse_struct(ast::Struct* out, std::vector<ast::Variable>* variables, bool is_const);
    bool parse_enum(ast::Enum* out);  ///< parse_enum.cpp
    bool at_enum() const;
    bool parse_static();
    bool parse_local_qualifiers();
    void refuse_static();
    void parse_direction(ast::Variable* variable);
    bool parse_variables(bool is_const, std::vector<ast::Variable>* out);
    bool parse_declarators(const ast::TypeRef& type, bool is_const,
                           std::vector<ast::Variable>* out);
    bool parse_declarator(const ast::TypeRef& type, ast::Variable* out);
    void parse_annotations(ast::Variable* variable);
    bool at_foreign_fablet() const;
    bool at_from_import() const;

    // parse_stage.cpp
    bool parse_marker(ast::Fablet* fablet);
    void parse_uniforms(ast::Fablet* fablet);
    void parse_stage(ast::Fablet* fablet, ast::StageKind kind, const source::Span& span);
    void parse_claims(ast::Stage* stage);
    void parse_varyings(ast::Stage* stage);
    bool parse_varying(ast::Stage* stage);
    std::string_view marker_word(std::initializer_list<const char*> known);
    bool parse_bare_uniform(ast::Fablet* fablet);

    // parse_foreign.cpp: what other languages write, with its remedy.
    void add_foreign_help(diag::Diagnostic* d) const;
    void fix_foreign(const ForeignSyntax& found, diag::Diagnostic* d) const;
    void skip_attribute();
    void add_loop_fix(size_t header, diag::Diagnostic* d) const;
    bool parse_foreign_loop(ast::Stmt* out);
    void parse_reference(const ast::TypeRef& type, ast::Variable* out);
    void parse_argument_mark();
    bool parse_method(std::string_view record);
    bool parse_operator();
    void parse_import_tail();
    bool parse_size_first(ast::Variable* out);
    void parse_type_parameters();
    /// As expected(), where a declaration should begin.
    diag::Diagnostic* expected_declaration(std::string_view what);
    void help_with_initializer(const ast::TypeRef& type, const ast::Variable& last,
                               diag::Diagnostic* d) const;
    source::Span between(size_t first, size_t last) const {
        return {tokens_[first].span.file, tokens_[first].span.begin, tokens_[last].span.end};
    }
    bool touch(size_t left) const { return tokens_[left].span.end == tokens_[left + 1].span.begin; }
    std::string text_between(size_t first, size_t last) const {
        return std::string(sources_.text(between(first, last)));
    }
    /// Returns the bracket that closes the one at token `open`; the last token if there is none.
    size_t closing(size_t open) const;

    ast::StmtPtr parse_statement();
    ast::StmtPtr parse_block();
    void parse_condition(const char* after, ast::Stmt* out);
    ast::StmtPtr parse_if();
    ast::StmtPtr parse_for();
    ast::StmtPtr parse_while();
    ast::StmtPtr parse_do();
    ast::StmtPtr parse_switch();
    ast::StmtPtr parse_case();
    ast::StmtPtr parse_bounded();
    ast::StmtPtr parse_simple();
    bool at_declaration() const;
    bool at_array_type() const;
    bool at_member_marker() const;
    bool on_fresh_line() const;
    ast::StmtPtr stmt(ast::StmtKind kind) const;
    ast::StmtPtr parse_body();

    // parse_expr.cpp
    ast::ExprPtr parse_expression();  ///< with commas
    ast::ExprPtr parse_assignment();
    ast::ExprPtr parse_conditional();
    ast::ExprPtr parse_binary(int least);
    ast::ExprPtr parse_unary();
    ast::ExprPtr parse_postfix();
    ast::ExprPtr parse_primary();
    ast::ExprPtr parse_call(ast::ExprPtr callee);
    ast::ExprPtr parse_init_list();
    ast::ExprPtr parse_initializer();
    ast::ExprPtr parse_cast();
    ast::ExprPtr literal(ast::ExprKind kind);
    ast::ExprPtr node(ast::ExprKind kind, const Token& text, ast::ExprPtr a = nullptr,
                      ast::ExprPtr b = nullptr, ast::ExprPtr c = nullptr);
    void add_arg(ast::Expr* expr, ast::ExprPtr arg);

    const source::SourceManager& sources_;
    const std::vector<Token>& tokens_;
    diag::Sink* sink_;
    size_t at_ = 0;
    int depth_ = 0;
    size_t last_error_ = ~size_t{0};
    size_t error_item_ = ~size_t{0};  ///< `first_` at the last error
    size_t error_at_ = 0;
    size_t first_ = 0;  ///< token of the statement or declaration
    std::vector<source::Span> damaged_;
    std::optional<uint32_t> damage_;  ///< where the text begins that an error leaves not understood
    bool braces_differ_ = false;      ///< unmatched braces were reported: no further errors
    bool gave_up_ = false;
};

}  // namespace openfab::syntax
