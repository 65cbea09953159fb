// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What compiler/check/signatures.def says of built-in functions and methods, and short texts for markers.

#include <string>
#include <string_view>
#include <vector>

namespace openfab::server {

struct ReferenceEntry {
    std::string form;  ///< `floatN lerp(floatN a, floatN b, floatN t)`
    std::string text;  ///< Markdown
};

/// Returns the ways to call a built-in function or method.
std::vector<ReferenceEntry> reference_of(std::string_view name);

/// Returns a line about a marker such as `@Volume`, given without its `@`; empty if there is none.
std::string_view marker_text(std::string_view name);
/// Returns the markers.
std::vector<std::string_view> markers();

}  // namespace openfab::server
