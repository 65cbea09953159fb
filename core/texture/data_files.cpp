// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/data_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/scan_number.h"
#include "base/text.h"
#include "texture/messages.h"

namespace openfab::texture {

namespace {

constexpr size_t kMostDataFiles = 16384;  // as slices
constexpr std::string_view kAroundLines = " \t\r\n";

/// The number of a pattern: what is before it and behind it, and its least digits.
struct Pattern {
    std::string before, behind;
    int64_t digits = 0;
};

/// Parses `s%03d.raw`; returns false for anything that is not one number.
bool parse(std::string_view text, Pattern* out) {
    const size_t sign = text.find('%');
    const size_t end = text.find('d', sign);
    if (sign == std::string_view::npos || end == std::string_view::npos) return false;
    std::string_view digits = text.substr(sign + 1, end - sign - 1);
    constexpr int64_t kMostDigits = 20;
    const bool zeros = digits.empty() || digits.front() == '0';
    if (!zeros || (!digits.empty() && !scan_integer(digits, 0, kMostDigits, &out->digits).empty()))
        return false;
    out->before = text.substr(0, sign);
    out->behind = text.substr(end + 1);
    return out->behind.find('%') == std::string::npos;
}

Error malformed(const std::string& text) {
    return user_error(fmt::format(messages::kDataFilesMalformed, text),
                      messages::kDataFilesMalformedHelp);
}

}  // namespace

bool is_file_list(std::string_view text) {
    if (take_word(&text) != "LIST") return false;
    // How many dimensions each file has may stand behind, as 2 or 2D.
    const std::string_view word = take_word(&text);
    return word.size() <= 1 || (word.size() == 2 && word[1] == 'D');
}

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> out;
    while (!text.empty()) {
        const size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const size_t first = line.find_first_not_of(kAroundLines);
        if (first == std::string_view::npos) continue;
        out.emplace_back(line.substr(first, line.find_last_not_of(kAroundLines) + 1 - first));
    }
    return out;
}

Result<std::vector<std::string>> read_data_files(const std::string& text,
                                                 const std::vector<std::string>& listed) {
    if (is_file_list(text)) {
        if (listed.empty() || listed.size() > kMostDataFiles) return malformed(text);
        return listed;
    }
    std::string_view left = text;
    Pattern pattern;
    if (text.find('%') == std::string::npos) return std::vector<std::string>{text};
    if (!parse(take_word(&left), &pattern)) return malformed(text);
    std::array<int64_t, 3> range{};  // first, last, step
    constexpr int64_t kMostNumber = 1'000'000'000;
    for (int64_t& number : range) {
        if (!scan_integer(take_word(&left), -kMostNumber, kMostNumber, &number).empty())
            return malformed(text);
    }
    const auto [first, last, step] = range;
    // How many dimensions each file has may stand behind.
    if (take_word(&left).size() > 1 || step == 0 || (last - first) / step < 0 ||
        (last - first) / step >= static_cast<int64_t>(kMostDataFiles))
        return malformed(text);
    std::vector<std::string> out;
    for (int64_t n = 0; n <= (last - first) / step; ++n) {
        const auto width = static_cast<int>(pattern.digits);
        out.push_back(pattern.before + fmt::format("{:0{}}", first + n * step, width) +
                      pattern.behind);
    }
    return out;
}

}  // namespace openfab::texture
