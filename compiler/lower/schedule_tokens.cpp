// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule_tokens.h"

#include <algorithm>
#include <cctype>

namespace openfab::lower {

namespace {

using Kind = ScheduleToken::Kind;

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '*';
}

class Lexer {
  public:
    explicit Lexer(const ScheduleSource& source) : source_(source), text_(source.text) {}

    std::variant<std::vector<ScheduleToken>, ScheduleFault> run() {
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
    ScheduleWord word(size_t from, size_t to) const {
        return {std::string(text_.substr(from, to - from)),
                source_.file,
                line_,
                static_cast<int32_t>(from - line_begin_) + 1,
                std::max(1, static_cast<int32_t>(to - from)),
                from};
    }

    void add(Kind kind, size_t from, size_t to) {
        ScheduleToken token{kind, word(from, to)};
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

    std::vector<ScheduleToken> join_chains() {
        std::vector<ScheduleToken> joined;
        for (ScheduleToken& token : out_) {
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

    const ScheduleSource& source_;
    std::string_view text_;
    size_t at_ = 0;
    size_t line_begin_ = 0;
    int32_t line_ = 1;
    std::vector<ScheduleToken> out_;
};

}  // namespace

std::variant<std::vector<ScheduleToken>, ScheduleFault> schedule_tokens(
    const ScheduleSource& source) {
    return Lexer(source).run();
}

}  // namespace openfab::lower
