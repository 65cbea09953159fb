// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/statements.h"

#include <algorithm>

namespace openfab::graph {

namespace {

class Scanner {
  public:
    explicit Scanner(const server::Analysis& analysis)
        : analysis_(analysis), tokens_(analysis.tokens()), last_(tokens_.size() - 1) {}

    /// Returns the token behind the statement that begins at one.
    size_t end_of(size_t at) const {
        if (at >= last_) return last_;
        const syntax::Token& token = tokens_[at];
        if (token.is("{")) return behind(at);
        if (token.is(";")) return at + 1;
        if (token.is("@")) return end_of(behind_brackets(std::min(at + 2, last_)));
        if (token.is("if")) {
            const size_t end = end_of(behind_brackets(at + 1));
            return tokens_[end].is("else") ? end_of(end + 1) : end;
        }
        if (token.is("for") || token.is("while") || token.is("switch"))
            return end_of(behind_brackets(at + 1));
        if (token.is("do")) return end_of_simple(end_of(at + 1));
        return end_of_simple(at);
    }

  private:
    size_t behind(size_t open) const { return std::min(analysis_.matching(open) + 1, last_); }
    size_t behind_brackets(size_t at) const { return tokens_[at].is("(") ? behind(at) : at; }
    size_t end_of_simple(size_t at) const {
        while (at < last_ && !tokens_[at].is(";") && !tokens_[at].is("}")) {
            const bool open = tokens_[at].is("(") || tokens_[at].is("[") || tokens_[at].is("{");
            at = open ? std::max(behind(at), at + 1) : at + 1;
        }
        return at < last_ && tokens_[at].is(";") ? at + 1 : at;
    }

    const server::Analysis& analysis_;
    const std::vector<syntax::Token>& tokens_;
    size_t last_;
};

}  // namespace

std::vector<Extent> statements_between(const server::Analysis& analysis, size_t open,
                                       size_t close) {
    const Scanner scanner(analysis);
    std::vector<Extent> out;
    for (size_t at = open + 1; at < close;) {
        const size_t end = std::min(scanner.end_of(at), close);
        if (end <= at) break;
        out.push_back({at, end});
        at = end;
    }
    return out;
}

uint32_t lead_of(const server::Analysis& analysis, size_t token) {
    const std::string_view text = analysis.sources().text(server::Analysis::kDocument);
    const uint32_t begin = analysis.tokens()[token].span.begin;
    uint32_t at = token == 0 ? 0 : analysis.tokens()[token - 1].span.end;
    while (at < begin) {
        if (text[at] == '\n') return at + 1;
        if (text.substr(at, 2) == "//") {
            at = static_cast<uint32_t>(std::min<size_t>(text.find('\n', at), begin));
        } else if (text.substr(at, 2) == "/*") {
            at = static_cast<uint32_t>(std::min<size_t>(text.find("*/", at + 2) + 2, begin));
        } else {
            ++at;
        }
    }
    return begin;
}

uint32_t tail_of(const server::Analysis& analysis, size_t token) {
    const std::string_view text = analysis.sources().text(server::Analysis::kDocument);
    const uint32_t end = analysis.tokens()[token].span.end;
    const size_t at = text.find_first_not_of(" \t", end);
    if (at == std::string_view::npos || text.substr(at, 2) != "//") return end;
    return static_cast<uint32_t>(std::min(text.find_first_of("\r\n", at), text.size()));
}

}  // namespace openfab::graph
