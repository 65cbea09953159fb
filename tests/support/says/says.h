// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds a message of a catalogue (a room's messages.h) in what was said, whatever its wording.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <string_view>
#include <vector>

namespace openfab::testing {

/// Whether the whole of a text is as a pattern, in which '\0' stands for any characters.
inline bool is_like(std::string_view text, std::string_view pattern) {
    const size_t any = pattern.find('\0');
    if (any == std::string_view::npos) return text == pattern;
    if (!text.starts_with(pattern.substr(0, any))) return false;
    text.remove_prefix(any);
    pattern.remove_prefix(any + 1);
    // What follows stands as early as possible; the last part at the end.
    const size_t next = pattern.find('\0');
    if (next == std::string_view::npos) return text.ends_with(pattern);
    const size_t at = text.find(pattern.substr(0, next));
    return at != std::string_view::npos && is_like(text.substr(at), pattern);
}

/// Returns the pattern of texts that hold a message. `values` take the places of its placeholders in
/// order; `*` in one, and each that is not given, are any characters.
inline std::string pattern_of(std::string_view message, const std::vector<std::string>& values) {
    std::string out(1, '\0');
    size_t placeholders = 0;
    for (size_t i = 0; i < message.size(); ++i) {
        const bool doubled = i + 1 < message.size() && message[i + 1] == message[i];
        if (message[i] == '{' && !doubled) {
            std::string value = placeholders < values.size() ? values[placeholders] : "*";
            for (char& c : value)
                c = c == '*' ? '\0' : c;
            out += value;
            ++placeholders;
            i = message.find('}', i);
        } else {
            out += message[i];
            if (doubled && (message[i] == '{' || message[i] == '}')) ++i;
        }
    }
    return out + '\0';
}

/// Whether a text holds a message.
inline bool says(std::string_view text, std::string_view message) {
    return is_like(text, pattern_of(message, {}));
}

MATCHER_P2(IsLike, message, pattern, "says \"" + message + '"') {
    return is_like(arg, pattern);
}

/// Matches a text that holds a message: `EXPECT_THAT(error.text(), Says(messages::kNoFaces, "*", "part"))`;
/// `values` as in pattern_of.
template <typename... Values>
auto Says(std::string_view message, const Values&... values) {
    return IsLike(std::string(message), pattern_of(message, {fmt::format("{}", values)...}));
}

}  // namespace openfab::testing
