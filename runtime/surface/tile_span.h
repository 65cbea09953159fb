// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Points whose convex hull holds a tile's micro-vertices before displacement.

#include <algorithm>
#include <array>
#include <cstdint>

#include "runtime/surface/base_mesh.h"
#include "runtime/surface/lattice.h"

namespace openfab::surface {

/// Those points, in barycentric weights of the triangle's corners 1 and 2.
struct TileSpan {
    int32_t points = 0;
    std::array<double, 10> wa{}, wb{};
    std::array<bool, 10> corner{};  ///< else the edge point to which the corner before it snaps

    void add(double a, double b, bool is_corner = true) {
        const auto i = static_cast<size_t>(points++);
        wa[i] = a, wb[i] = b, corner[i] = is_corner;
    }
};

/// Returns the corners of the tile's part of the triangle, at most five, and for those on an edge
/// the edge points to which they snap, as snapping moves them along the edge out of the tile.
TileSpan span_tile(const BaseMesh& base, int32_t triangle, const Tile& tile);

/// Calls visit(tile number) for every tile of a displaced triangle with a lattice point that snaps
/// into edge points [i0, i1] of the side, counted from the edge's lower end, and for a few more at
/// both ends.
template <typename Visit>
void visit_side_tiles(const BaseMesh& base, int32_t side, int32_t i0, int32_t i1,
                      const Visit& visit) {
    const int32_t n = base.lattice_factor(side / 3);
    const int64_t factor = base.factor[side];
    const int32_t l0 =
        std::max<int32_t>(0, static_cast<int32_t>(i0 * static_cast<int64_t>(n) / factor) - 2);
    const int32_t l1 =
        std::min<int32_t>(n, static_cast<int32_t>(i1 * static_cast<int64_t>(n) / factor) + 2);
    int32_t last = -1;
    for (int32_t l = l0; l <= l1; ++l) {
        const auto [a, b] = side_point(n, side % 3, base.forward(side) ? l : n - l);
        const int32_t tile = tile_of_point(n, a, b);
        if (tile != last) visit(tile);
        last = tile;
    }
}

/// Returns a tile of a displaced triangle that has the corner among its vertices.
inline int32_t corner_tile(const BaseMesh& base, int32_t corner) {
    const int32_t n = base.lattice_factor(corner / 3);
    const auto [a, b] = side_point(n, corner % 3, 0);
    return tile_of_point(n, a, b);
}

}  // namespace openfab::surface
