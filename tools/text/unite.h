// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Outlines of letters as fonts have them, which may overlap themselves and each other, as areas that can
// be drawn out: filled by the nonzero rule, as every program that shows text fills them.

#include <vector>

#include "mesh/model/outline.h"
#include "tools/text/font.h"

namespace openfab::text {

/// An outline, counter-clockwise, and those of its holes, clockwise. None touches another.
using Area = std::vector<mesh::Outline>;

/// Returns the areas that the glyphs cover together, in order of their first glyphs. Places are rounded
/// to `finest`, slits thinner than a quarter of `least` are closed, splinters thinner than `least` are
/// left out, and areas that touch at a corner are parted by less than that.
std::vector<Area> unite(const std::vector<Glyph>& glyphs, double finest, double least);

}  // namespace openfab::text
