// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colours of materials in the texts of prints: `#rrggbbaa`.

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace openfab::backends {

using Rgba = std::array<uint8_t, 4>;

inline std::string hex_color(const Rgba& c) {
    return fmt::format("#{:02x}{:02x}{:02x}{:02x}", c[0], c[1], c[2], c[3]);
}

/// Reads a colour; false where the text is none.
inline bool read_color(std::string_view text, Rgba* out) {
    if (text.size() != 9 || text[0] != '#') return false;
    for (size_t i = 0; i < 4; ++i) {
        const char* const from = text.data() + 1 + 2 * i;
        if (std::from_chars(from, from + 2, (*out)[i], 16).ptr != from + 2) return false;
    }
    return true;
}

}  // namespace openfab::backends
