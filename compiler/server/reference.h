// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the language reference (compiler/OPENFL.md, section 8) says of built-in functions and methods, which is part of
// the program, and short texts for markers and keywords.

#include <string>
#include <string_view>
#include <vector>

namespace openfab::server {

struct ReferenceEntry {
    std::string form;  ///< `lerp(a, b, t)`, or the name alone
    std::string text;  ///< Markdown; may be empty
};

/// Returns the rows of the reference about a built-in function or method.
std::vector<ReferenceEntry> reference_of(std::string_view name);

/// Returns a line about a marker such as `@Volume`, given without its `@`; empty if there is none.
std::string_view marker_text(std::string_view name);
/// Returns the markers.
std::vector<std::string_view> markers();

}  // namespace openfab::server
