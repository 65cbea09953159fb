// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of attributes in the XML of a 3MF.

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace openfab::mesh {

/// A colour in linear light, and its alpha.
using ThreemfColor = std::array<float, 4>;

/// Parses `#rrggbb` or `#rrggbbaa`, sRGB; none if it is something else.
std::optional<ThreemfColor> parse_threemf_color(std::string_view text);

/// Returns the text without blanks around it.
std::string_view trim_threemf(std::string_view text);

/// Returns the words between blanks.
std::vector<std::string_view> threemf_words(std::string_view text);

}  // namespace openfab::mesh
