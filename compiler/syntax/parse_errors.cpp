// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Errors of the parser: what is reported, what of the text they leave not understood, and where parsing goes on.
#include <algorithm>

#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

std::string describe(const Token& token) {
    if (token.kind == TokenKind::kEnd) return "the end of the file";
    if (token.kind == TokenKind::kString) return "a string";
    constexpr size_t kMaxShown = 40;
    const std::string_view shown = token.text.substr(0, kMaxShown);
    return "`" + std::string(shown) + (shown.size() < token.text.size() ? "…`" : "`");
}

/// A statement, declaration or the like begins here.
void Parser::begin_item() {
    first_ = at_;
    if (!damage_) return;
    damaged_.push_back({peek().span.file, *damage_, peek().span.begin});
    damage_.reset();
}

/// From a token on the text is not understood, up to where the next item begins.
void Parser::note_error(size_t from) {
    const uint32_t begin = tokens_[std::min(from, at_)].span.begin;
    damage_ = damage_ ? std::min(*damage_, begin) : begin;
}

/// Returns whether an error here need not be reported: of a line of an item the first one is. Takes note of it.
bool Parser::is_follow_up() {
    if (gave_up_ || last_error_ == at_) return true;
    const bool follows = error_item_ == first_ && location(error_at_).line == location(at_).line;
    last_error_ = at_;
    error_item_ = first_;
    error_at_ = at_;
    return follows;
}

diag::Diagnostic* Parser::expected(std::string_view what) {
    if (is_follow_up()) return nullptr;
    note_error(first_);
    diag::Diagnostic& d = sink_->report(peek().span, diag::kExpected, what, describe(peek()));
    add_foreign_help(&d);
    return &d;
}

bool Parser::expect(std::string_view text, const char* after) {
    if (accept(text)) return true;
    if (is_follow_up()) return false;
    // Points just after the previous token, where the missing token belongs.
    source::Span span = peek().span;
    if (at_ > 0) span.begin = span.end = tokens_[at_ - 1].span.end;
    const std::string what = "`" + std::string(text) + "` after " + after;
    diag::Diagnostic& d = sink_->report(span, diag::kExpected, what, describe(peek()));
    add_foreign_help(&d);
    const bool forgotten = text == ";" && d.helps.empty();
    const bool ends = on_fresh_line() || at("}") || at_end() || peek().kind == TokenKind::kKeyword;
    if (forgotten && ends) d.insert_before(span, ";");
    if (forgotten && !ends && at(")")) d.help("there is one `)` too many").replace(peek().span, "");
    // What stands on the lines before and after is understood.
    if (!forgotten || !on_fresh_line()) note_error(first_);
    return false;
}

bool Parser::expect_close(std::string_view text, const char* after, size_t open, const char* help) {
    if (at(text) || gave_up_ || last_error_ == at_) return accept(text);
    diag::Diagnostic* d = expected("`" + std::string(text) + "` after " + after);
    if (d != nullptr && location(open).line != location(at_).line) note_opening(open, d);
    if (d != nullptr && help != nullptr) d->help(help);
    if (text == "}") {
        braces_differ_ = true;
        note_error(suspicious_brace(open));
        damaged_.push_back({peek().span.file, *damage_, tokens_.back().span.end});
    }
    return false;
}

source::Location Parser::location(size_t token) const {
    return sources_.locate(tokens_[token].span.file, tokens_[token].span.begin);
}

/// Returns the column of the first token on a token's line.
size_t Parser::indentation(size_t token) const {
    const uint32_t line = location(token).line;
    while (token > 0 && location(token - 1).line == line)
        --token;
    return location(token).column;
}

void Parser::note_opening(size_t open, diag::Diagnostic* d) const {
    const size_t brace = suspicious_brace(open);
    d->note(tokens_[open].span, "to match this `" + std::string(tokens_[open].text) + "`");
    if (brace == open) return;
    d->note(
        tokens_[brace].span,
        "this `{` may be the one that is never closed: the `}` matched with it is indented less");
}

/// Returns the first brace closed since `open` whose `}` begins a line that is indented less than
/// the line of its `{`: it probably closes an enclosing brace. Otherwise returns `open`.
size_t Parser::suspicious_brace(size_t open) const {
    std::vector<size_t> braces;
    for (size_t i = open + 1; i < at_; ++i) {
        if (tokens_[i].is("{")) braces.push_back(i);
        if (!tokens_[i].is("}") || braces.empty()) continue;
        const size_t brace = braces.back();
        braces.pop_back();
        const bool own_line = location(i - 1).line != location(i).line;
        if (!own_line || location(i).column >= indentation(brace)) continue;
        return brace;
    }
    return open;
}

void Parser::give_up() {
    if (!gave_up_) sink_->report(peek().span, diag::kTooDeep, kMaxDepth);
    gave_up_ = true;
    damaged_.push_back({peek().span.file, tokens_[0].span.begin, tokens_.back().span.end});
    at_ = tokens_.size() - 1;
}

/// Skips one token, or everything from an opening bracket to its closing one.
void Parser::skip_balanced() {
    size_t open = 0;
    do {
        if (at("(") || at("{") || at("[")) ++open;
        if (open > 0 && (at(")") || at("}") || at("]"))) --open;
        take();
    } while (open > 0 && !at_end());
}

void Parser::skip_to_statement_end() {
    while (!at_end() && !at("}")) {
        if (accept(";")) return;
        const bool block = at("{");
        skip_balanced();
        if (block) return;
    }
}

/// Skips to the next token that can start a member of a fablet.
void Parser::skip_to_member() {
    while (!at_end() && !at("}") && !at("@") && !at("fablet")) {
        if (accept(";")) return;
        const bool block = at("{");
        skip_balanced();
        if (block) return;
    }
}

}  // namespace openfab::syntax
