// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Conversion from part-local millimetres to the snapped coordinates of crossings.h.

#include <array>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/surface/lattice.h"
#include "runtime/voxel/crossings.h"

namespace openfab::voxel {

/// The snapping of one part in a grid.
class Snapping {
  public:
    /// `identity`: the part's surface is displaced nowhere.
    Snapping(const part::Part& part, const part::Grid& grid, bool identity)
        : mesh_(*part.mesh), map_(part::local_to_voxel(part, grid)), identity_(identity) {
        const auto& m = map_.m;
        const double det = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                           m[2] * (m[3] * m[7] - m[4] * m[6]);
        turn_ = det < 0 ? -1 : 1;
        for (double& v : map_.m)
            v *= kSnap;
        map_.t = map_.t * static_cast<double>(kSnap);
    }

    /// Part-local mm -> 1/256 voxel; scaling by 256 is exact.
    const Affine3d& map() const { return map_; }
    /// The `turn` that add_crossings takes: -1 if the map mirrors.
    int32_t turn() const { return turn_; }

    Vec3i point(const Vec3d& p) const {
        const Vec3d v = map_.apply(p);
        return {snap(v.x), snap(v.y), snap(v.z)};
    }
    Vec3i point(const Vec3f& p) const { return point(vec_cast<double>(p)); }
    /// Snaps the corners of an identity triangle. In a displaced surface they are rounded to float
    /// first, like the micropolygons beside it. Else they are snapped in double: floats are
    /// relative to the part's own center, so the two sides of a cut would round one vertex
    /// differently.
    std::array<Vec3i, 3> triangle(int32_t base_triangle) const {
        std::array<Vec3i, 3> out;
        for (size_t c = 0; c < 3; ++c) {
            const auto at = static_cast<size_t>(mesh_.triangles[base_triangle][c]);
            const Vec3d& p = mesh_.positions[at];
            out[c] = identity_ ? point(p) : point(surface::round_position(p));
        }
        return out;
    }

  private:
    const part::PartMesh& mesh_;
    Affine3d map_;
    bool identity_;
    int32_t turn_ = 1;
};

}  // namespace openfab::voxel
