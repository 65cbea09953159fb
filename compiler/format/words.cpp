// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/words.h"

#include <algorithm>
#include <string>

namespace openfab::format {

namespace {

constexpr std::string_view kBlank = " \t\r\f\v";

/// What stands between two tokens.
class Gap {
  public:
    Gap(std::string_view text, bool starts_file) : text_(text), newlines_(starts_file ? 1 : 0) {
        if (starts_file && text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
        while (at_ < text_.size())
            next();
        // A comment ends its line where a line feed follows, or the end of the file.
        if (!comments.empty()) comments.back().ends_line = newlines_ > 0;
    }

    std::vector<Comment> comments;
    bool has_line() const { return has_line_; }
    bool ends_with_line() const { return newlines_ > 0; }
    bool ends_with_blank() const { return newlines_ > 1; }

  private:
    void next() {
        const char c = text_[at_];
        if (c == '\n') {
            ++newlines_;
            has_line_ = true;
        }
        if (c != '/') {
            column_ = c == '\n' ? 0 : column_ + 1;
            ++at_;
            return;
        }
        const bool line = text_[at_ + 1] == '/';
        size_t end = line ? text_.find('\n', at_) : text_.find("*/", at_ + 2);
        end = end == std::string_view::npos ? text_.size() : end + (line ? 0 : 2);
        if (!comments.empty()) comments.back().ends_line = newlines_ > 0;
        std::string_view text = text_.substr(at_, end - at_);
        const size_t last = text.find_last_not_of(kBlank);
        text = text.substr(0, last + 1);
        comments.push_back({text, column_, newlines_ > 0, line, newlines_ > 1});
        column_ += static_cast<int>(end - at_);
        at_ = end;
        newlines_ = 0;
    }

    std::string_view text_;
    size_t at_ = 0;
    int newlines_ = 0;
    bool has_line_ = false;
    int column_ = 0;
};

/// A comment's text without what layout may change.
std::string bare(std::string_view text) {
    std::string out;
    for (size_t at = 0; at <= text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line = text.substr(at, end - at);
        const size_t first = std::min(line.find_first_not_of(kBlank), line.size());
        line.remove_prefix(first);
        line = line.substr(0, line.find_last_not_of(kBlank) + 1);
        out += std::string(line) + '\n';
        at = end + 1;
    }
    return out;
}

std::vector<std::string> comments_of(const std::vector<Word>& words) {
    std::vector<std::string> out;
    for (const Word& word : words) {
        for (const Comment& comment : word.before)
            out.push_back(bare(comment.text));
        for (const Comment& comment : word.after)
            out.push_back(bare(comment.text));
    }
    return out;
}

}  // namespace

std::vector<Word> words_of(const source::SourceManager& sources, uint32_t file,
                           const std::vector<syntax::Token>& tokens) {
    std::vector<Word> words;
    const std::string_view text = sources.text(file);
    size_t end = 0;
    for (const syntax::Token& token : tokens) {
        const Gap gap(text.substr(end, token.span.begin - end), words.empty());
        Word word;
        word.token = token;
        word.text = sources.text(token.span);
        word.fresh_line = gap.has_line();
        word.blank_before = gap.ends_with_blank();
        // Those on the line of the token before trail it if they end the line, else they stand in the line of this one.
        const auto own = std::find_if(gap.comments.begin(), gap.comments.end(),
                                      [](const Comment& c) { return c.own_line; });
        const bool at_end = token.kind == syntax::TokenKind::kEnd;
        const bool trails = own != gap.comments.end() || gap.ends_with_line() || at_end;
        if (trails && !words.empty()) words.back().after.assign(gap.comments.begin(), own);
        word.before.assign(trails ? own : gap.comments.begin(), gap.comments.end());
        if (at_end && !word.before.empty()) word.before.back().ends_line = true;
        end = token.span.end;
        words.push_back(std::move(word));
    }
    return words;
}

bool same_words(const std::vector<Word>& a, const std::vector<Word>& b) {
    const auto same = [](const Word& x, const Word& y) {
        return x.token.kind == y.token.kind && x.text == y.text;
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), same) &&
           comments_of(a) == comments_of(b);
}

}  // namespace openfab::format
