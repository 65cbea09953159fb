// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What people write who know another language, answered with what OpenFL has, and where that is certain with the edit.
// The parser goes on as if it were written right.
#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>

#include "compiler/syntax/operators.h"
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

namespace {

constexpr size_t kMaxLookahead = 4096;  // so that each of many errors costs little

bool is_number(const Token& token) {
    return token.kind == TokenKind::kInt || token.kind == TokenKind::kUint ||
           token.kind == TokenKind::kFloat;
}

bool is_open(const Token& token) {
    return token.is("(") || token.is("[") || token.is("{");
}
bool is_close(const Token& token) {
    return token.is(")") || token.is("]") || token.is("}");
}

}  // namespace

size_t Parser::closing(size_t open) const {
    int depth = 0;
    for (size_t i = open; i < tokens_.size() && i < open + kMaxLookahead; ++i) {
        if (is_open(tokens_[i])) ++depth;
        if (is_close(tokens_[i]) && --depth == 0) return i;
    }
    return tokens_.size() - 1;
}

void Parser::add_foreign_help(diag::Diagnostic* d) const {
    const std::string_view previous = at_ > 0 ? tokens_[at_ - 1].text : std::string_view();
    const ForeignSyntax found = foreign_syntax(
        {tokens_[first_].text, previous, peek().text, peek(1).text, !on_fresh_line()});
    if (!found.help.empty()) {
        d->help(found.help);
        return fix_foreign(found, d);
    }
    if (at_ == 0 || on_fresh_line()) return;
    // `int 2`, `x: float`
    const bool value = is_number(peek()) || at_identifier();
    const bool ends = peek(1).is(";") || peek(1).is(")") || peek(1).is(",");
    const bool of_type = is_builtin_type_name(previous);
    const bool in_value = at_ > 1 && (tokens_[at_ - 2].is("=") || tokens_[at_ - 2].is("return") ||
                                      precedence(tokens_[at_ - 2]) != 0);
    const bool called =
        tokens_[at_ - 1].kind == TokenKind::kIdentifier && is_number(peek()) && in_value;
    if (((of_type && in_value) || called) && value && ends) {
        d->help(std::string(of_type ? "a conversion is written `"
                                    : "a function is called with "
                                      "parentheses: `") +
                std::string(previous) + "(x)`")
            .insert_before(peek().span, "(")
            .insert_after(peek().span, ")")
            .replace({peek().span.file, tokens_[at_ - 1].span.end, peek().span.begin}, "");
    } else if (at(":") && at_identifier(1) && at_ == first_ + 1) {
        const std::string right = std::string(peek(1).text) + " " + std::string(previous);
        d->help("the type comes first: `" + right + "`").replace(between(first_, at_ + 1), right);
    }
}

void Parser::fix_foreign(const ForeignSyntax& found, diag::Diagnostic* d) const {
    using Fix = ForeignSyntax::Fix;
    // What goes takes the space behind it along.
    const auto put = [&](size_t first, size_t last) {
        source::Span span = between(first, last);
        const bool gap = found.ours.empty() && last + 1 < tokens_.size() &&
                         location(last).line == location(last + 1).line;
        if (gap) span.end = tokens_[last + 1].span.begin;
        d->replace(span, found.ours);
    };
    switch (found.fix) {
        case Fix::kNone:
            return;
        case Fix::kFound:
            return put(at_, at_);
        case Fix::kPrevious:
            return put(at_ - 1, at_ - 1);
        case Fix::kFirst:
            return put(first_, first_);
        case Fix::kBoth:
            if (touch(at_ - 1)) put(at_ - 1, at_);
            return;
        case Fix::kNamespace:
            if (at_ > 0 && tokens_[at_ - 1].kind == TokenKind::kIdentifier) put(at_ - 1, at_ + 1);
            return;
        case Fix::kDefinition:
            put(at_, at_ + 1);
            if (at_ == first_ + 1) d->insert_before(tokens_[first_].span, "float ");
            return;
        case Fix::kPercent: {
            if (at_ < 2 || !is_number(tokens_[at_ - 2])) return;
            double value = 0;
            if (std::sscanf(std::string(tokens_[at_ - 2].text).c_str(), "%lf", &value) != 1) return;
            std::array<char, 32> text{};
            std::snprintf(text.data(), text.size(), "%g", value / 100);
            d->replace(between(at_ - 2, at_ - 1), text.data());
            return;
        }
        case Fix::kBrackets: {
            const size_t close = closing(at_);
            const Token& next = tokens_[std::min(close + 1, tokens_.size() - 1)];
            if (!tokens_[close].is("]") || !(next.is(";") || next.is(",") || next.is(")"))) return;
            d->replace(tokens_[at_].span, "{").replace(tokens_[close].span, "}");
            return;
        }
    }
}

