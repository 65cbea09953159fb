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

bool read_line(const std::string& file, int line, std::string* out) {
    constexpr size_t kLongestLine = 400;  // a minified file would fill the screen
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return false;
    // Reads in pieces and keeps no more than that line: the whole file may be a single line.
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

/// Returns the offset just past the token at byte `at`: a quoted string, or a run of letters,
/// digits and signs of a number.
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

/// The line with a caret below the token at `column`.
std::string token_caret(std::string line, int number, int column) {
    std::replace(line.begin(), line.end(), '\t', ' ');  // so that the caret stays aligned
    size_t at = 0;
    for (int c = 1; at < line.size(); ++at) {
        if (starts_code_point(line[at]) && c++ == column) break;
    }
    const size_t end = at < line.size() ? token_end(line, at) : at;
    const std::string before = printable(line.substr(0, at));
    const std::string token = printable(line.substr(at, end - at));
    return caret_lines(before + token + printable(line.substr(end)), number,
                       code_points(before) + 1, std::max<size_t>(code_points(token), 1));
}

}  // namespace

std::string caret_lines(std::string_view line, int64_t number, size_t column, size_t length) {
    const std::string digits = std::to_string(number);
    return fmt::format(" {} | {}\n {} | {}^{}\n", digits, line, std::string(digits.size(), ' '),
                       std::string(column - 1, ' '), std::string(length - 1, '~'));
}

std::string render_error(const Error& error) {
    const SourceLocation& at = error.location;
    if (at.line <= 0) return fmt::format("error: {}\n", printable(error.text()));
    std::string text =
        fmt::format("{}: error: {}\n", printable(at.str()), printable(error.message));
    std::string line;
    if (read_line(at.file, at.line, &line))
        text += token_caret(std::move(line), at.line, at.column);
    if (!error.help.empty()) text += fmt::format("help: {}\n", printable(error.help));
    return text;
}

}  // namespace openfab
