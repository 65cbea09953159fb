// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tokens with the comments around them; private to compiler/format.

#include <algorithm>
#include <string_view>
#include <vector>

#include "compiler/syntax/token.h"

namespace openfab::format {

struct Comment {
    std::string_view text;  ///< without white space at its end
    int column = 0;         ///< where it began
    bool own_line = false;  ///< nothing but white space stands before it on its line
    bool ends_line = false;
    bool blank_before = false;  ///< an empty line stands before it
};

/// A token, and what the author did around it.
struct Word {
    syntax::Token token;
    std::string_view text;        ///< as written; a string with its quotes
    std::vector<Comment> before;  ///< on lines of their own, or in its line
    std::vector<Comment> after;   ///< at the end of its line
    bool fresh_line = false;      ///< a line begins between the token before and this one
    bool blank_before = false;    ///< an empty line stands directly before it

    bool is(std::string_view text) const { return token.is(text); }
    bool is_identifier() const { return token.kind == syntax::TokenKind::kIdentifier; }
    /// True for what stands without a space behind a comment.
    bool is_tight() const { return is(",") || is(";") || is(")") || is("]"); }
    /// True if a comment stands before it in its line.
    bool begins_with_note() const { return !before.empty() && !before.back().ends_line; }
    /// True if it begins with a comment that takes lines of its own.
    bool begins_with_lines() const {
        return std::any_of(before.begin(), before.end(),
                           [](const Comment& c) { return c.ends_line; });
    }
};

/// Returns the tokens of a file, kEnd last, with its comments.
std::vector<Word> words_of(const source::SourceManager& sources, uint32_t file,
                           const std::vector<syntax::Token>& tokens);

/// True if both have the same tokens and the same comments, white space in comments aside.
bool same_words(const std::vector<Word>& a, const std::vector<Word>& b);

}  // namespace openfab::format