/// Reports `[unroll]`, HLSL's attributes of statements, and skips it.
void Parser::skip_attribute() {
    constexpr std::string_view kAttributes[] = {"unroll",    "loop",    "branch",
                                                "flatten",   "fastopt", "allow_uav_condition",
                                                "forcecase", "call",    "numthreads"};
    if (!at("[") || std::find(std::begin(kAttributes), std::end(kAttributes), peek(1).text) ==
                        std::end(kAttributes))
        return;
    const size_t open = at_;
    const size_t close = closing(open);
    if (diag::Diagnostic* d = expected("a statement")) {
        source::Span span = between(open, close);
        if (close + 1 < tokens_.size()) span.end = tokens_[close + 1].span.begin;
        d->help("short loops are unrolled, and branches chosen, without being told: leave it out")
            .replace(span, "");
    }
    at_ = std::min(close + 1, tokens_.size() - 1);
    begin_item();
}

/// Adds the loop that `for i in range(n)` is, whose header begins at a token.
void Parser::add_loop_fix(size_t header, diag::Diagnostic* d) const {
    const size_t range = at_ + 1;
    if (range + 2 >= tokens_.size() || tokens_[range].text != "range" ||
        !tokens_[range + 1].is("("))
        return;
    const size_t open = range + 1;
    const size_t close = closing(open);
    size_t comma = 0;
    int depth = 0;
    for (size_t i = open; i < close; ++i) {
        depth += is_open(tokens_[i]) ? 1 : is_close(tokens_[i]) ? -1 : 0;
        if (!tokens_[i].is(",") || depth != 1) continue;
        if (comma != 0) return;  // a step
        comma = i;
    }
    const bool half = comma != 0 && (comma == open + 1 || comma + 1 == close);
    if (half || close == open + 1 || !tokens_[close].is(")")) return;
    const std::string from = comma == 0 ? "0" : text_between(open + 1, comma - 1);
    const std::string to = text_between(comma == 0 ? open + 1 : comma + 1, close - 1);
    const std::string name(tokens_[at_ - 1].text);
    size_t last = close;
    if (tokens_[header].is("(")) ++last;
    if (last + 1 < tokens_.size() && tokens_[last + 1].is(":")) ++last;
    d->replace(between(header, last),
               "(int " + name + " = " + from + "; " + name + " < " + to + "; ++" + name + ")");
}

/// Parses `for x in range(10)`, `for (float x : list)`; false at any other loop. `for` is taken.
bool Parser::parse_foreign_loop(ast::Stmt* out) {
    const size_t header = at_;
    size_t name = at("(") ? at_ + 1 : at_;
    if (name + 2 >= tokens_.size()) return false;
    const auto word = [&](size_t token) { return tokens_[token].kind == TokenKind::kIdentifier; };
    if (word(name) && word(name + 1)) ++name;
    const bool over = tokens_[name + 1].is("in") || tokens_[name + 1].is(":");
    if (!word(name) || !over || tokens_[name + 2].is("=")) return false;
    at_ = name + 1;
    const bool array = at(":");
    if (diag::Diagnostic* d = expected("`=` after the loop's variable")) {
        const std::string item(tokens_[name].text);
        d->helps.clear();
        d->help(array ? "a loop over an array counts: `for (int i = 0; i < 3; ++i) { float " +
                            item + " = list[i]; … }`"
                      : "a loop is written `for (int i = 0; i < 4; ++i) { … }`");
        if (!array) add_loop_fix(header, d);
    }
    if (tokens_[header].is("(")) {
        at_ = std::min(closing(header) + 1, tokens_.size() - 1);
    } else {
        while (!at("{") && !at("}") && !at(";") && !at_end())
            skip_balanced();
    }
    accept(":");
    out->kind = ast::StmtKind::kBad;
    if (at("{")) parse_block();
    return true;
}

/// Parses the `&` or `*` of a parameter that is to be changed.
void Parser::parse_reference(const ast::TypeRef& type, ast::Variable* out) {
    if (!(at("&") || at("*")) || !at_identifier(1)) return;
    if (diag::Diagnostic* d = expected("a name")) {
        source::Span mark = peek().span;
        mark.end = peek(1).span.begin;
        if (mark.begin == type.span.end) mark.end = peek().span.end;
        d->help(
             "there are no pointers or references: an `out` parameter gives a value back, "
             "`inout` changes one")
            .insert_before(type.span, "inout ")
            .replace(mark, peek().span.begin == type.span.end && touch(at_) ? " " : "");
    }
    take();
    out->is_in = out->is_out = true;
}

/// Takes the `out` or `&` that an argument does not have.
void Parser::parse_argument_mark() {
    const bool word = (at("out") || at("in") || at("inout")) && at_identifier(1);
    if (!word && !(at("&") && at_identifier(1))) return;
    if (diag::Diagnostic* d = expected("an argument")) {
        source::Span span = peek().span;
        span.end = peek(1).span.begin;
        d->helps.clear();
        d->help("an argument is written alone, for an `out` parameter, too: `f(x)`")
            .replace(span, "");
    }
    take();
}

