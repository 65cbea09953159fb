// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/caret.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string_view>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"

namespace openfab {
namespace {

bool read_line(const std::string& file, int line, std::string* out) {
    constexpr size_t kLongestLine = 400;  // a minified file would fill the screen
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return false;
    std::ifstream in(opened->name(), std::ios::binary);
    for (int i = 0; i < line; ++i) {
        if (!std::getline(in, *out)) return false;
    }
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
    const SourceLocation& at = error.location;
    if (at.line <= 0) return fmt::format("error: {}\n", printable(error.text()));
    std::string text =
        fmt::format("{}: error: {}\n", printable(at.str()), printable(error.message));
    std::string line;
    if (read_line(at.file, at.line, &line))
        text += caret_lines(std::move(line), at.line, at.column);
    if (!error.help.empty()) text += fmt::format("help: {}\n", printable(error.help));
    return text;
}

}  // namespace openfab
