// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walks the tokens of a file that has no syntax errors: declarations and statements in statements.cpp, expressions and
// lists in expressions.cpp; private to compiler/format. It needs less than the grammar: brackets, what begins a
// statement, and the precedence of operators.

#include <string>
#include <string_view>
#include <vector>

#include "compiler/format/layout.h"

namespace openfab::format {

class Formatter {
  public:
    explicit Formatter(const std::vector<Word>& words) : words_(words) {}

    /// Returns the text of the whole file.
    std::string file();

  private:
    const Word& peek(size_t ahead = 0) const {
        const size_t at = at_ + ahead;
        return at < words_.size() ? words_[at] : words_.back();
    }
    bool at(std::string_view text) const { return peek().is(text); }
    bool at_end() const { return at_ + 1 >= words_.size(); }
    const Word& take() { return words_[at_end() ? at_ : at_++]; }

    // statements.cpp
    void member(int indent);
    void declaration(int indent);
    void members(int indent);
    void function_body(int indent, const Node& header);
    void statement(int indent);
    void statements(int indent);
    void block(int indent);
    /// Writes what a condition or a loop governs; returns whether it is a block.
    bool body(int indent);
    void if_statement(int indent);
    void loop(int indent);
    void switch_statement(int indent);
    void label(int indent);
    void close_brace(int indent);
    bool is_simple() const;
    bool on_one_line() const;
    size_t matching(size_t open) const;

    // expressions.cpp
    Node simple();
    Node simple_up_to(std::string_view end);
    Node item();
    Node record();
    Node names_of_enum();
    bool at_prefix() const;
    Node prefix();
    Node assignment();
    Node conditional();
    Node binary(int level);
    Node unary();
    Node postfix();
    Node primary();
    Node list(size_t brackets, bool padded, bool keeps_rows);
    Node statement_list();
    Node for_header();

    const std::vector<Word>& words_;
    size_t at_ = 0;
    Writer out_;
};

}  // namespace openfab::format
