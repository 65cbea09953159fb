// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>

#include "compiler/syntax/token.h"

namespace openfab::syntax {

namespace {

constexpr std::string_view kKeywords[] = {
    "break",  "case",   "const",  "continue", "default", "do",    "else",
    "fablet", "false",  "for",    "if",       "import",  "in",    "inout",
    "out",    "return", "struct", "switch",   "true",    "while",
};

// Longest first, so that the first match is the longest.
constexpr std::string_view kPuncts[] = {
    "<<=", ">>=", "++", "--", "&&", "||", "==", "!=", "<=", ">=", "+=", "-=", "*=", "/=", "%=",
    "&=",  "|=",  "^=", "<<", ">>", "(",  ")",  "{",  "}",  "[",  "]",  ";",  ",",  ".",  "?",
    ":",   "=",   "+",  "-",  "*",  "/",  "%",  "&",  "|",  "^",  "~",  "!",  "<",  ">",  "@",
};

bool is_word_start(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
bool is_word(char c) {
    return is_word_start(c) || is_digit(c);
}

class Lexer {
  public:
    Lexer(const source::SourceManager& sources, uint32_t file, diag::Sink* sink)
        : text_(sources.text(file)), file_(file), sink_(sink) {}

    std::vector<Token> run() {
        if (text_.substr(0, 3) == "\xEF\xBB\xBF") at_ = 3;
        while (skip_blank(), at_ < text_.size())
            next();
        Token end;
        end.span = span_from(text_.size());
        tokens_.push_back(end);
        return std::move(tokens_);
    }

  private:
    char peek(size_t ahead = 0) const {
        return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
    }
    source::Span span_from(size_t begin) const {
        return {file_, static_cast<uint32_t>(begin), static_cast<uint32_t>(at_)};
    }
    void add(TokenKind kind, size_t begin, uint32_t bits = 0) {
        tokens_.push_back({kind, span_from(begin), text_.substr(begin, at_ - begin), bits});
    }

    void skip_blank() {
        while (at_ < text_.size()) {
            const char c = peek();
            if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v') {
                ++at_;
            } else if (c == '/' && peek(1) == '/') {
                at_ = std::min(text_.find('\n', at_), text_.size());
            } else if (c == '/' && peek(1) == '*') {
                const size_t begin = at_;
                const size_t end = text_.find("*/", at_ + 2);
                at_ = begin + 2;
                if (end == std::string_view::npos) {
                    sink_->report(span_from(begin), diag::kUnterminatedComment);
                    at_ = text_.size();
                } else {
                    at_ = end + 2;
                }
            } else {
                return;
            }
        }
    }

    void next() {
        const size_t begin = at_;
        const char c = peek();
        if (is_word_start(c)) {
            while (is_word(peek()))
                ++at_;
            const std::string_view word = text_.substr(begin, at_ - begin);
            const bool keyword =
                std::find(std::begin(kKeywords), std::end(kKeywords), word) != std::end(kKeywords);
            add(keyword ? TokenKind::kKeyword : TokenKind::kIdentifier, begin);
        } else if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
            number();
        } else if (c == '"') {
            string();
        } else if (c == '#') {
            preprocessor();
        } else if (!punct()) {
            invalid();
        }
    }

    bool punct() {
        for (std::string_view candidate : kPuncts) {
            if (text_.substr(at_, candidate.size()) != candidate) continue;
            const size_t begin = at_;
            at_ += candidate.size();
            add(TokenKind::kPunct, begin);
            return true;
        }
        return false;
    }

    /// One message for a run of such characters.
    void invalid() {
        const size_t begin = at_;
        while (at_ < text_.size()) {
            const char c = peek();
            const bool known =
                c == ' ' || (c >= '\t' && c <= '\r') || is_word(c) || c == '"' || c == '#';
            if (known) break;
            const size_t before = at_;
            if (punct()) {
                at_ = before;
                tokens_.pop_back();
                break;
            }
            at_ += source::code_point_bytes(text_, at_);
        }
        const std::string_view run = text_.substr(begin, at_ - begin);
        const bool printable = std::all_of(run.begin(), run.end(), [](char c) {
            return static_cast<unsigned char>(c) > 0x20 && static_cast<unsigned char>(c) < 0x7f;
        });
        const std::string what = printable && run.size() <= 20 ? "`" + std::string(run) + "`"
                                 : source::count_code_points(run) == 1 ? "this character"
                                                                       : "this text";
        diag::Diagnostic& d = sink_->report(span_from(begin), diag::kInvalidCharacter, what);
        if (run.find('\'') != std::string_view::npos) {
            d.help("there is no character type; strings are written in double quotes");
        }
    }

