// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_text.h"

#include <algorithm>

#include "base/color.h"

namespace openfab::mesh {

std::optional<ThreemfColor> parse_threemf_color(std::string_view text) {
    text = trim_threemf(text);
    if ((text.size() != 7 && text.size() != 9) || text[0] != '#') return {};
    std::array<int, 8> digits{};
    digits.fill(15);  // opaque
    for (size_t i = 1; i < text.size(); ++i) {
        const size_t digit = std::string_view("0123456789abcdef0123456789ABCDEF").find(text[i]);
        if (digit == std::string_view::npos) return {};
        digits[i - 1] = static_cast<int>(digit % 16);
    }
    ThreemfColor out{};
    for (size_t c = 0; c < out.size(); ++c) {
        const double value = (digits[c * 2] * 16 + digits[c * 2 + 1]) / 255.0;
        out[c] = static_cast<float>(c < 3 ? srgb_to_linear(value) : value);
    }
    return out;
}

std::string_view trim_threemf(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

std::vector<std::string_view> threemf_words(std::string_view text) {
    std::vector<std::string_view> words;
    for (text = trim_threemf(text); !text.empty(); text = trim_threemf(text)) {
        const size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
        words.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return words;
}

}  // namespace openfab::mesh
