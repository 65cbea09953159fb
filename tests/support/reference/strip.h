// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The strip that joins the two sides of an edge, point by point: where it is folded
// (runtime/surface/strip_fold.h), and its triangles.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::reference {

/// A point of an edge, counted up the edge: before displacement, as the side that runs up moves it,
/// and as the other side does.
struct StripPoint {
    Vec3f edge, up, down;
};

struct StripEdge {
    Vec3d low, high;                          ///< its ends
    std::array<Vec3d, 3> up_face, down_face;  ///< the triangles of the two sides
    double micro_edge_mm = 0;
};

/// Which place of a point a corner of a triangle is. kEdgeUp and kEdgeDown are one place, with the
/// attributes of either side.
enum class StripPlace { kUp, kDown, kEdgeUp, kEdgeDown };

struct StripTriangle {
    struct Corner {
        StripPlace place;
        int32_t point;
    };
    int32_t quad = 0;  ///< between this point and the next
    std::array<Corner, 3> corners;
    int32_t ints_from = 0;  ///< point
    enum { kOfUp, kOfDown, kOfLower } ints = kOfLower;
};

bool is_folded(const StripEdge& edge, const StripPoint& point);

/// Returns the triangles in order, those without area among them.
std::vector<StripTriangle> strip_triangles(const StripEdge& edge,
                                           const std::vector<StripPoint>& points);

}  // namespace openfab::reference
