// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/table_text.h"

#include <algorithm>
#include <cmath>

#include "base/scan_number.h"

namespace openfab::color {

bool is_cgats(std::string_view text) {
    constexpr std::string_view kKeyword = "BEGIN_DATA_FORMAT", kBlanks = " \t\r",
                               kEnds = " \t\r\n#";
    for (size_t at = text.find(kKeyword); at != std::string_view::npos;
         at = text.find(kKeyword, at + 1)) {
        const std::string_view before = text.substr(0, at);
        const size_t line = before.rfind('\n') + 1;  // npos + 1 is 0
        if (before.find_first_not_of(kBlanks, line) != std::string_view::npos) continue;
        const size_t end = at + kKeyword.size();
        if (end == text.size() || kEnds.find(text[end]) != std::string_view::npos) return true;
    }
    return false;
}

void CgatsWords::skip_between() {
    left_.remove_prefix(std::min(left_.find_first_not_of(between_), left_.size()));
    if (!left_.empty() && left_.front() == '#')
        left_.remove_prefix(std::min(left_.find('\n'), left_.size()));
}

std::optional<CgatsWord> CgatsWords::next_of_line() {
    skip_between();
    if (left_.empty() || left_.front() == '\n') return {};
    if (left_.front() != '"') {
        std::string_view word = left_.substr(0, left_.find('\n'));
        word = word.substr(0, std::min(word.find_first_of(between_), word.find('#')));
        left_.remove_prefix(word.size());
        return CgatsWord{word, line_, false};
    }
    left_.remove_prefix(1);
    const std::string_view line = left_.substr(0, left_.find('\n'));
    size_t end = std::min(line.find('"'), line.size());
    while (end + 1 < line.size() && line[end + 1] == '"')  // doubled, it is a part of the word
        end = std::min(line.find('"', end + 2), line.size());
    const std::string_view word = line.substr(0, end);
    left_.remove_prefix(std::min(end + 1, line.size()));
    return CgatsWord{word, line_, true};
}

std::optional<CgatsWord> CgatsWords::next() {
    while (true) {
        if (const std::optional<CgatsWord> word = next_of_line()) return word;
        if (left_.empty()) return {};
        left_.remove_prefix(1);
        ++line_;
    }
}

void CsvRows::skip_line() {
    const size_t end = left_.find('\n');
    left_.remove_prefix(end == std::string_view::npos ? left_.size() : end + 1);
    ++next_line_;
}

std::string CsvRows::take_cell(bool* last) {
    const std::string_view blanks = separator_ == '\t' ? " \r" : " \t\r";
    left_.remove_prefix(std::min(left_.find_first_not_of(blanks), left_.size()));
    std::string cell;
    const auto ends = [&](char c) { return c == separator_ || c == '\n'; };
    // Without a second one, a quote is a letter like others.
    if (left_.starts_with('"') && left_.find('"', 1) != std::string_view::npos) {
        size_t at = 1;
        for (; at < left_.size(); ++at) {
            if (left_[at] == '"') {
                if (at + 1 >= left_.size() || left_[at + 1] != '"') break;
                ++at;
            }
            if (left_[at] == '\n') ++next_line_;
            cell += left_[at];
        }
        left_.remove_prefix(std::min(at + 1, left_.size()));
        const auto* const end = std::find_if(left_.begin(), left_.end(), ends);
        left_.remove_prefix(static_cast<size_t>(end - left_.begin()));
    } else {
        const auto* const end = std::find_if(left_.begin(), left_.end(), ends);
        cell = left_.substr(0, static_cast<size_t>(end - left_.begin()));
        left_.remove_prefix(cell.size());
        cell.resize(cell.find_last_not_of(blanks) + 1);  // npos + 1 is 0
    }
    *last = left_.empty() || left_.front() == '\n';
    if (!left_.empty()) left_.remove_prefix(1);
    return cell;
}

bool CsvRows::next(std::vector<std::string>* cells) {
    if (left_.empty()) return false;
    line_ = next_line_;
    cells->clear();
    for (bool last = false; !last;) {
        std::string cell = take_cell(&last);
        if (cells->size() <= kMostColumns) cells->push_back(std::move(cell));
    }
    ++next_line_;
    return true;
}

bool read_number(std::string_view word, double* out) {
    std::string with_point(word);
    if (std::count(word.begin(), word.end(), ',') == 1 && word.find('.') == std::string_view::npos)
        std::replace(with_point.begin(), with_point.end(), ',', '.');
    return scan_number(with_point, out).empty() && std::isfinite(*out);
}

std::string upper(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}

}  // namespace openfab::color
