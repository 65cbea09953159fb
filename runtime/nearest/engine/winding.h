// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Classifies points as inside or outside: the exact winding number of the displaced surface, as in
// the voxeliser but without snapping vertices.
//
// A ray runs from the point along +x of part-local space; the point is perturbed by an
// infinitesimal (e, e², e³), as in voxel/crossings.h, so that no ray meets an edge and no point
// lies on the surface. Inside is a winding number above zero (rules 14 and 16).
//
// A ray through a displaced surface would dice the patches along it, all over the part, for each
// point again. So the number is derived, where possible, from a known one close by: it changes
// where the segment between the two points crosses the surface. A segment that touches an edge, or
// ends on a triangle's plane, is undecided; then the ray is used.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/triangle_runs.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

class Winding {
  public:
    /// Builds a tree over the surface, which must outlive it. `closed`: every coverage edge has its
    /// opposite, as in all parts; if false, no number is derived from another point's.
    explicit Winding(const surface::Surface& surface, bool closed = true);

    /// Winding number of p, whose coordinates are finite, by a ray. About 0.3 µs where patches are
    /// whole triangles; a displaced patch that the ray meets is diced.
    int32_t number(const Vec3f& p) const;

    /// An unknown number above zero.
    static constexpr int32_t kAboveZero = std::numeric_limits<int32_t>::max();
    /// A point whose winding number is known.
    struct Known {
        Vec3f p;
        float distance_mm = -1;  ///< to the surface, unsigned; -1: no such point
        int32_t number = 0;
    };
    /// The points of a thread's previous packet; never changes an answer.
    struct Memory {
        std::array<Known, 8> known;
        TriangleRuns runs;
    };
    /// Points known to be inside, one per lane with its bit in `mask`.
    struct Centers {
        const PointPacket* points = nullptr;
        uint32_t mask = 0;
        float slack_mm = 0;  ///< how far the surface that contains them may deviate
    };

    /// Returns the active lanes with an answer that are inside. `answers` are those of the packet,
    /// without radius: two points closer together than either is to the surface are on the same
    /// side of it, so that most need no test against it.
    uint32_t inside(const PointPacket& packet, const PointAnswer& answers, const Centers& centers,
                    Memory* memory) const;

  private:
    /// `link` as in hierarchy.h: leaves hold 1 to 4 triangles, or one diced patch (count 0), by its
    /// index in diced_.
    struct Node {
        Box3f box;
        uint32_t link;
    };
    /// A patch that is diced on demand, and, once diced, its box, which is much tighter than its
    /// bounds.
    struct Diced {
        int32_t patch;
        uint8_t state;  ///< atomic
        Box3f box;
    };
    enum : uint8_t { kUnknown, kBeingWritten, kKnown };
    struct Item;
    struct Paths;
    using Numbers = std::array<int32_t, 8>;

    void build(size_t node, Item* first, Item* last);
    bool one_side(const Vec3f& p, float distance, const Known& known) const;
    Numbers numbers(const PointPacket& packet, const std::array<Known, 8>& known,
                    TriangleRuns* runs) const;
    void follow(Paths* paths, TriangleRuns* runs) const;
    void follow(size_t diced, Paths* paths, TriangleRuns* runs) const;

    const surface::Surface& surface_;
    const bool closed_;
    float largest_ = 0;
    std::vector<Node> nodes_;
    std::vector<std::array<Vec3f, 3>> triangles_;  ///< in leaf order
    mutable std::vector<Diced> diced_;
};

}  // namespace openfab::nearest
