// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <iterator>

namespace openfab {
namespace {

struct CodePoint {
    uint32_t value = 0;
    size_t bytes = 0;  ///< 0: not the start of a code point
};

/// Decodes the code point at the start of `text`, which is not empty. Overlong forms, surrogates
/// and values above U+10FFFF are invalid (Unicode 15, table 3-7).
CodePoint first_code_point(std::string_view text) {
    const auto byte = [&](size_t i) {
        return static_cast<uint32_t>(static_cast<uint8_t>(text[i]));
    };
    const uint32_t lead = byte(0);
    if (lead < 0x80) return {lead, 1};
    const size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
    uint32_t value = lead & (0x7Fu >> bytes);
    for (size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return {};
        value = value << 6 | (byte(i) & 0x3F);
    }
    const uint32_t least = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0x80;
    if (value < least || value > 0x10FFFF || (value >= 0xD800 && value <= 0xDFFF)) return {};
    return {value, bytes};
}

/// Code points that control a terminal, reorder the text around them, or are invisible. Joiners
/// stay: scripts and emoji need them.
bool misleads(uint32_t c) {
    constexpr struct {
        uint32_t first, last;
    } kRanges[] = {
        {0x00, 0x1F},     {0x7F, 0x9F},       // C0, DEL and C1
        {0x61C, 0x61C},   {0x200E, 0x200F},   // directional marks
        {0x202A, 0x202E}, {0x2066, 0x2069},   // embeddings, overrides, isolates
        {0x2028, 0x2029},                     // separators of lines and paragraphs
        {0x200B, 0x200B}, {0x2060, 0x2064},   // zero width
        {0x206A, 0x206F}, {0xFEFF, 0xFEFF},   // deprecated format characters, byte order mark
        {0xFFF9, 0xFFFB}, {0xE0000, 0xE007F}  // annotations and tags
    };
    for (const auto& range : kRanges) {
        if (c >= range.first && c <= range.last) return true;
    }
    return false;
}

std::string escaped(std::string_view text, bool lines) {
    std::string out;
    out.reserve(text.size());
    for (size_t i = 0; i < text.size();) {
        const CodePoint c = first_code_point(text.substr(i));
        const bool layout = text[i] == '\n' || text[i] == '\t';
        if (c.bytes == 0) {
            fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<uint8_t>(text[i]));
        } else if ((layout && lines) || !misleads(c.value)) {
            out += text.substr(i, c.bytes);
        } else if (layout) {
            out += text[i] == '\n' ? "\\n" : "\\t";
        } else if (c.value < 0x80) {
            fmt::format_to(std::back_inserter(out), "\\x{:02x}", c.value);
        } else {
            fmt::format_to(std::back_inserter(out), "\\u{{{:x}}}", c.value);
        }
        i += c.bytes == 0 ? 1 : c.bytes;
    }
    return out;
}

}  // namespace

std::string printable(std::string_view text) {
    return escaped(text, false);
}

std::string printable_lines(std::string_view text) {
    return escaped(text, true);
}

std::string printable_json(std::string_view json) {
    std::string out;
    out.reserve(json.size());
    const auto unit = [&](uint32_t value) {
        fmt::format_to(std::back_inserter(out), "\\u{:04x}", value);
    };
    for (size_t i = 0; i < json.size();) {
        const CodePoint c = first_code_point(json.substr(i));
        // ASCII control characters are white space here: JSON strings contain none.
        if (c.bytes == 0) {
            unit(0xFFFD);
        } else if (c.value < 0x7F || !misleads(c.value)) {
            out += json.substr(i, c.bytes);
        } else if (c.value < 0x10000) {
            unit(c.value);
        } else {
            unit(0xD7C0 + (c.value >> 10));
            unit(0xDC00 + (c.value & 0x3FF));
        }
        i += c.bytes == 0 ? 1 : c.bytes;
    }
    return out;
}

size_t code_point_bytes(std::string_view text) {
    return text.empty() ? 0 : first_code_point(text).bytes;
}

std::string valid_utf8(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (size_t i = 0; i < text.size();) {
        const size_t bytes = first_code_point(text.substr(i)).bytes;
        if (bytes == 0) {
            out += "\xEF\xBF\xBD";
        } else {
            out += text.substr(i, bytes);
        }
        i += bytes == 0 ? 1 : bytes;
    }
    return out;
}

std::string utf8_or_latin1(std::string_view text) {
    size_t valid = 0;
    while (valid < text.size()) {
        const size_t bytes = first_code_point(text.substr(valid)).bytes;
        if (bytes == 0) break;
        valid += bytes;
    }
    if (valid == text.size()) return std::string(text);
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<uint8_t>(c);
        if (byte < 0x80) {
            out += c;
        } else {
            out += static_cast<char>(0xC0 | byte >> 6);
            out += static_cast<char>(0x80 | (byte & 0x3F));
        }
    }
    return out;
}

std::string lower_ascii(std::string text) {
    for (char& c : text)
        c = lower_ascii(c);
    return text;
}

std::string shell_word(const std::string& text) {
    const auto is_plain = [](unsigned char c) {
        return std::isalnum(c) != 0 ||
               std::string_view("_./-+=:@%,").find(static_cast<char>(c)) !=
                   std::string_view::npos ||
               c >= 0x80;
    };
    if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
    std::string quoted = "'";
    for (const char c : text)
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

}  // namespace openfab
