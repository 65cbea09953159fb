// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/foreign_characters.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>

#include "compiler/source/source_manager.h"

namespace openfab::syntax {

namespace {

constexpr ForeignCharacter kCharacters[] = {
    {0x00A0, "a no-break space", " ", "", false},
    {0x00B0, "a degree sign", "", "angles are in radians: `radians(45)`", false},
    {0x00B2, "a superscript 2", "", "a square is written `x * x`", false},
    {0x00B3, "a superscript 3", "", "a cube is written `x * x * x`", false},
    {0x00B5, "a micro sign", "", "lengths are in mm, without a unit: 20 µm are `0.02`", false},
    {0x00B7, "a middle dot", "*", "", false},
    {0x00D7, "a multiplication sign", "*", "", false},
    {0x00F7, "a division sign", "/", "", false},
    {0x03BC, "a Greek letter mu", "", "lengths are in mm, without a unit: 20 µm are `0.02`", false},
    {0x03C0, "a Greek letter pi", "", "declare it: `const float PI = 3.14159265;`", false},
    {0x2009, "a thin space", " ", "", false},
    {0x200B, "a zero-width space", "", "", false},
    {0x200C, "a zero-width non-joiner", "", "", false},
    {0x200D, "a zero-width joiner", "", "", false},
    {0x2010, "a hyphen", "-", "", false},
    {0x2011, "a no-break hyphen", "-", "", false},
    {0x2013, "an en dash", "-", "", false},
    {0x2014, "an em dash", "-", "", false},
    {0x2018, "a curved quote", "", "", true},
    {0x2019, "a curved quote", "", "", true},
    {0x201C, "a curved quote", "", "", true},
    {0x201D, "a curved quote", "", "", true},
    {0x201E, "a low quote", "", "", true},
    {0x00AB, "an angled quote", "", "", true},
    {0x00BB, "an angled quote", "", "", true},
    {0x2026, "an ellipsis", "", "write out what is left out", false},
    {0x202F, "a narrow no-break space", " ", "", false},
    {0x2060, "a word joiner", "", "", false},
    {0x2212, "a minus sign", "-", "", false},
    {0x2215, "a division slash", "/", "", false},
    {0x2217, "an asterisk operator", "*", "", false},
    {0x221A, "a square root sign", "", "a square root is written `sqrt(x)`", false},
    {0x221E, "an infinity sign", "", "write `1e38`, or `asfloat(0x7f800000)`", false},
    {0x2227, "a logical and", "&&", "", false},
    {0x2228, "a logical or", "||", "", false},
    {0x2260, "a not-equal sign", "!=", "", false},
    {0x2264, "a less-or-equal sign", "<=", "", false},
    {0x2265, "a greater-or-equal sign", ">=", "", false},
    {0x22C5, "a dot operator", "*", "", false},
    {0x3000, "a wide space", " ", "", false},
    {0xFEFF, "a byte-order mark", "", "", false},
};

/// The wide forms of `!` to `~` lie as those do, from U+FF01 on.
constexpr uint32_t kFirstWide = 0xFF01;
constexpr std::string_view kNarrow =
    "!\"#$%&'()*+,-./"
    "0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`abcdefghijklmnopqrstuvwxyz{|}~";

/// Reads the code point at a byte; 0 where the bytes are no UTF-8.
uint32_t code_point(std::string_view text, size_t at) {
    const size_t length = source::code_point_bytes(text, at);
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[at + i]); };
    if (length < 2 || length > 4) return 0;
    uint32_t out = byte(0) & (0x7fu >> length);
    for (size_t i = 1; i < length; ++i)
        out = out << 6 | (byte(i) & 0x3fu);
    return out;
}

}  // namespace

ForeignCharacter foreign_character(std::string_view text, size_t at) {
    const uint32_t code = code_point(text, at);
    const auto* const known = std::find_if(std::begin(kCharacters), std::end(kCharacters),
                                           [&](const auto& c) { return c.code_point == code; });
    if (known != std::end(kCharacters)) return *known;
    ForeignCharacter out{code, "", "", "", false};
    if (code < kFirstWide || code >= kFirstWide + kNarrow.size()) return out;
    constexpr std::string_view kPunctuation = "!%&()*+,-./:;<=>?@[]^{|}~";
    const std::string_view narrow = kNarrow.substr(code - kFirstWide, 1);
    if (kPunctuation.find(narrow) == std::string_view::npos) return out;
    out.name = "a wide form";
    out.ours = narrow;
    return out;
}

std::string described(const ForeignCharacter& c, std::string_view bytes) {
    std::array<char, 16> number{};
    std::snprintf(number.data(), number.size(), "U+%04X", c.code_point);
    if (c.code_point == 0) return "this character";
    if (c.name.empty()) return "this character (" + std::string(number.data()) + ")";
    const bool shows = c.ours != " " && !(c.ours.empty() && c.help.empty() && !c.is_quote);
    if (!shows) return std::string(c.name) + " (" + number.data() + ")";
    return "`" + std::string(bytes) + "` (" + number.data() + ", " + std::string(c.name) + ")";
}

}  // namespace openfab::syntax
