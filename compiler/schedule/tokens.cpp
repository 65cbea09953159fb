// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/schedule/tokens.h"

#include <algorithm>
#include <cctype>

namespace openfab::schedule {

namespace {

using Kind = Token::Kind;

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '*';
}

class Lexer {
  public:
    explicit Lexer(const Source& source) : source_(source), text_(source.text) {
        constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
        if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    }

    std::variant<std::vector<Token>, Fault> run() {
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '\n') {
                add(Kind::kNewLine, at_, at_ + 1);
                ++line_;
                line_begin_ = at_;
            } else if (c == '#') {
                at_ = std::min(text_.find('\n', at_), text_.size());
            } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
                ++at_;
            } else if (is_word(c)) {
                size_t end = at_;
                while (end < text_.size() && is_word(text_[end]))
                    ++end;
                add(Kind::kWord, at_, end);
            } else if (c == '"') {
                const size_t end = text_.find_first_of("\"\n", at_ + 1);
                if (end == std::string_view::npos || text_[end] == '\n')
                    return fault_at(word(at_, at_ + 1), "this name has no closing `\"`");
                add(Kind::kString, at_ + 1, end);
                ++at_;
            } else if (!mark()) {
                return fault_at(word(at_, at_ + 1), "no word or sign of a schedule begins so");
            }
        }
        add(Kind::kEnd, at_, at_);
        return join_chains();
    }

  private:
    Word word(size_t from, size_t to) const {
        return {std::string(text_.substr(from, to - from)),
                source_.file,
                line_,
                static_cast<int32_t>(from - line_begin_) + 1,
                std::max(1, static_cast<int32_t>(to - from)),
                from};
    }

    void add(Kind kind, size_t from, size_t to) {
        Token token{kind, word(from, to)};
        if (kind == Kind::kNewLine) token.word.text.clear();
        out_.push_back(std::move(token));
        at_ = to;
    }

    bool mark() {
        const char c = text_[at_];
        const bool equals = at_ + 1 < text_.size() && text_[at_ + 1] == '=';
        if (std::string_view("<>=!").find(c) != std::string_view::npos && equals) {
            add(Kind::kMark, at_, at_ + 2);
        } else if (std::string_view("()[]{}.,=%<>").find(c) != std::string_view::npos) {
            add(Kind::kMark, at_, at_ + 1);
        } else {
            return false;
        }
        return true;
    }

    std::vector<Token> join_chains() {
        std::vector<Token> joined;
        for (Token& token : out_) {
            if (token.is(".")) {
                const bool begins = joined.empty() || joined.back().kind == Kind::kNewLine;
                size_t keep = joined.size();
                while (keep > 0 && joined[keep - 1].kind == Kind::kNewLine)
                    --keep;
                if (begins && keep > 0 && joined[keep - 1].is(")")) joined.resize(keep);
            }
            joined.push_back(std::move(token));
        }
        return joined;
    }

    const Source& source_;
    std::string_view text_;
    size_t at_ = 0;
    size_t line_begin_ = 0;
    int32_t line_ = 1;
    std::vector<Token> out_;
};

}  // namespace

std::variant<std::vector<Token>, Fault> tokens_of(const Source& source) {
    return Lexer(source).run();
}

}  // namespace openfab::schedule
