// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/formatter.h"

#include <utility>

#include "compiler/syntax/operators.h"

namespace openfab::format {

namespace {

bool is_direction(const Word& word) {
    return word.is("const") || word.is("in") || word.is("out") || word.is("inout");
}

bool is_constructor(const Node& callee) {
    return callee.kind == Node::Kind::kWord && syntax::is_builtin_type_name(callee.word->text);
}

Node make(Node::Kind kind) {
    Node out;
    out.kind = kind;
    return out;
}

/// Returns the only kid instead of a node around it.
Node unwrapped(Node node) {
    if (node.kids.size() != 1) return node;
    Node kid = std::move(node.kids[0]);
    return kid;
}

}  // namespace

/// A statement up to its semicolon: an expression, a declaration, `return` and the like.
Node Formatter::simple() {
    Node out;
    if (at("struct")) {
        add(&out, record(), false);
    } else if (at("return") || at("break") || at("continue")) {
        add(&out, word_node(take()), false);
    }
    if (!at(";")) add(&out, simple_up_to(";"), true);
    if (at(";")) add(&out, word_node(take()), false);
    return out;
}

/// Expressions or declarators with commas between.
Node Formatter::simple_up_to(std::string_view end) {
    Node out;
    while (at_prefix())
        add(&out, prefix(), true);
    Node chain = make(Node::Kind::kChain);
    while (!at(end) && !at_end()) {
        if (Node part = item(); !part.is_empty()) add(&chain, std::move(part), true);
        if (!at(",")) break;
        add(&chain, word_node(take()), false);
    }
    if (!chain.kids.empty()) add(&out, unwrapped(std::move(chain)), true);
    return unwrapped(std::move(out));
}

/// True at a word before a name: a type, `const`, `out`, a marker.
bool Formatter::at_prefix() const {
    if (at("@") || is_direction(peek())) return true;
    return peek().is_identifier() && (peek(1).is_identifier() || is_direction(peek(1)));
}

Node Formatter::prefix() {
    if (!at("@")) return word_node(take());
    Node out;
    add(&out, word_node(take()), false);
    add(&out, word_node(take()), false);
    return out;
}

/// An element of a list: an expression, a declared name with what stands before it, varyings.
Node Formatter::item() {
    Node out;
    while (at_prefix())
        add(&out, prefix(), true);
    if (at("{")) {
        const bool varyings = !out.kids.empty();
        add(&out, list(1, varyings, true), true);
    } else if (!at(",") && !at(")") && !at(";")) {
        add(&out, assignment(), true);
    }
    if (at("[") && peek(1).is("[")) add(&out, list(2, true, true), true);
    return unwrapped(std::move(out));
}

/// `struct Name { … }`, on one line.
Node Formatter::record() {
    Node out;
    add(&out, word_node(take()), false);
    add(&out, word_node(take()), true);
    add(&out, statement_list(), true);
    return out;
}

/// `enum Name { A, B = 4 };`
Node Formatter::names_of_enum() {
    Node out;
    while (!at("{") && !at(";") && !at_end())
        add(&out, word_node(take()), true);
    if (at("{")) add(&out, list(1, true, true), true);
    if (at(";")) add(&out, word_node(take()), false);
    return out;
}

/// Statements in braces as a list, for where they stand on one line.
Node Formatter::statement_list() {
    Node out = make(Node::Kind::kList);
    out.padded = true;
    out.open.push_back(&take());
    while (!at("}") && !at_end() && is_simple())
        add(&out, simple(), true);
    out.close.push_back(&take());
    close_list(&out);
    return out;
}

Node Formatter::assignment() {
    Node left = conditional();
    if (!syntax::is_assignment(peek().token)) return left;
    Node out;
    add(&out, std::move(left), false);
    add(&out, word_node(take()), true);
    add(&out, at("{") ? list(1, false, true) : assignment(), true);
    return out;
}

Node Formatter::conditional() {
    Node condition = binary(1);
    if (!at("?")) return condition;
    Node out = make(Node::Kind::kChoice);
    add(&out, std::move(condition), false);
    add(&out, word_node(take()), true);
    add(&out, assignment(), true);
    add(&out, word_node(take()), true);
    add(&out, assignment(), true);
    return out;
}

Node Formatter::binary(int level) {
    if (level > syntax::kLastPrecedence) return unary();
    Node chain = make(Node::Kind::kChain);
    add(&chain, binary(level + 1), false);
    while (syntax::precedence(peek().token) == level) {
        add(&chain, word_node(take()), true);
        add(&chain, binary(level + 1), true);
    }
    return unwrapped(std::move(chain));
}

Node Formatter::unary() {
    Node out;
    for (const char* op : {"+", "-", "!", "~", "++", "--"}) {
        if (!at(op)) continue;
        add(&out, word_node(take()), false);
        add(&out, unary(), false);
        return out;
    }
    if (syntax::cast_length([&](size_t i) -> const syntax::Token& { return peek(i).token; }) == 0)
        return postfix();
    add(&out, word_node(take()), false);
    add(&out, word_node(take()), false);
    while (at("["))
        add(&out, list(1, false, false), false);
    add(&out, word_node(take()), false);
    add(&out, unary(), false);
    return out;
}

Node Formatter::postfix() {
    Node left = primary();
    while (true) {
        Node out;
        if (at("(")) {
            const bool keeps_rows = is_constructor(left);
            add(&out, std::move(left), false);
            add(&out, list(1, false, keeps_rows), false);
        } else if (at("[") && !peek(1).is("[")) {
            add(&out, std::move(left), false);
            add(&out, list(1, false, false), false);
        } else if (at(".")) {
            add(&out, std::move(left), false);
            add(&out, word_node(take()), false);
            add(&out, word_node(take()), false);
        } else if (at("++") || at("--")) {
            add(&out, std::move(left), false);
            add(&out, word_node(take()), false);
        } else {
            return left;
        }
        left = std::move(out);
    }
}

Node Formatter::primary() {
    return at("(") ? list(1, false, false) : word_node(take());
}

/// A list in brackets, `brackets` of them on each side.
Node Formatter::list(size_t brackets, bool padded, bool keeps_rows) {
    Node out = make(Node::Kind::kList);
    out.padded = padded;
    out.hanging = brackets == 2;  // annotations hold texts
    for (size_t i = 0; i < brackets; ++i)
        out.open.push_back(&take());
    const std::string_view end = out.open[0]->is("(") ? ")" : out.open[0]->is("[") ? "]" : "}";
    out.hung = out.open[0]->is("{") && keeps_rows && peek().fresh_line && !at(end);
    bool fresh = true;
    while (!at(end) && !at_end()) {
        const size_t before = at_;
        if (!fresh && keeps_rows && peek().fresh_line) out.rows = true;
        if (Node part = item(); !part.is_empty()) add(&out, std::move(part), true);
        if (at(",")) {
            Node separator = word_node(take());
            separator.is_separator = true;
            add(&out, std::move(separator), false);
        }
        fresh = false;
        if (at_ == before) break;
    }
    for (size_t i = 0; i < brackets; ++i)
        out.close.push_back(&take());
    close_list(&out);
    return out;
}

/// `(start; condition; step)`
Node Formatter::for_header() {
    Node out = make(Node::Kind::kList);
    out.open.push_back(&take());
    for (int part = 0; part < 3 && !at(")"); ++part) {
        if (!at(";")) add(&out, simple_up_to(part < 2 ? ";" : ")"), true);
        if (!at(";")) continue;
        Node separator = word_node(take());
        separator.is_separator = true;
        add(&out, std::move(separator), false);
    }
    out.close.push_back(&take());
    close_list(&out);
    return out;
}

}  // namespace openfab::format
