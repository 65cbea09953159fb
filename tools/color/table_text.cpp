// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/table_text.h"

#include <algorithm>

namespace openfab::color {

bool is_cgats(std::string_view text) {
    constexpr std::string_view kKeyword = "BEGIN_DATA_FORMAT", kBlanks = " \t\r";
    for (size_t at = text.find(kKeyword); at != std::string_view::npos;
         at = text.find(kKeyword, at + 1)) {
        const std::string_view before = text.substr(0, at);
        const size_t line = before.rfind('\n') + 1;  // npos + 1 is 0
        if (before.find_first_not_of(kBlanks, line) != std::string_view::npos) continue;
        const size_t end = text.find_first_not_of(kBlanks, at + kKeyword.size());
        if (end == std::string_view::npos || text[end] == '\n') return true;
    }
    return false;
}

namespace {

constexpr std::string_view kBetween = " \t\r,;";

}  // namespace

std::optional<std::string_view> take(std::string_view* line) {
    line->remove_prefix(std::min(line->find_first_not_of(kBetween), line->size()));
    if (line->empty() || line->front() == '#') return {};
    std::string_view word;
    if (line->front() == '"') {
        line->remove_prefix(1);
        word = line->substr(0, line->find('"'));
        line->remove_prefix(std::min(word.size() + 1, line->size()));
    } else {
        word = line->substr(0, std::min(line->find_first_of(kBetween), line->find('#')));
        line->remove_prefix(word.size());
    }
    return word;
}

std::string_view take_word(std::string_view* line) {
    return take(line).value_or(std::string_view());
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
    constexpr std::string_view kAround = " \t\r";
    std::vector<std::string_view> out;
    while (out.size() <= kMostColumns) {
        const size_t start = line.find_first_not_of(separator == '\t' ? " \r" : kAround);
        size_t end = line.find(separator);
        std::string_view cell = line.substr(0, end);
        if (start != std::string_view::npos && line[start] == '"') {
            const size_t close = std::min(line.find('"', start + 1), line.size());
            cell = line.substr(start + 1, close - start - 1);
            end = line.find(separator, close);
        } else {
            cell.remove_prefix(std::min(cell.find_first_not_of(kAround), cell.size()));
            cell = cell.substr(0, cell.find_last_not_of(kAround) + 1);
        }
        out.push_back(cell);
        if (end == std::string_view::npos) break;
        line.remove_prefix(end + 1);
    }
    return out;
}

std::string upper(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}

}  // namespace openfab::color
