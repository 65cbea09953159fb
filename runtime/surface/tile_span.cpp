// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/tile_span.h"

#include <algorithm>

namespace openfab::surface {

namespace {

/// Adds the edge points to which lattice point (a, b) snaps, on the sides it lies inside of.
void add_snapped(const BaseMesh& base, int32_t triangle, int32_t a, int32_t b, TileSpan* span) {
    const int32_t n = base.lattice_factor(triangle);
    const std::array<int32_t, 3> on_side{b == 0 ? a : -1, a + b == n ? b : -1, a == 0 ? n - b : -1};
    for (int32_t side = 0; side < 3; ++side) {
        const int32_t l = on_side[side];
        if (l < 0 || l == 0 || l == n) continue;
        const int32_t s = 3 * triangle + side;
        const int32_t factor = base.factor[s];
        int32_t i = snap_to_edge(base.forward(s) ? l : n - l, factor, n);
        if (!base.forward(s)) i = factor - i;
        const double t = static_cast<double>(i) / factor;
        if (side == 0) span->add(t, 0, false);
        if (side == 1) span->add(1 - t, t, false);
        if (side == 2) span->add(0, 1 - t, false);
    }
}

}  // namespace

TileSpan span_tile(const BaseMesh& base, int32_t triangle, const Tile& tile) {
    TileSpan span;
    const int32_t n = base.lattice_factor(triangle);
    const auto add_corner = [&](int32_t a, int32_t b) {
        span.add(static_cast<double>(a) / n, static_cast<double>(b) / n);
        add_snapped(base, triangle, a, b, &span);
    };
    const int32_t far_a = std::min(tile.a1, n - tile.b0), far_b = std::min(tile.b1, n - tile.a0);
    add_corner(tile.a0, tile.b0);
    add_corner(far_a, tile.b0);
    add_corner(tile.a0, far_b);
    if (far_a + far_b > n) {
        // The far side cuts the tile's corner off.
        if (far_a != n - tile.b0) add_corner(far_a, n - far_a);
        if (far_b != n - tile.a0) add_corner(n - far_b, far_b);
    } else if (far_a > tile.a0 && far_b > tile.b0) {
        add_corner(far_a, far_b);
    }
    return span;
}

}  // namespace openfab::surface
