// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A text as a mesh that can be printed, or as a picture for a texture.

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/model/mesh.h"
#include "tools/text/font.h"
#include "tools/text/unite.h"

namespace openfab::text {

enum class Align { kLeft, kCenter, kRight };

/// What its letters cover, in mm: the box around all is centred on the origin. Areas are apart from each
/// other: letters that overlap, as those of a joined script, are one, and a letter of several parts is
/// several.
struct Layout {
    std::vector<Area> areas;
    Vec2<double> size_mm;
};

/// Lays out lines, which newlines end. Fails where nothing of the text has an area.
Result<Layout> lay_out(Font* font, const std::string& text, Align align);

/// Draws the text out to `depth_mm` above z = 0. Each area is closed, with "uv", "n" and "face" as
/// extrusions have them (mesh/model/sweeps.h), but the text's box in place of the area's for uv.
/// Fails for a text of too many corners.
Result<mesh::Mesh> make_text_mesh(const Layout& layout, double depth_mm);

/// The mesh as an OBJ file with the groups `front`, `back` and `side`.
std::string obj_text(const mesh::Mesh& mesh);

/// Draws the text in white on black, 8 bits of grey, edges by the area that they cover; at least
/// `margin_mm` around it. A PNG file with its resolution.
struct Picture {
    std::vector<uint8_t> png;
    int32_t width = 0, height = 0;
};
Result<Picture> draw_text(const Layout& layout, double dots_per_mm, double margin_mm);

}  // namespace openfab::text