    void preprocessor() {
        const size_t begin = at_++;
        while (peek() == ' ' || peek() == '\t')
            ++at_;
        const size_t word_begin = at_;
        while (is_word(peek()))
            ++at_;
        const std::string word(text_.substr(word_begin, at_ - word_begin));
        diag::Diagnostic& d = sink_->report(span_from(begin), diag::kPreprocessor, "#" + word);
        if (word == "define") d.help("write a constant: `const float name = value;`");
        if (word == "include") d.help("write `import name;`");
        // A backslash at the end of a line continues it.
        bool goes_on = true;
        while (goes_on && at_ < text_.size()) {
            const size_t end = std::min(text_.find('\n', at_), text_.size());
            goes_on = end > at_ && text_[end - 1] == '\\';
            at_ = std::min(end + 1, text_.size());
        }
    }

    void string() {
        const size_t begin = at_++;
        while (at_ < text_.size() && peek() != '"' && peek() != '\n') {
            at_ += peek() == '\\' && at_ + 1 < text_.size() && peek(1) != '\n' ? 2 : 1;
        }
        if (peek() != '"') {
            sink_->report(span_from(begin), diag::kUnterminatedString);
            return;
        }
        ++at_;
        add(TokenKind::kString, begin);
        tokens_.back().text = text_.substr(begin + 1, at_ - begin - 2);
    }

    void number() {
        const size_t begin = at_;
        const bool hex = peek() == '0' && (peek(1) == 'x' || peek(1) == 'X');
        bool real = false;
        while (at_ < text_.size()) {
            const char c = peek();
            if (is_word(c)) {
                real = real || (!hex && (c == 'e' || c == 'E'));
            } else if (c == '.' && !hex) {
                // `1.xxx` is a swizzle of a literal in HLSL; here `1.` and `.5` are numbers.
                real = true;
            } else if (!((c == '+' || c == '-') && !hex &&
                         (text_[at_ - 1] == 'e' || text_[at_ - 1] == 'E'))) {
                break;
            }
            ++at_;
        }
        std::string_view digits = text_.substr(begin, at_ - begin);
        const char last = digits.back();
        if (!hex && (last == 'f' || last == 'F' || last == 'h' || last == 'H')) {
            real = true;
            digits.remove_suffix(1);
        }
        if (real) return real_number(begin, digits);
        integer(begin, digits, hex);
    }

    void bad_number(size_t begin, std::string_view why) {
        sink_->report(span_from(begin), diag::kBadNumber,
                      text_.substr(begin, std::min<size_t>(at_ - begin, 40)), why);
        add(TokenKind::kInt, begin);  // a placeholder, so that the parser reports no second error
    }

    void real_number(size_t begin, std::string_view digits) {
        float value = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
            return bad_number(begin, "a float is written `1.5`, `1e-3` or `2.0f`");
        }
        if (error == std::errc::result_out_of_range) {
            return bad_number(begin, "it is outside the range of a 32-bit float");
        }
        add(TokenKind::kFloat, begin, std::bit_cast<uint32_t>(value));
    }

    void integer(size_t begin, std::string_view digits, bool hex) {
        const bool suffixed = digits.back() == 'u' || digits.back() == 'U';
        if (suffixed) digits.remove_suffix(1);
        if (hex) digits.remove_prefix(2);
        if (digits.ends_with("mm") || digits.ends_with("cm")) {
            return bad_number(begin, "lengths are in mm, without a unit");
        }
        if (digits.starts_with("0b") || digits.starts_with("0B")) {
            return bad_number(begin, "binary numbers are written in hex, `0xff`");
        }
        if (!hex && digits.size() > 1 && digits[0] == '0') {
            return bad_number(begin, "a leading 0 means octal in HLSL; drop it, or write `0x`");
        }
        uint32_t value = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value, hex ? 16 : 10);
        if (error == std::errc::result_out_of_range) {
            return bad_number(begin, "an integer has 32 bits, at most 4294967295");
        }
        if (error != std::errc{} || end != digits.data() + digits.size()) {
            return bad_number(begin, "an integer is written `12`, `12u` or `0xff`");
        }
        // Follows HLSL: a literal that does not fit an int is a uint.
        const bool fits = value <= 0x7fffffffu;
        add(suffixed || !fits ? TokenKind::kUint : TokenKind::kInt, begin, value);
    }

    std::string_view text_;
    uint32_t file_;
    diag::Sink* sink_;
    size_t at_ = 0;
    std::vector<Token> tokens_;
};

}  // namespace

const char* spelling(TokenKind kind) {
    switch (kind) {
        case TokenKind::kEnd:
            return "end";
        case TokenKind::kIdentifier:
            return "identifier";
        case TokenKind::kKeyword:
            return "keyword";
        case TokenKind::kInt:
            return "int";
        case TokenKind::kUint:
            return "uint";
        case TokenKind::kFloat:
            return "float";
        case TokenKind::kString:
            return "string";
        case TokenKind::kPunct:
            return "punct";
    }
    return "?";
}

std::vector<Token> lex(const source::SourceManager& sources, uint32_t file, diag::Sink* sink) {
    return Lexer(sources, file, sink).run();
}

}  // namespace openfab::syntax
