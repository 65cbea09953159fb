// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles by which a cell of a lattice of values is cut, for each pattern of corners that are
// inside: marching cubes (Lorensen and Cline 1987), with a table that is made by its rule. On a side
// whose corners alternate, inside corners are cut off one by one. That depends on the side's own corners
// alone, so that cells that share it agree, and the surface is closed.

#include <array>
#include <cstdint>
#include <vector>

namespace openfab::solid {

/// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e runs along axis e / 4; of the four
/// edges of an axis, number e % 4 starts at the corner whose other two coordinates, in the order of
/// axes, are its bits.
struct CellEdge {
    int32_t from, to;  ///< corners
};
CellEdge cell_edge(int32_t edge);

/// Triangles of one pattern, by edges, counter-clockwise from outside.
using CellTriangles = std::vector<std::array<int32_t, 3>>;

/// Returns the triangles of each pattern of inside corners, bit c for corner c.
const std::array<CellTriangles, 256>& cell_triangles();

}  // namespace openfab::solid
