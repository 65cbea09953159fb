// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>

#include "compiler/syntax/foreign_characters.h"
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
    Lexer(const source::SourceManager& sources, uint32_t file, diag::Sink* sink, Lost* lost)
        : text_(sources.text(file)), file_(file), sink_(sink), lost_(*lost) {}

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
                    lost_.whole = false;
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
        } else if (!punct() && !char_literal() && !meant()) {
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

    void add_as(TokenKind kind, size_t begin, std::string_view text) {
        tokens_.push_back({kind, span_from(begin), text, 0});
    }

    /// `'a'` and `'text'` on one line.
    bool char_literal() {
        if (peek() != '\'') return false;
        const size_t begin = at_;
        const size_t close = text_.find('\'', at_ + 1);
        if (close == std::string_view::npos || close == at_ + 1) return false;
        const std::string_view inside = text_.substr(at_ + 1, close - at_ - 1);
        if (inside.find_first_of("\"\n\\") != std::string_view::npos) return false;
        at_ = close + 1;
        diag::Diagnostic& d = sink_->report(span_from(begin), diag::kInvalidCharacter, "`'`");
        d.help("there is no character type; strings are written in double quotes");
        if (inside.size() > 1) {
            d.replace(span_from(begin), "\"" + std::string(inside) + "\"");
            add_as(TokenKind::kString, begin, inside);
        } else {
            add(TokenKind::kInt, begin);
        }
        return true;
    }

    /// A character of which is known what it stands for: a minus sign that is not ASCII's, a no-break space.
    bool meant() {
        const ForeignCharacter c = foreign_character(text_, at_);
        const bool mended = c.help.empty() && !c.name.empty();
        if (c.is_quote) return curved_quotes();
        if (!mended) return false;
        const size_t begin = at_;
        at_ += source::code_point_bytes(text_, at_);
        const std::string bytes(text_.substr(begin, at_ - begin));
        diag::Diagnostic& d =
            sink_->report(span_from(begin), diag::kInvalidCharacter, described(c, bytes));
        const bool blank = c.ours.empty() || c.ours == " ";
        d.help(blank ? (c.ours.empty() ? "remove it" : "write a space")
                     : "write `" + std::string(c.ours) + "`");
        d.replace(span_from(begin), std::string(c.ours));
        if (!blank) add_as(TokenKind::kPunct, begin, c.ours);
        return true;
    }

    /// A string in the quotes of a word processor, on one line.
    bool curved_quotes() {
        const size_t begin = at_;
        size_t close = at_ + source::code_point_bytes(text_, at_);
        const size_t inside = close;
        while (close < text_.size() && text_[close] != '\n' && text_[close] != '"' &&
               !foreign_character(text_, close).is_quote)
            close += source::code_point_bytes(text_, close);
        if (close >= text_.size() || text_[close] == '\n') return false;
        const std::string_view text = text_.substr(inside, close - inside);
        at_ = close + source::code_point_bytes(text_, close);
        const std::string bytes(text_.substr(begin, inside - begin));
        sink_
            ->report(span_from(begin), diag::kInvalidCharacter,
                     described(foreign_character(text_, begin), bytes))
            .help("strings are written in straight double quotes")
            .replace(span_from(begin), "\"" + std::string(text) + "\"");
        add_as(TokenKind::kString, begin, text);
        return true;
    }

    /// One message for a run of such characters.
    void invalid() {
        const size_t begin = at_;
        while (at_ < text_.size()) {
            const char c = peek();
            const bool known =
                c == ' ' || (c >= '\t' && c <= '\r') || is_word(c) || c == '"' || c == '#';
            if (known || (at_ > begin && !foreign_character(text_, at_).name.empty())) break;
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
                                 : source::count_code_points(run) == 1
                                     ? described(foreign_character(text_, begin), run)
                                     : "this text";
        diag::Diagnostic& d = sink_->report(span_from(begin), diag::kInvalidCharacter, what);
        lost_.whole = false;
        if (const ForeignCharacter c = foreign_character(text_, begin); !c.help.empty())
            d.help(std::string(c.help));
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
        const size_t value = at_;
        // A backslash at the end of a line continues it.
        bool goes_on = true;
        while (goes_on && at_ < text_.size()) {
            const size_t end = std::min(text_.find('\n', at_), text_.size());
            goes_on = end > at_ && text_[end - 1] == '\\';
            at_ = std::min(end + 1, text_.size());
        }
        source::Span line = span_from(begin);
        if (line.end > line.begin && text_[line.end - 1] == '\n') --line.end;
        lost_.lines.push_back(line);
        help_with_directive(word, std::string(text_.substr(value, line.end - value)), line, &d);
    }

    /// Says what stands for a directive, or that `#` begins no comment.
    static void help_with_directive(const std::string& word, const std::string& rest,
                                    const source::Span& line, diag::Diagnostic* d) {
        constexpr std::string_view kConditions[] = {"if",   "ifdef", "ifndef",
                                                    "else", "elif",  "endif"};
        const auto trimmed = [](std::string text) {
            text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
            text.erase(text.find_last_not_of(" \t\r") + 1);
            return text;
        };
        const std::string value = trimmed(rest);
        if (word == "define") {
            d->help("write a constant: `const float name = value;`");
            const size_t space = value.find_first_of(" \t(");
            if (space == std::string::npos || value[space] == '(') return;
            const std::string number = trimmed(value.substr(space));
            const bool real = number.find_first_of(".e") != std::string::npos;
            if (number.find_first_not_of("0123456789.-+ef") == std::string::npos)
                d->replace(line, std::string("const ") + (real ? "float " : "int ") +
                                     value.substr(0, space) + " = " + number + ";");
        } else if (word == "include") {
            d->help("functions such as `sin` are built in; a module is imported, `import name;`");
            if (value.starts_with('<')) {
                d->replace(line, "");
                return;
            }
            std::string name = value.size() > 2 ? value.substr(1, value.size() - 2) : "";
            name = name.substr(name.rfind('/') + 1);
            name = name.substr(0, name.find('.'));
            if (!name.empty() && std::all_of(name.begin(), name.end(), is_word))
                d->replace(line, "import " + name + ";");
        } else if (std::find(std::begin(kConditions), std::end(kConditions), word) !=
                   std::end(kConditions)) {
            d->help("a choice is made by a constant: `const bool FINE = true; … if (FINE) { … }`");
        } else if (word != "undef" && word != "pragma" && word != "error" && word != "line" &&
                   word != "version" && word != "extension") {
            d->help("a comment begins with `//`")
                .replace({line.file, line.begin, line.begin + 1}, "//");
        }
    }

    void string() {
        const size_t begin = at_++;
        while (at_ < text_.size() && peek() != '"' && peek() != '\n') {
            at_ += peek() == '\\' && at_ + 1 < text_.size() && peek(1) != '\n' ? 2 : 1;
        }
        if (peek() != '"') {
            sink_->report(span_from(begin), diag::kUnterminatedString);
            lost_.whole = false;
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
            } else if (c == '.') {
                // `1.xxx` is a swizzle of a literal in HLSL; here `1.` and `.5` are numbers.
                real = real || !hex;
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
        diag::Diagnostic& d =
            sink_->report(span_from(begin), diag::kBadNumber,
                          text_.substr(begin, std::min<size_t>(at_ - begin, 40)), why);
        // A suffix of C or of a unit behind a number.
        const std::string_view written = text_.substr(begin, at_ - begin);
        const size_t digits = std::min(written.find_first_not_of("0123456789."), written.size());
        constexpr std::string_view kSuffixes[] = {"d", "D", "l", "L", "lf", "LF", "ll", "LL", "mm"};
        const bool suffix = std::find(std::begin(kSuffixes), std::end(kSuffixes),
                                      written.substr(digits)) != std::end(kSuffixes);
        if (suffix && digits > 0)
            d.replace(span_from(begin), std::string(written.substr(0, digits)));
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
    Lost& lost_;
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

std::vector<Token> lex(const source::SourceManager& sources, uint32_t file, diag::Sink* sink,
                       Lost* lost) {
    Lost unasked;
    return Lexer(sources, file, sink, lost == nullptr ? &unasked : lost).run();
}

}  // namespace openfab::syntax
