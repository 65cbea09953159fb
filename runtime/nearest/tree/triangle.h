// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Closest-point arithmetic: the single definition, to the bit, of the distance from a point to a
// triangle, shared by all query engines. The vector forms in the kernel do the same operations in
// the same order.
//
// Definition, in float, for triangle (v0, v1, v2) and point p, with w = p - v0: the least distance2
// of these *features*, ties going to the first:
//   - the face, if the three distances s_i from the edge lines, positive inwards, are all
//     >= margin: h h, with the plane distance h = n.w;
//   - edges 0, 1, 2, each if p is nearest to a point between its ends;
//   - vertices 0, 1, 2.
// An edge is evaluated from its two ends alone, taken in lexicographic order of position, and a
// vertex from its position, so all triangles around them get equal bits; the query kernel evaluates
// each once (tree/features.h).
// The margin (2^-23 of the longest edge, about the rounding error of s_i) keeps needles right:
// without it a point beyond the tip of a needle could pass as inside, far from the tip. It errs by
// assigning such points to the edge. n and the edge normals are rounded from double,
// so slivers have good planes; a triangle without area has only edges.
//
// Error: |d - d_ref| <= 1e-5 d_ref + 2^-21 (largest coordinate); tests/property/nearest checks it
// against double.

#include <cstdint>

#include "base/vec.h"

namespace openfab::nearest {

/// The part of a triangle that a test against a packet reads first: one cache line.
struct alignas(64) TriangleFrame {
    float v0[3];
    float n[3];     ///< unit normal; zero where the triangle has no area
    float m[3][3];  ///< unit inward normal in the plane of edge i = (v_i, v_{i+1}); zero where
                    ///< there is no area
    float height0;  ///< distance of v0 from edge 1
};

/// The part that is read only if the triangle may be the nearest.
struct TriangleDetail {
    float v1[3];
    float v2[3];
    float margin;       ///< > 0, mm
    float inv_height1;  ///< 1 / distance of v1 from edge 2
    float inv_height2;  ///< 1 / distance of v2 from edge 0
    int32_t patch;
    int32_t triangle;
    uint32_t flags;  ///< bit i: edge i's end v_{i+1} comes first in lexicographic order of position
};

/// A closest point on a triangle.
struct Hit {
    float distance2;
    float bary1, bary2;
};

/// Precomputes a triangle.
void make_triangle(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, int32_t patch,
                   int32_t triangle, TriangleFrame* frame, TriangleDetail* detail);

/// Evaluates the definition above for one point. Part-local mm in, mm² out.
Hit closest_point(const TriangleFrame& frame, const TriangleDetail& detail, const Vec3f& p);

/// Returns whether `a` wins a tie with `b`: lowest patch, then lowest triangle.
inline bool precedes(int32_t patch_a, int32_t triangle_a, int32_t patch_b, int32_t triangle_b) {
    return patch_a < patch_b || (patch_a == patch_b && triangle_a < triangle_b);
}

}  // namespace openfab::nearest
