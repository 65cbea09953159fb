// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the built-in functions and methods are called: for messages and editors. `floatN` is a float or a vector of
// floats, `boolN` and `intN` likewise; `T` is any number or vector; N, or T, is the same throughout a form.

#include <string_view>
#include <vector>

namespace openfab::check {

struct Signature {
    std::string_view name;
    std::string_view form;  ///< "floatN lerp(floatN a, floatN b, floatN t)"
    std::string_view text;  ///< what it gives, Markdown
};

/// Returns all, those of one name one after the other.
const std::vector<Signature>& signatures();
/// Returns those of a name.
std::vector<Signature> signatures_of(std::string_view name);
/// Returns the parameters of a form: "floatN a".
std::vector<std::string_view> parameters_of(std::string_view form);

}  // namespace openfab::check
