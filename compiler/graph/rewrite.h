// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes of a document's text, collected by place and then made at once, through the formatter.

#include <set>
#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/server/analysis.h"

namespace openfab::graph {

class Rewrite {
  public:
    explicit Rewrite(const server::Analysis& analysis);

    /// Replaces bytes; changes inside of them that were made before are forgotten.
    void replace(const source::Span& span, const std::string& text);
    void remove(const source::Span& span) { replace(span, ""); }
    /// Removes lines from one byte to another, with the end of the last.
    void remove_line(uint32_t begin, uint32_t end);
    /// Inserts at a byte, behind what was inserted there before.
    void insert(uint32_t at, const std::string& text);
    /// Returns the text of bytes with the changes inside of them.
    std::string text(const source::Span& span) const;
    /// The same of an expression, without brackets around the whole.
    std::string expression(const source::Span& span) const;
    /// Returns a name that nothing in the document has; it is taken from now on.
    std::string fresh_name(std::string base);
    /// Returns statements with other names for what they declare, where these are taken; an error where brackets do not match.
    Result<std::string> with_fresh_names(const std::string& statements);
    void import(const std::string& module);
    /// Returns the document with all changes, formatted.
    Result<std::string> made();

  private:
    struct Change {
        uint32_t begin, end;
        std::string text;
    };
    void keep_comments();

    const server::Analysis& analysis_;
    std::vector<Change> changes_;
    std::set<std::string> taken_;
};

/// Whether a text is one operand: it needs no brackets beside an operator.
bool is_operand(const std::string& text);
/// Returns why a text cannot stand for an expression; empty if it can.
std::string why_no_expression(const std::string& text);
/// Whether a text can be the name of something.
bool is_name(const std::string& text);

}  // namespace openfab::graph
