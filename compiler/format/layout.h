// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nodes that fit on a line or are broken, and the text that grows line by line; private to compiler/format.
//
// Each node knows its width on one line, so one pass decides: a node that fits in the rest of the line stays whole; a
// broken one continues under its first operand or argument.

#include <string>
#include <vector>

#include "compiler/format/words.h"

namespace openfab::format {

struct Node {
    enum class Kind : uint8_t {
        kWord,      ///< word
        kSequence,  ///< kids, never broken between
        kChain,     ///< operand, operator, operand …; broken after operators
        kChoice,    ///< condition, `?`, value, `:`, value
        kList,      ///< kids: items and the separators after them, between `open` and `close` words
    };
    Kind kind = Kind::kSequence;
    const Word* word = nullptr;
    std::vector<Node> kids;
    bool space = false;         ///< a space stands before it, if it is not the first of a line
    bool is_separator = false;  ///< of a list
    std::vector<const Word*> open, close;
    bool padded = false;             ///< a list with spaces inside its brackets
    bool rows = false;               ///< a list that keeps the author's rows
    bool hung = false;               ///< and whose first row is on a line of its own
    bool hanging = false;            ///< a list whose further lines are indented once, not aligned
    int width = 0;                   ///< on one line; kBroken if it must be broken
    bool begins_with_lines = false;  ///< comments before it take lines of their own
    bool ends_line = false;          ///< a comment after it ends its line

    static constexpr int kBroken = 1 << 20;
    const Word& first() const;
    bool is_empty() const { return kind == Kind::kSequence && kids.empty(); }
};

Node word_node(const Word& word, bool space = false);
/// Adds a kid to a sequence, a chain or a choice.
void add(Node* node, Node kid, bool space);
/// Sets the width of a list whose brackets and kids are complete.
void close_list(Node* list);

/// The text so far. Every token and comment goes through `word`.
class Writer {
  public:
    /// Ends the line; what is written next begins one, after an empty line if the author left one and `may_be_blank`.
    void start_line(int indent, bool may_be_blank = true);
    void word(const Word& word, bool space);
    /// Writes the comments before a word, each on its own line, as lines of this indentation.
    void lines_before(const Word& word, int indent);
    /// Writes a node; `tail` is the width of what must follow on its last line.
    void node(const Node& node, bool space, int tail);

    /// The column of the next character.
    int column() const { return pending_ ? indent_ : column_; }
    /// True if a node and `tail` fit on the line.
    bool fits(const Node& node, bool space, int tail) const;
    std::string take();

  private:
    void chain(const Node& node, int tail);
    void choice(const Node& node, int tail);
    void list(const Node& node, int tail);
    void list_items(const Node& node, int align, int tail);
    void comment(const Comment& comment, bool space);
    void begin(bool space, bool blank);
    void text(std::string_view text);
    void continue_line(int indent);

    std::string out_;
    int column_ = 0;
    int indent_ = 0;       ///< of the lines that comments make necessary
    int line_indent_ = 0;  ///< of the current line
    bool pending_ = true;  ///< a new line is due
    bool may_be_blank_ = false;
    bool after_comment_ = false;  ///< one that did not end its line: a space follows
    size_t written_before_ = 0;   ///< comments before the next word, by lines_before
};

}  // namespace openfab::format
