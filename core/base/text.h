// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes untrusted text, such as names from files, safe for a terminal or for JSON.

#include <string>
#include <string_view>

namespace openfab {

/// Returns the text as one line for a terminal: control characters, bytes that are not UTF-8, and
/// code points that reorder or hide their neighbours become escapes, `\x1b`, `\n` or `\u{202e}`.
/// Everything else stays, so the function is idempotent.
std::string printable(std::string_view text);

/// Same for several lines: line feeds and tabs stay.
std::string printable_lines(std::string_view text);

/// Returns equivalent JSON in which such code points are escaped as `\u202e`.
std::string printable_json(std::string_view json);

/// Lowercases `A` to `Z`, independently of the locale, and leaves all else as it is.
constexpr char lower_ascii(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
std::string lower_ascii(std::string text);

/// Returns the text as one word of a shell's command line, in quotes where it needs them.
std::string shell_word(const std::string& text);

/// Returns the length of the code point at the start of a text; 0 where it does not start with UTF-8.
size_t code_point_bytes(std::string_view text);

/// Replaces bytes that are not UTF-8 by U+FFFD, as JSON requires.
std::string valid_utf8(std::string_view text);

/// Returns text that is UTF-8 as it is; else each byte as the letter that it is in Latin-1.
std::string utf8_or_latin1(std::string_view text);

}  // namespace openfab
