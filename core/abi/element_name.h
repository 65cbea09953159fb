// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of uniforms that may name one element of an array: `table`, `table[3]`.

#include <cstdint>
#include <cstdlib>
#include <string>

namespace openfab::abi {

struct Element {
    std::string name;
    int32_t index = -1;  ///< -1: all of it
};

/// Takes a name apart; one without an index in brackets at its end is all of it.
inline Element element_of(const std::string& text) {
    const size_t open = text.find('[');
    const size_t digits = open == std::string::npos ? 0 : text.size() - open - 2;
    const bool indexed = open != std::string::npos && text.back() == ']' && digits > 0 &&
                         digits < 7 &&
                         text.find_first_not_of("0123456789", open + 1) == text.size() - 1;
    if (!indexed) return {text, -1};
    return {text.substr(0, open), std::atoi(text.c_str() + open + 1)};
}

/// Which numbers of a uniform an element has.
struct Numbers {
    int32_t first = 0, count = 0;
};

inline Numbers numbers_of(const Element& element, int32_t components, int32_t array_length) {
    if (element.index < 0) return {0, components * array_length};
    return {element.index * components, components};
}

}  // namespace openfab::abi
