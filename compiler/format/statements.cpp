// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "compiler/format/format.h"
#include "compiler/format/formatter.h"

namespace openfab::format {

std::string Formatter::file() {
    while (!at_end())
        member(0);
    out_.start_line(0);
    out_.lines_before(peek(), 0);
    return out_.take();
}

/// Returns the bracket that closes the one at `open`.
size_t Formatter::matching(size_t open) const {
    int depth = 0;
    for (size_t i = open; i < words_.size(); ++i) {
        const Word& word = words_[i];
        if (word.is("(") || word.is("{") || word.is("[")) ++depth;
        if (word.is(")") || word.is("}") || word.is("]")) --depth;
        if (depth == 0) return i;
    }
    return words_.size() - 1;
}

/// True at a brace whose block the author wrote on one line.
bool Formatter::on_one_line() const {
    const size_t close = matching(at_);
    for (size_t i = at_; i <= close; ++i) {
        const bool first = i == at_;
        if (!first && (words_[i].fresh_line || !words_[i].before.empty())) return false;
        if (i < close && !words_[i].after.empty()) return false;
    }
    return true;
}

/// Writes a line or more for a declaration of the file, of a fablet or of a struct.
void Formatter::member(int indent) {
    if (at(";") && !peek().begins_with_lines() && at_ > 0) return out_.word(take(), false);
    out_.start_line(indent, at_ > 0 && !words_[at_ - 1].is("{"));
    out_.lines_before(peek(), indent);
    const size_t before = at_;
    declaration(indent);
    if (at_ == before) out_.word(take(), true);  // never the same place twice
}

void Formatter::declaration(int indent) {
    if (at("fablet") || at("struct")) {
        const bool record = at("struct");
        out_.word(take(), false);
        if (!at("{")) out_.word(take(), true);
        if (!record) return members(indent);
        members(indent);
        const bool names = !at(";");
        out_.node(simple(), names, 0);
        return;
    }
    if (peek().is_identifier() && peek().text == "enum" && peek(1).is_identifier())
        return out_.node(names_of_enum(), false, 0);
    if (at("@")) {
        Node header = prefix();
        if (at("(")) {
            add(&header, list(1, false, false), false);
            if (at("[") && peek(1).is("[")) add(&header, list(2, true, false), true);
            return function_body(indent, header);
        }
        out_.node(header, false, 2);
        return members(indent);
    }
    if (at("import")) {
        out_.word(take(), false);
        out_.node(simple(), true, 0);
        return;
    }
    Node header;
    const size_t start = at_;
    while (at_prefix())
        add(&header, prefix(), true);
    if (header.kids.empty() || !peek().is_identifier() || !peek(1).is("(")) {
        at_ = start;
        return out_.node(simple(), false, 0);
    }
    add(&header, word_node(take()), true);
    add(&header, list(1, false, false), false);
    function_body(indent, header);
}

/// Writes the members of a fablet, a struct or `@uniform`, in braces.
void Formatter::members(int indent) {
    const bool fablet = words_[at_ - 1].is_identifier() && at_ > 1 && words_[at_ - 2].is("fablet");
    if (!fablet && at("{") && on_one_line()) {
        const size_t start = at_;
        const Node list = statement_list();
        if (out_.fits(list, true, 1)) return out_.node(list, true, 0);
        at_ = start;
    }
    out_.word(take(), true);
    while (!at("}") && !at_end())
        member(indent + kIndent);
    close_brace(indent);
}

/// Writes a function's or a stage's header and body: on one line if the author wrote one statement so and it fits.
void Formatter::function_body(int indent, const Node& header) {
    out_.node(header, false, 0);
    const bool bare = at("{") && peek(1).is("}") && peek().after.empty() && peek().before.empty() &&
                      peek(1).before.empty();
    const size_t start = at_;
    bool one_line = bare;
    if (!bare && at("{") && on_one_line()) {
        ++at_;
        one_line = is_simple() && (simple(), at("}"));
        at_ = start;
    }
    if (one_line) {
        const Node list = statement_list();
        if (out_.fits(list, true, 0) && out_.column() > indent) return out_.node(list, true, 0);
        at_ = start;
    }
    out_.start_line(indent, false);
    block(indent);
}

/// Writes the brace that closes what began on a line of this indentation.
void Formatter::close_brace(int indent) {
    if (words_[at_ - 1].is("{") && words_[at_ - 1].after.empty() && !peek().begins_with_lines())
        return out_.word(take(), false);
    out_.start_line(indent + kIndent, !words_[at_ - 1].is("{"));
    out_.lines_before(peek(), indent + kIndent);
    out_.start_line(indent, false);
    out_.word(take(), false);
}

/// Writes statements in braces, the first at the end of the line.
void Formatter::block(int indent) {
    out_.word(take(), true);
    statements(indent + kIndent);
    close_brace(indent);
}

void Formatter::statements(int indent) {
    while (!at("}") && !at_end()) {
        out_.start_line(indent, !words_[at_ - 1].is("{"));
        out_.lines_before(peek(), indent);
        statement(indent);
    }
}

/// True at a statement without statements in it.
bool Formatter::is_simple() const {
    for (const char* word :
         {"{", "if", "for", "while", "do", "switch", "case", "default", "@", "struct"}) {
        if (at(word)) return false;
    }
    return true;
}

void Formatter::statement(int indent) {
    if (at("{")) return block(indent);
    if (at("if")) return if_statement(indent);
    if (at("for") || at("while") || at("do") || at("@")) return loop(indent);
    if (at("switch")) return switch_statement(indent);
    if (at("case") || at("default")) return label(indent);
    if (at("struct")) return declaration(indent);
    out_.node(simple(), false, 0);
}

bool Formatter::body(int indent) {
    if (at("{") && !peek().begins_with_lines()) {
        block(indent);
        return true;
    }
    if (is_simple() && !peek().begins_with_lines()) {
        const Node node = simple();
        const bool empty = node.kids.size() == 1 && node.kids[0].kind == Node::Kind::kWord &&
                           node.kids[0].word->is(";");
        if (!out_.fits(node, !empty, 0)) out_.start_line(indent + kIndent, false);
        out_.node(node, !empty, 0);
        return false;
    }
    out_.start_line(indent + kIndent, false);
    out_.lines_before(peek(), indent + kIndent);
    statement(indent + kIndent);
    return false;
}

void Formatter::if_statement(int indent) {
    out_.word(take(), true);
    out_.node(list(1, false, false), true, 2);
    while (true) {
        const bool was_block = body(indent);
        if (!at("else")) return;
        if (!was_block || peek().begins_with_lines()) {
            out_.start_line(indent, false);
            out_.lines_before(peek(), indent);
        }
        out_.word(take(), true);
        if (!at("if") || peek().begins_with_lines()) {
            body(indent);
            return;
        }
        out_.word(take(), true);
        out_.node(list(1, false, false), true, 2);
    }
}

void Formatter::loop(int indent) {
    bool space = false;
    if (at("@")) {
        Node bound = prefix();
        if (at("(")) add(&bound, list(1, false, false), false);
        out_.node(bound, false, 0);
        space = true;
    }
    if (at("for")) {
        out_.word(take(), space);
        out_.node(for_header(), true, 2);
        body(indent);
    } else if (at("while")) {
        out_.word(take(), space);
        out_.node(list(1, false, false), true, 2);
        body(indent);
    } else if (at("do")) {
        out_.word(take(), space);
        const bool was_block = body(indent);
        if (!was_block) out_.start_line(indent, false);
        out_.word(take(), true);
        out_.node(list(1, false, false), true, 1);
        if (at(";")) out_.word(take(), false);
    } else {
        statement(indent);
    }
}

void Formatter::switch_statement(int indent) {
    out_.word(take(), true);
    out_.node(list(1, false, false), true, 2);
    out_.word(take(), true);
    while (!at("}") && !at_end()) {
        const int here = at("case") || at("default") ? indent : indent + kIndent;
        out_.start_line(here, !words_[at_ - 1].is("{"));
        out_.lines_before(peek(), here);
        statement(here);
    }
    close_brace(indent);
}

/// Writes a label and the statements that the author wrote on its line.
void Formatter::label(int indent) {
    Node node;
    const bool value = at("case");
    add(&node, word_node(take()), false);
    if (value) add(&node, conditional(), true);
    add(&node, word_node(take()), false);
    out_.node(node, true, 0);
    const auto stays = [&] {
        return !at("}") && !at_end() && !peek().fresh_line && !peek().begins_with_lines();
    };
    if (stays() && at("{")) return block(indent);
    if (stays() && (at("case") || at("default"))) return label(indent);
    while (stays() && is_simple()) {
        const size_t start = at_;
        const Node next = simple();
        if (!out_.fits(next, true, 0)) {
            at_ = start;
            return;
        }
        out_.node(next, true, 0);
    }
}

}  // namespace openfab::format
