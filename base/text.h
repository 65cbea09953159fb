// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Text of others, such as names in files, made fit for a terminal or for JSON.

#include <string>
#include <string_view>

namespace openfab {

/// One line of a terminal: control characters, bytes that are not UTF-8, and code points that
/// reorder or hide their neighbours become escapes, `\x1b`, `\n` or `\u{202e}`. All else stays,
/// so the function leaves its own result as it is.
std::string printable(std::string_view text);

/// The same for text of several lines: line feeds and tabs stay.
std::string printable_lines(std::string_view text);

/// JSON text whose strings hold no such code points raw, but as `\u202e`: the same JSON.
std::string printable_json(std::string_view json);

/// `A` to `Z` as small letters, whatever the locale says; all else as it is.
constexpr char lower_ascii(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
std::string lower_ascii(std::string text);

/// Bytes that are not UTF-8 become U+FFFD, as JSON needs it.
std::string valid_utf8(std::string_view text);

}  // namespace openfab
