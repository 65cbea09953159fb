// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutations/mutate.h"

#include <array>
#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/fuzz/mutations/move_elements.h"

namespace openfab::testing {

namespace {

constexpr std::array<const char*, 26> kNumbers{"0",          "-0",
                                               "1",          "-1",
                                               "2",          "0.5",
                                               "-0.001",     "1e-30",
                                               "1e-320",     "1e30",
                                               "-1e30",      "1e308",
                                               "1e999",      "255",
                                               "256",        "65535",
                                               "100000",     "2147483647",
                                               "2147483648", "-2147483649",
                                               "4294967296", "1e5",
                                               "nan",        "-inf",
                                               "0x7f",       "99999999999999999999999"};

constexpr std::array<const char*, 20> kTexts{"null",
                                             "true",
                                             "[]",
                                             "{}",
                                             "\"\"",
                                             "\"white\"",
                                             "[1, 2, 3]",
                                             "{\"object\": \"ball\"}",
                                             "\"../../../etc/passwd\"",
                                             "\"/dev/zero\"",
                                             "\"\\u0000\"",
                                             "\"\\ud800\"",
                                             "\xef\xbb\xbf",
                                             "\xf0\x9f\x90\x98",
                                             "\xc3\x28",
                                             "\xff\xfe",
                                             "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
                                             "/* */",
                                             "&amp;<x/>",
                                             "\r\n\t"};

using Generator = std::mt19937_64;

size_t below(Generator* random, size_t n) {
    return n == 0 ? 0 : (*random)() % n;
}

/// Start and length.
using Range = std::pair<size_t, size_t>;

bool in_number(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+' ||
           c == 'e' || c == 'E';
}

std::vector<Range> numbers_of(std::string_view text) {
    std::vector<Range> found;
    for (size_t i = 0; i < text.size(); ++i) {
        if (std::isdigit(static_cast<unsigned char>(text[i])) == 0) continue;
        size_t begin = i;
        if (begin > 0 && text[begin - 1] == '-') --begin;
        while (i < text.size() && in_number(text[i]))
            ++i;
        found.emplace_back(begin, i - begin);
    }
    return found;
}

/// Returns the length of the JSON value that begins at `i`; 0 if none does.
size_t value_length(std::string_view text, size_t i) {
    if (text[i] == '"') {
        size_t end = i + 1;
        while (end < text.size() && text[end] != '"')
            end += text[end] == '\\' ? 2 : 1;
        return std::min(end + 1, text.size()) - i;
    }
    if (text[i] != '{' && text[i] != '[') return 0;
    int depth = 0;
    for (size_t end = i; end < text.size(); ++end) {
        depth += text[end] == '{' || text[end] == '[' ? 1 : 0;
        depth -= text[end] == '}' || text[end] == ']' ? 1 : 0;
        if (depth == 0) return end + 1 - i;
    }
    return 0;
}

/// Texts and numbers, lists and objects.
std::vector<Range> values_of(std::string_view text) {
    std::vector<Range> found = numbers_of(text);
    for (size_t i = 0; i < text.size(); ++i) {
        const size_t n = value_length(text, i);
        if (n > 0) found.emplace_back(i, n);
        if (n > 0 && text[i] == '"') i += n - 1;
    }
    return found;
}

std::vector<Range> lines_of(std::string_view text) {
    std::vector<Range> found;
    for (size_t i = 0; i < text.size();) {
        const size_t end = std::min(text.find('\n', i), text.size() - 1) + 1;
        found.emplace_back(i, end - i);
        i = end;
    }
    return found;
}

void change_bytes(std::string* bytes, Generator* random) {
    const auto place = [&] { return below(random, bytes->size()); };
    switch (below(random, 6)) {
        case 0:
            (*bytes)[place()] = static_cast<char>((*random)());
            break;
        case 1:
            (*bytes)[place()] ^= static_cast<char>(1 << below(random, 8));
            break;
        case 2:
            // A field of 4 bytes at an extreme.
            for (size_t i = 0, at = place(); i < 4 && at + i < bytes->size(); ++i)
                (*bytes)[at + i] = static_cast<char>((*random)() % 2 == 0 ? 0xff : 0x7f);
            break;
        case 3:
            bytes->erase(place(), 1 + below(random, 16));
            break;
        case 4: {
            const std::string piece = bytes->substr(place(), 1 + below(random, 60));
            bytes->insert(place(), piece);
            break;
        }
        default:
            bytes->resize(place());
    }
}

void change_text(std::string* text, Generator* random) {
    const auto one_of = [&](const std::vector<Range>& ranges) {
        return ranges[below(random, ranges.size())];
    };
    const size_t way = below(random, 8);
    if (way == 0) return change_bytes(text, random);
    if (way >= 6 && move_element(text, random)) return;
    const std::vector<Range> ranges = way <= 2   ? numbers_of(*text)
                                      : way <= 4 ? values_of(*text)
                                                 : lines_of(*text);
    if (ranges.empty()) return change_bytes(text, random);
    const auto [at, n] = one_of(ranges);
    if (way <= 2) {
        text->replace(at, n, kNumbers[below(random, kNumbers.size())]);
        return;
    }
    const auto [other, length] = one_of(ranges);
    const std::string piece = text->substr(other, length);
    switch (below(random, way == 5 ? 3 : 4)) {
        case 0:
            text->erase(at, n);
            break;
        case 1:
            text->insert(at, piece);  // a line or a key twice
            break;
        case 2:
            text->replace(at, n, piece);  // another type
            break;
        default:
            text->replace(at, n, kTexts[below(random, kTexts.size())]);
    }
}

}  // namespace

std::string mutate(std::string bytes, bool text, std::mt19937_64* random) {
    // A text with several faults is rejected at the first: mostly makes one change.
    const size_t changes = 1 + below(random, 2) * below(random, 4);
    for (size_t i = 0; i < changes && !bytes.empty() && bytes.size() < (1U << 20); ++i) {
        if (text) {
            change_text(&bytes, random);
        } else {
            change_bytes(&bytes, random);
        }
    }
    return bytes;
}

}  // namespace openfab::testing