/// Reports a function in a struct and skips it; false where there is none.
bool Parser::parse_method(std::string_view record) {
    const bool constructor = at_identifier() && peek(1).is("(");
    const bool method = at_identifier() && at_identifier(1) && peek(2).is("(");
    if (!constructor && !method) return false;
    at_ += method ? 2 : 1;
    if (diag::Diagnostic* d = expected("`;` after a member")) {
        d->help(method
                    ? "a struct holds values alone: write a function that takes it, `" +
                          text_between(at_ - 2, at_ - 1) + "(" + std::string(record) +
                          " s)`, outside"
                    : "a struct is made by `{ … }` or by its name, with a value for each member");
    }
    while (!at("{") && !at(";") && !at("}") && !at_end())
        skip_balanced();
    if (at("{")) skip_balanced();
    accept(";");
    return true;
}

/// Reports `S operator+(…)` and skips it; false where there is none.
bool Parser::parse_operator() {
    if (!at_identifier() || !at_identifier(1) || peek(1).text != "operator") return false;
    take();
    if (diag::Diagnostic* d = expected("a name")) {
        const std::string type(tokens_[at_ - 1].text);
        d->help("operators cannot be overloaded: write a function, `" + type + " add(" + type +
                " a, " + type + " b)`");
    }
    skip_to_member();
    return true;
}

/// Reports what follows a module's name: `.fl`, `.*`, `as x`, another name.
void Parser::parse_import_tail() {
    if (at(";") || at_end() || on_fresh_line()) return;
    const std::string name(tokens_[at_ - 1].text);
    const size_t begin = at_;
    diag::Diagnostic* d = expected("`;` after the module's name");
    while (!at(";") && !at_end() && !on_fresh_line())
        take();
    if (d == nullptr) return;
    d->helps.clear();
    d->fix.clear();
    const source::Span tail = between(begin, at_ - 1);
    if (tokens_[begin].is(",")) {
        d->help("each module has an `import` of its own: `import " + name + "; import " +
                std::string(tokens_[begin + 1].text) + ";`");
        if (begin + 2 == at_) d->replace(tokens_[begin].span, "; import");
    } else {
        d->help("all of a module is imported, by its name alone: `import " + name + ";`")
            .replace({tail.file, tokens_[begin - 1].span.end, tail.end}, "");
    }
}

/// Parses `[3] x` where `x[3]` is meant.
bool Parser::parse_size_first(ast::Variable* out) {
    const size_t open = at_;
    size_t name = open;
    while (name < tokens_.size() && tokens_[name].is("["))
        name = closing(name) + 1;
    const bool known = name < tokens_.size() && tokens_[name].kind == TokenKind::kIdentifier;
    diag::Diagnostic* d = expected("a name");
    if (d != nullptr) d->help("the size of an array follows its name: `float a[3]`");
    if (d != nullptr && known) {
        const std::string right =
            " " + std::string(tokens_[name].text) + text_between(open, name - 1);
        d->replace({tokens_[open].span.file, tokens_[open - 1].span.end, tokens_[name].span.end},
                   right);
    }
    if (!known) return false;
    const source::Span brackets = peek().span;
    while (at("[")) {
        take();
        out->extents.push_back(at("]") ? nullptr : parse_conditional());
        if (!expect("]", "the array's size")) return false;
    }
    out->array_span = span_to_previous(brackets);
    return at_ == name;
}

/// Skips the `<float4>` of `Texture2D<float4>`.
void Parser::parse_type_parameters() {
    if (!at("<") || !at_identifier(1) || !peek(2).is(">") || !at_identifier(3)) return;
    if (diag::Diagnostic* d = expected("a name"))
        d->help("types have no parameters").replace(between(at_, at_ + 2), "");
    for (int i = 0; i < 3; ++i)
        take();
}

/// Says how the value of `float3 p(1, 2, 3)` or `float3 p{1, 2, 3}` is written.
void Parser::help_with_initializer(const ast::TypeRef& type, const ast::Variable& last,
                                   diag::Diagnostic* d) const {
    const std::string of(type.text);
    const std::string name(last.name);
    if (at("(") && at_identifier(1) && at_identifier(2)) {
        d->help("define functions outside stages and other functions");
    } else if (last.init != nullptr) {
        // `= float3{1, 2, 3}`
        const size_t close = closing(at_);
        if (!at("{") || !is_builtin_type_name(tokens_[at_ - 1].text)) return;
        d->help("write `" + std::string(tokens_[at_ - 1].text) + "(…)`");
        if (tokens_[close].is("}")) d->replace(peek().span, "(").replace(tokens_[close].span, ")");
    } else {
        const bool list = at("{");
        d->help("initialize a variable with `=`: `" + of + " " + name + " = " +
                (list ? "{…}" : of + "(…)") + ";`")
            .insert_after(last.span, list ? " = " : " = " + of);
    }
}

diag::Diagnostic* Parser::expected_declaration(std::string_view what) {
    diag::Diagnostic* d = expected(what);
    if (d == nullptr || !d->helps.empty() || !at_identifier()) return d;
    const size_t close = peek(1).is("(") ? closing(at_ + 1) : 0;
    if (close != 0 && close + 1 < tokens_.size() && tokens_[close + 1].is("{")) {
        d->help("a function begins with the type of its result: `float " +
                std::string(peek().text) + "(float x) { return x; }`");
    } else if (peek(1).is("[")) {
        d->help("a function gives an array back in a struct, or by an `out` parameter");
    }
    return d;
}

}  // namespace openfab::syntax
