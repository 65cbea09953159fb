// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/cell_triangles.h"

#include "base/check.h"

namespace openfab::solid {

CellEdge cell_edge(int32_t edge) {
    const int32_t axis = edge / 4, u = edge & 1, v = edge >> 1 & 1;
    const int32_t first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;  // the other axes
    const int32_t from = u << first | v << second;
    return {from, from | 1 << axis};
}

namespace {

int32_t edge_between(int32_t a, int32_t b) {
    for (int32_t e = 0; e < 12; ++e) {
        const CellEdge edge = cell_edge(e);
        if ((edge.from == a && edge.to == b) || (edge.from == b && edge.to == a)) return e;
    }
    OPENFAB_CHECK(false);
    return 0;
}

/// The corners of a side, counter-clockwise from outside the cell.
std::array<int32_t, 4> side_corners(int32_t side) {
    const int32_t axis = side / 2, high = side % 2;
    const int32_t u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, at = high << axis;
    // u, v, axis are right-handed: u to v turns counter-clockwise seen from the axis' end.
    if (high != 0) return {at, at | u, at | u | v, at | v};
    return {at, at | v, at | u | v, at | u};
}

/// Finds which edge follows which around the surface in a cell: next[e], or -1.
std::array<int32_t, 12> follow(int32_t pattern) {
    std::array<int32_t, 12> next;
    next.fill(-1);
    const auto inside = [&](int32_t corner) { return (pattern >> corner & 1) != 0; };
    for (int32_t side = 0; side < 6; ++side) {
        const std::array<int32_t, 4> corner = side_corners(side);
        for (size_t i = 0; i < 4; ++i) {
            // A run of inside corners begins at i. A line goes from where the run is entered to
            // where it is left.
            if (!inside(corner[i]) || inside(corner[(i + 3) % 4])) continue;
            size_t last = i;
            while (inside(corner[(last + 1) % 4]))
                last = (last + 1) % 4;
            const int32_t entered = edge_between(corner[(i + 3) % 4], corner[i]);
            const int32_t left = edge_between(corner[last], corner[(last + 1) % 4]);
            next[static_cast<size_t>(entered)] = left;
        }
    }
    return next;
}

std::array<CellTriangles, 256> make_table() {
    std::array<CellTriangles, 256> table;
    for (int32_t pattern = 0; pattern < 256; ++pattern) {
        std::array<int32_t, 12> next = follow(pattern);
        for (int32_t first = 0; first < 12; ++first) {
            std::vector<int32_t> loop;
            for (int32_t e = first; next[static_cast<size_t>(e)] >= 0;) {
                loop.push_back(e);
                const int32_t to = next[static_cast<size_t>(e)];
                next[static_cast<size_t>(e)] = -1;
                e = to;
            }
            for (size_t i = 2; i < loop.size(); ++i)
                table[static_cast<size_t>(pattern)].push_back({loop[0], loop[i - 1], loop[i]});
        }
    }
    return table;
}

}  // namespace

const std::array<CellTriangles, 256>& cell_triangles() {
    static const std::array<CellTriangles, 256> table = make_table();
    return table;
}

}  // namespace openfab::solid
