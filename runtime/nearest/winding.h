// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inside or outside at any point: the winding number of the displaced surface, as the voxeliser
// sees it but with vertices where they are (not snapped), exactly.
//
// A ray runs from the point along +x of part-local space; the point is moved by an infinitesimal
// (e, e², e³), as in voxel/crossings.h, so that no ray meets an edge and no point lies on the
// surface. Inside is a winding number above zero (rules 14 and 16).

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/engine.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

class Winding {
  public:
    /// The surface must outlive it. `closed`: every coverage edge has its opposite, as for all
    /// parts; off, nothing is concluded from distances.
    explicit Winding(const surface::Surface& surface, bool closed = true);

    /// Winding number of p, whose coordinates are finite. About 0.3 µs where patches are whole
    /// triangles; a displaced patch that the ray meets is diced, and its triangles walked.
    int32_t number(const Vec3f& p) const;

    /// A point of which the side is known.
    struct Known {
        Vec3f p;
        float distance_mm = -1;  ///< to the surface, unsigned; -1: nothing is known
        bool inside = false;
    };
    /// What a thread knows from the group before; never changes an answer.
    struct Memory {
        std::array<Known, 8> known;
    };
    /// Points that are inside, one for each lane, where `mask` has its bit.
    struct Centres {
        const PointGroup* points = nullptr;
        uint32_t mask = 0;
        float slack_mm = 0;  ///< how far the surface in which they are inside may be off
    };

    /// Which asking lanes with an answer are inside. `answers` are the group's own, unbounded: two
    /// points closer together than either is to the surface are on one side of it, so that most
    /// need no ray.
    uint32_t inside(const PointGroup& group, const PointAnswer& answers, const Centres& centres,
                    Memory* memory) const;

  private:
    /// Box in (y, z), and the end along x. `link` as in hierarchy.h: leaves hold 1 to 4 triangles,
    /// or one patch (count 0).
    struct Node {
        float y_lo, y_hi, z_lo, z_hi, x_hi;
        uint32_t link;
    };
    struct Item;
    void build(size_t node, Item* first, Item* last);
    bool one_side(const Vec3f& p, float distance, const Known& known) const;

    const surface::Surface& surface_;
    const bool closed_;
    float largest_ = 0;
    std::vector<Node> nodes_;
    std::vector<std::array<Vec3f, 3>> triangles_;  ///< in leaf order
};

}  // namespace openfab::nearest
