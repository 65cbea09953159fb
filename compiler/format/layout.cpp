// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/layout.h"

#include <algorithm>
#include <utility>

#include "compiler/format/format.h"

namespace openfab::format {

namespace {

/// Arguments begin on the next line where their list would begin behind this column.
constexpr int kLastAlignment = 80;

int width_of(std::string_view text) {
    return static_cast<int>(source::count_code_points(text));
}

bool is_number(const syntax::Token& token) {
    return token.kind == syntax::TokenKind::kInt || token.kind == syntax::TokenKind::kUint ||
           token.kind == syntax::TokenKind::kFloat;
}

/// True if two tokens would become others when written without a space, or a comment stands between.
bool needs_space(const Word& before, const Word& after) {
    const char last = before.text.empty() ? ' ' : before.text.back();
    const char first = after.text.empty() ? ' ' : after.text.front();
    return after.begins_with_note() || (last == first && (first == '+' || first == '-')) ||
           (is_number(before.token) && first == '.');
}

/// Adds a part to what a node knows of itself on one line.
void count(Node* node, const Node& part, bool space, bool first) {
    if (first) {
        node->begins_with_lines = part.begins_with_lines;
    } else if (part.begins_with_lines || node->ends_line) {
        node->width = Node::kBroken;
    }
    node->ends_line = part.ends_line;
    node->width = std::min(node->width + part.width + (space && !first ? 1 : 0), Node::kBroken);
}

const Word& last_word(const Node& node) {
    if (node.kind == Node::Kind::kWord) return *node.word;
    return node.close.empty() ? last_word(node.kids.back()) : *node.close.back();
}

bool closes_with_space(const Node& list, const Word& close) {
    const bool padded = list.padded && &close == list.close.front();
    return !list.kids.empty() && (padded || close.begins_with_note());
}

}  // namespace

const Word& Node::first() const {
    if (kind == Kind::kWord) return *word;
    return kind == Kind::kList ? *open.front() : kids.front().first();
}

Node word_node(const Word& word, bool space) {
    Node out;
    out.kind = Node::Kind::kWord;
    out.word = &word;
    out.space = space;
    out.width = width_of(word.text);
    for (const Comment& comment : word.before) {
        if (comment.ends_line) continue;
        out.width += width_of(comment.text) + (word.is_tight() ? 0 : 1);
        if (comment.text.find('\n') != std::string_view::npos) out.width = Node::kBroken;
    }
    out.begins_with_lines = word.begins_with_lines();
    out.ends_line = !word.after.empty();
    return out;
}

void add(Node* node, Node kid, bool space) {
    const bool first = node->kids.empty();
    kid.space = space || (!first && needs_space(last_word(*node), kid.first()));
    count(node, kid, kid.space, first);
    node->kids.push_back(std::move(kid));
}

void close_list(Node* list) {
    Node line;  // the list on one line
    for (const Word* word : list->open)
        count(&line, word_node(*word), false, word == list->open.front());
    for (const Node& kid : list->kids) {
        const bool first = &kid == &list->kids.front();
        count(&line, kid, first ? list->padded : kid.space, false);
    }
    for (const Word* word : list->close) {
        const bool space = closes_with_space(*list, *word);
        count(&line, word_node(*word), space, false);
    }
    list->width = list->rows || list->hung ? Node::kBroken : line.width;
    list->begins_with_lines = line.begins_with_lines;
    list->ends_line = line.ends_line;
}

void Writer::start_line(int indent, bool may_be_blank) {
    pending_ = true;
    indent_ = indent;
    may_be_blank_ = may_be_blank && !out_.empty();
}

/// Starts a line inside a statement.
void Writer::continue_line(int indent) {
    start_line(indent, false);
}

/// Makes room for what comes next: a line, or a space.
void Writer::begin(bool space, bool blank) {
    if (pending_) {
        while (out_.ends_with(' '))
            out_.pop_back();
        if (!out_.empty()) out_ += '\n';
        if (blank && may_be_blank_) out_ += '\n';
        out_.append(static_cast<size_t>(indent_), ' ');
        column_ = line_indent_ = indent_;
        pending_ = false;
    } else if (space || after_comment_) {
        out_ += ' ';
        ++column_;
    }
    may_be_blank_ = false;
    after_comment_ = false;
}

void Writer::text(std::string_view text) {
    out_ += text;
    column_ += width_of(text);
}

/// Writes a comment; the further lines of a block move with the first.
void Writer::comment(const Comment& comment, bool space) {
    begin(space, comment.blank_before);
    const int moved = comment.own_line ? column_ - comment.column : 0;
    for (size_t at = 0; at <= comment.text.size();) {
        const size_t end = std::min(comment.text.find('\n', at), comment.text.size());
        std::string_view line = comment.text.substr(at, end - at);
        line = line.substr(0, line.find_last_not_of(" \t\r\f\v") + 1);
        if (at > 0) {
            out_ += '\n';
            const size_t blank = std::min(line.find_first_not_of(' '), line.size());
            const auto old = static_cast<size_t>(comment.column);
            if (moved != 0 && blank >= old && !line.empty()) {
                out_.append(static_cast<size_t>(column_), ' ');
                line.remove_prefix(old);
            }
        }
        out_ += line;
        at = end + 1;
    }
    if (comment.text.find('\n') == std::string_view::npos) column_ += width_of(comment.text);
}

void Writer::lines_before(const Word& word, int indent) {
    size_t lines = word.before.size();
    while (lines > 0 && !word.before[lines - 1].ends_line)
        --lines;
    for (size_t i = 0; i < lines; ++i) {
        comment(word.before[i], true);
        if (word.before[i].ends_line) start_line(indent);
    }
    written_before_ = lines;
}

void Writer::word(const Word& word, bool space) {
    const size_t written = std::exchange(written_before_, 0);
    for (size_t i = written; i < word.before.size(); ++i) {
        const Comment& note = word.before[i];
        if (note.own_line && note.ends_line && !pending_) continue_line(indent_);
        comment(note, space || note.ends_line || i > 0);
        if (note.ends_line) continue_line(indent_);
        after_comment_ = !note.ends_line;
    }
    if (word.is_tight()) after_comment_ = false;
    if (word.begins_with_note()) space = false;
    begin(space, word.blank_before);
    text(word.text);
    for (const Comment& note : word.after)
        comment(note, true);
    if (!word.after.empty()) continue_line(indent_);
}

bool Writer::fits(const Node& node, bool space, int tail) const {
    return column() + (space && !pending_ ? 1 : 0) + node.width + tail <= kLineWidth;
}

void Writer::node(const Node& node, bool space, int tail) {
    switch (node.kind) {
        case Node::Kind::kWord:
            return word(*node.word, space);
        case Node::Kind::kSequence:
            for (size_t i = 0; i < node.kids.size(); ++i) {
                int rest = tail;
                for (size_t k = i + 1; k < node.kids.size(); ++k)
                    rest += node.kids[k].kind == Node::Kind::kWord
                                ? node.kids[k].width + (node.kids[k].space ? 1 : 0)
                                : 0;
                this->node(node.kids[i], i == 0 ? space : node.kids[i].space, rest);
            }
            return;
        case Node::Kind::kChain:
        case Node::Kind::kChoice:
        case Node::Kind::kList:
            break;
    }
    const int before = indent_;
    if (node.kind == Node::Kind::kList) {
        for (const Word* open : node.open)
            word(*open, open == node.open.front() && space);
        list(node, tail);
    } else {
        // What is broken continues under its first operand.
        if (!pending_) indent_ = column_ + (space ? 1 : 0);
        if (space && !pending_) begin(true, false);
        node.kind == Node::Kind::kChain ? chain(node, tail) : choice(node, tail);
    }
    indent_ = before;
}

void Writer::chain(const Node& node, int tail) {
    const int align = column();
    const bool whole = fits(node, false, tail);
    for (size_t i = 0; i < node.kids.size(); i += 2) {
        const Node& operand = node.kids[i];
        const bool last = i + 1 >= node.kids.size();
        const int rest = last ? tail : node.kids[i + 1].width + (node.kids[i + 1].space ? 1 : 0);
        if (i > 0 && !whole && !fits(operand, true, rest) && column() > align) continue_line(align);
        this->node(operand, i > 0, rest);
        if (!last) word(*node.kids[i + 1].word, node.kids[i + 1].space);
    }
}

void Writer::choice(const Node& node, int tail) {
    const int align = column();
    const bool whole = fits(node, false, tail);
    this->node(node.kids[0], false, 2);
    if (!whole && !fits(node.kids[2], true, 2)) continue_line(align + kIndent);
    const int under = column() + (pending_ ? 0 : 1);
    word(*node.kids[1].word, true);
    this->node(node.kids[2], true, whole ? 2 : 0);
    if (!whole) continue_line(under);
    word(*node.kids[3].word, true);
    this->node(node.kids[4], true, tail);
}

void Writer::list(const Node& node, int tail) {
    int closing = tail;
    for (const Word* close : node.close)
        closing += width_of(close->text);
    if (node.padded) ++closing;
    const bool hung = node.hung;
    const int base = line_indent_;
    if (node.kids.empty()) {
        for (const Word* close : node.close)
            word(*close, false);
        return;
    }
    const int start = column() + (node.padded ? 1 : 0);
    int opening = 0;
    for (const Word* open : node.open)
        opening += width_of(open->text);
    const bool whole = column() - opening + node.width + tail <= kLineWidth;
    indent_ = start;
    if (hung || (!whole && !node.hanging && start > kLastAlignment)) {
        continue_line(base + kIndent);
        list_items(node, indent_, hung ? 0 : closing);
        if (hung) continue_line(base);
    } else {
        list_items(node, node.hanging ? base + kIndent : start, closing);
    }
    for (const Word* close : node.close)
        word(*close, closes_with_space(node, *close));
}

void Writer::list_items(const Node& node, int align, int tail) {
    bool fresh = true;
    for (size_t i = 0; i < node.kids.size(); ++i) {
        const Node& kid = node.kids[i];
        if (kid.is_separator) {
            word(*kid.word, kid.space);
            continue;
        }
        int rest = tail;
        if (i + 1 < node.kids.size() && node.kids[i + 1].is_separator)
            rest = i + 2 < node.kids.size() ? 1 : tail + 1;
        const bool row = node.rows && kid.first().fresh_line;
        if (!fresh && (row || (!fits(kid, true, rest) && column() > align))) continue_line(align);
        this->node(kid, fresh ? node.padded : kid.space, rest);
        fresh = false;
    }
}

std::string Writer::take() {
    if (!out_.empty()) out_ += '\n';
    return std::move(out_);
}

}  // namespace openfab::format
