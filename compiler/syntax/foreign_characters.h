// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Characters beyond ASCII that word processors, web pages and other alphabets put in place of those of OpenFL.

#include <cstdint>
#include <string>
#include <string_view>

namespace openfab::syntax {

struct ForeignCharacter {
    uint32_t code_point = 0;
    std::string_view name;  ///< "a minus sign"; empty if it is not known
    /// What is meant: a token of OpenFL, a space, or nothing. Not known where `help` is not empty or `name` is.
    std::string_view ours;
    std::string_view help;
    bool is_quote = false;
};

/// Returns what is known of the character at a byte of a text.
ForeignCharacter foreign_character(std::string_view text, size_t at);

/// Returns the character as a message names it: "`−` (U+2212, a minus sign)".
std::string described(const ForeignCharacter& c, std::string_view bytes);

}  // namespace openfab::syntax
