// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/caret.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/text.h"

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
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return false;
    // In pieces, of which no more than that line is kept: a file may be one line.
    std::vector<char> piece(1 << 16);
    int at_line = 1;
    out->clear();
    for (int64_t at = 0; at_line <= line && out->size() <= kLongestLine;) {
        const Result<size_t> got = opened->read(at, piece.data(), piece.size());
        if (!got || *got == 0) break;
        std::string_view rest(piece.data(), *got);
        at += static_cast<int64_t>(*got);
        while (!rest.empty() && at_line <= line) {
            const size_t end = std::min(rest.find('\n'), rest.size());
            if (at_line == line) out->append(rest.substr(0, std::min(end, kLongestLine + 1)));
            at_line += end < rest.size();
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
    }
    if (at_line < line || (at_line == line && out->empty())) return false;
    if (!out->empty() && out->back() == '\r') out->pop_back();
    return out->size() <= kLongestLine;
}

bool starts_code_point(char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
}

size_t code_points(std::string_view text) {
    return static_cast<size_t>(std::count_if(text.begin(), text.end(), starts_code_point));
}

/// The byte behind the token at byte `at`: a quoted string, or a run of letters, digits and signs
/// of a number.
size_t token_end(const std::string& line, size_t at) {
    size_t end = at + 1;
    if (line[at] == '"') {
        while (end < line.size() && line[end] != '"')
            end += line[end] == '\\' ? 2 : 1;
        return std::min(end + 1, line.size());
    }
    const auto part = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-' ||
               c == '+';
    };
    while (part(line[at]) && end < line.size() && part(line[end]))
        ++end;
    return end;
}

/// The line with a caret below it, each fit for a terminal.
std::string caret_lines(std::string line, int number, int column) {
    std::replace(line.begin(), line.end(), '\t', ' ');  // so that the caret stays true
    size_t at = 0;
    for (int c = 1; at < line.size(); ++at) {
        if (starts_code_point(line[at]) && c++ == column) break;
    }
    const size_t end = at < line.size() ? token_end(line, at) : at;
    const std::string before = printable(line.substr(0, at));
    const std::string token = printable(line.substr(at, end - at));
    const std::string digits = std::to_string(number);
    return fmt::format(" {} | {}{}{}\n {} | {}^{}\n", digits, before, token,
                       printable(line.substr(end)), std::string(digits.size(), ' '),
                       std::string(code_points(before), ' '),
                       std::string(std::max<size_t>(code_points(token), 1) - 1, '~'));
}

}  // namespace

std::string render_error(const Error& error) {
    Location where;
    if (!split_location(error.message, &where))
        return fmt::format("error: {}\n", printable(error.message));
    std::string what = where.rest;
    std::string help;
    if (const size_t semicolon = what.find("; "); semicolon != std::string::npos) {
        help = what.substr(semicolon + 2);
        what.resize(semicolon);
    }
    std::string text = fmt::format("{}:{}:{}: error: {}\n", printable(where.file), where.line,
                                   where.column, printable(what));
    std::string line;
    if (read_line(where.file, where.line, &line))
        text += caret_lines(std::move(line), where.line, where.column);
    if (!help.empty()) text += fmt::format("help: {}\n", printable(help));
    return text;
}

}  // namespace openfab
