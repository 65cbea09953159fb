// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/report/message.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <string_view>

namespace openfab::report {

namespace {

struct Located {
    std::string_view file;
    int line = 0;
    int column = 0;
    std::string_view rest;
};

/// Takes `:NUMBER` off the end of `text`.
bool take_number(std::string_view* text, int* number) {
    const size_t colon = text->rfind(':');
    if (colon == std::string_view::npos || colon + 1 == text->size()) return false;
    const std::string_view digits = text->substr(colon + 1);
    auto [rest, status] = std::from_chars(digits.data(), digits.data() + digits.size(), *number);
    if (status != std::errc() || rest != digits.data() + digits.size() || *number < 1) return false;
    *text = text->substr(0, colon);
    return true;
}

/// Finds the first `: ` that ends a `file:line:column`.
bool locate(std::string_view message, Located* place) {
    for (size_t end = message.find(": "); end != std::string_view::npos;
         end = message.find(": ", end + 1)) {
        std::string_view head = message.substr(0, end);
        if (head.find('\n') != std::string_view::npos) return false;
        if (!take_number(&head, &place->column) || !take_number(&head, &place->line) ||
            head.empty())
            continue;
        place->file = head;
        place->rest = message.substr(end + 2);
        return true;
    }
    return false;
}

bool read_line(const std::string& file, int number, std::string* line) {
    std::ifstream in(file);
    for (int i = 0; i < number; ++i) {
        if (!std::getline(in, *line)) return false;
    }
    // A line of a machine-made file may have any length.
    constexpr size_t kLongest = 400;
    return line->size() <= kLongest;
}

/// Columns count code points, and a tab prints as one space, so that the caret stays true.
std::string caret_line(const Located& place, std::string line) {
    for (char& c : line) {
        if (c == '\t' || c == '\r') c = ' ';
    }
    const std::string gutter = fmt::format("{:4} | ", place.line);
    return fmt::format("{}{}\n{:{}}| {:{}}^\n", gutter, line, "", gutter.size() - 2, "",
                       place.column - 1);
}

std::string format_message(const char* kind, const std::string& message) {
    Located place;
    if (!locate(message, &place)) return fmt::format("{}: {}\n", kind, message);
    // The caret stands under the first line of the message; what follows are notes and help.
    const size_t line_end = place.rest.find('\n');
    const std::string_view first = place.rest.substr(0, line_end);
    std::string text =
        fmt::format("{}:{}:{}: {}: {}\n", place.file, place.line, place.column, kind, first);
    std::string line;
    if (read_line(std::string(place.file), place.line, &line)) text += caret_line(place, line);
    if (line_end != std::string_view::npos)
        text += std::string(place.rest.substr(line_end + 1)) + "\n";
    return text;
}

}  // namespace

std::string format_error(const Error& error) {
    return format_message(error.code == ErrorCode::kInternal ? "internal error" : "error",
                          error.message);
}

std::string format_warning(const std::string& message) {
    return format_message("warning", message);
}

}  // namespace openfab::report
