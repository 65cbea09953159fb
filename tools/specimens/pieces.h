// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Standard test pieces: their names, sizes and outlines.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"

namespace openfab::specimens {

/// Of a polygon.
using Corner = Vec2<double>;

/// Millimetres. A disc has a diameter, `overall_mm`, a thickness, and no more.
struct Piece {
    std::string_view name;
    std::string_view standard;
    double overall_mm = 0, ends_mm = 0;     ///< length, and width of the ends
    double parallel_mm = 0, narrow_mm = 0;  ///< length and width of the part that is measured
    double fillet_mm = 0,
           shoulder_mm = 0;  ///< radii at the narrow part and at the ends; 0: no second one
    double thickness_mm = 0;
    double gauge_mm = 0,
           grips_mm = 0;  ///< the extensometer's length, and what is free between the grips

    bool is_disc() const { return parallel_mm == 0; }
};

std::span<const Piece> pieces();
/// Returns the piece of that name, or null.
const Piece* find_piece(std::string_view name);
std::vector<std::string> piece_names();

/// Returns the corners of a bar's outline, counterclockwise, its middle at the origin, along x; arcs are chords that
/// leave them by 5 um at most.
std::vector<Corner> outline(const Piece& bar);

/// Returns the outlines of a number's digits in cells, 3 wide and 5 high each, one cell apart, from (0, 0), with a line
/// below, so that 6 and 9 cannot be taken for one another. Polygons inside another one are holes.
std::vector<std::vector<Corner>> digits(int number);
/// Returns width and height of that, in cells.
Corner digits_size(int number);

}  // namespace openfab::specimens
