// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/base/caret.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <string_view>

namespace openfab {
namespace {

struct Location {
    std::string file;
    int line = 0;
    int column = 0;
    std::string rest;
};

/// Reads digits at `at`, followed by a colon; moves behind it. 0 where there are none.
int number_and_colon(std::string_view text, size_t* at) {
    int value = 0;
    size_t i = *at;
    while (i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) &&
           value < 100'000'000) {
        value = value * 10 + (text[i++] - '0');
    }
    if (i == *at || i >= text.size() || text[i] != ':') return 0;
    *at = i + 1;
    return value;
}

/// Finds the first `:line:col: `; a path may hold colons itself.
bool split_location(const std::string& message, Location* out) {
    for (size_t colon = message.find(':'); colon != std::string::npos;
         colon = message.find(':', colon + 1)) {
        size_t at = colon + 1;
        const int line = number_and_colon(message, &at);
        if (line == 0) continue;
        const int column = number_and_colon(message, &at);
        if (column == 0 || at >= message.size() || message[at] != ' ') continue;
        *out = {message.substr(0, colon), line, column, message.substr(at + 1)};
        return true;
    }
    return false;
}

bool read_line(const std::string& file, int line, std::string* out) {
    constexpr size_t kLongestLine = 400;  // a minified file would fill the screen
    std::ifstream in(file, std::ios::binary);
    for (int i = 0; i < line; ++i) {
        if (!std::getline(in, *out)) return false;
    }
    if (!out->empty() && out->back() == '\r') out->pop_back();
    return out->size() <= kLongestLine;
}

bool starts_code_point(char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
}

/// Code points of the token at byte `at`: a quoted string, or a run of letters, digits and signs of
/// a number.
int token_length(const std::string& line, size_t at) {
    if (at >= line.size()) return 1;
    size_t end = at + 1;
    if (line[at] == '"') {
        while (end < line.size() && line[end] != '"')
            end += line[end] == '\\' ? 2 : 1;
        end = std::min(end + 1, line.size());
    } else {
        const auto part = [](char c) {
            return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' ||
                   c == '-' || c == '+';
        };
        if (part(line[at])) {
            while (end < line.size() && part(line[end]))
                ++end;
        }
    }
    int points = 0;
    for (size_t i = at; i < end; ++i)
        points += starts_code_point(line[i]) ? 1 : 0;
    return points;
}

}  // namespace

std::string render_error(const Error& error) {
    Location where;
    if (!split_location(error.message, &where)) return fmt::format("error: {}\n", error.message);
    std::string what = where.rest;
    std::string help;
    if (const size_t semicolon = what.find("; "); semicolon != std::string::npos) {
        help = what.substr(semicolon + 2);
        what.resize(semicolon);
    }
    std::string text =
        fmt::format("{}:{}:{}: error: {}\n", where.file, where.line, where.column, what);
    std::string line;
    if (read_line(where.file, where.line, &line)) {
        size_t at = 0;
        for (int column = 1; at < line.size(); ++at) {
            if (!starts_code_point(line[at])) continue;
            if (column++ == where.column) break;
        }
        const int length = token_length(line, at);
        for (char& c : line) {
            if (c == '\t') c = ' ';  // so that the caret stays true
        }
        const std::string number = std::to_string(where.line);
        text +=
            fmt::format(" {} | {}\n {} | {}^{}\n", number, line, std::string(number.size(), ' '),
                        std::string(static_cast<size_t>(where.column - 1), ' '),
                        std::string(static_cast<size_t>(length > 1 ? length - 1 : 0), '~'));
    }
    if (!help.empty()) text += fmt::format("help: {}\n", help);
    return text;
}

}  // namespace openfab
