// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the strip of an edge is folded.
//
// Two faces that meet at a convex edge and move inwards keep their widths, so that each sticks out
// beyond the other:
//
//      U -------+-------- moved face of U          T, U   the edge point as either side moves it
//         .     |                                  e      the edge point before displacement
//            .  |
//      e        T
//
// A strip from T to U would add the triangle e T U to the winding numbers of what both faces cut
// away; where three such edges meet the sum is above 0 again, and a chip stays behind. So the
// strip is folded: from T to e, and from e to U. It then adds nothing, and the part is what neither
// face cut away. At a concave edge whose faces move outwards it is the mirror image: what either
// face covers is inside, and no bubbles stay behind.

#include "base/vec.h"
#include "runtime/surface/base_mesh.h"

namespace openfab::surface {

/// The test of the points of one edge.
class StripFold {
  public:
    /// `forward` is the side that runs up the edge; it has a partner.
    StripFold(const BaseMesh& base, int32_t forward);

    /// Returns whether the strip is folded at an edge point `e` that the forward side moves to `t`
    /// and the other to `u`: the edge is convex and both move inwards, or it is concave and both
    /// move outwards, each by more than 1/256 of a micro-edge along its triangle's normal; and
    /// each ends up beyond the plane in which the other triangle has moved.
    bool at(const Vec3f& e, const Vec3f& t, const Vec3f& u) const;
    /// Returns false only if `at` is false wherever the sides' displacements lie in these boxes.
    bool possible(const Box3d& forward, const Box3d& backward) const;

  private:
    Vec3d forward_normal_, backward_normal_;  ///< of the triangles' double areas, times the sense
    double forward_least_ = 0, backward_least_ = 0;
    bool flat_ = false;
};

}  // namespace openfab::surface
