// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A tree of boxes over beams, which answers for points: the nearest beam by signed distance, and the
// beams that may be nearest to, or hold, a point of a ball or a box. 56 bytes a beam, and 16 for boxes.
//
// Pruning has slack for what floats lose, so that answers are those of all beams compared in order.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/part/part.h"
#include "runtime/solid/beams/beam.h"

namespace openfab::solid {

/// The nearest beam of a point: the least signed distance; ties go to the lowest number.
struct NearestBeam {
    int32_t beam = -1;  ///< in BeamTree::beams
    float distance = 0;
};

class BeamTree {
  public:
    explicit BeamTree(const part::PartBeams& source);

    /// Returns the beams, in the order of the tree.
    const std::vector<BeamRecord>& beams() const { return beams_; }
    /// Returns the box of all, part-local.
    const Box3f& bounds() const { return nodes_[0].box; }
    /// Returns by how much distances of points like this may be wrong, with a margin.
    float slack(const Vec3f& p) const;

    /// Finds the nearest beam; `start` is one to begin with, or -1, and does not change the answer.
    NearestBeam nearest(const Vec3f& p, int32_t start) const;
    /// Appends the beams whose signed distance to `p` is at most `limit`, and maybe a few more.
    void collect(const Vec3f& p, float limit, std::vector<int32_t>* out) const;
    /// Appends the beams whose boxes touch a box.
    void collect(const Box3f& box, std::vector<int32_t>* out) const;

    /// Returns the bytes for this number of beams.
    static int64_t bytes(int64_t beams) {
        return beams * static_cast<int64_t>(sizeof(BeamRecord) + 2 * sizeof(Node) / kLeaf);
    }

  private:
    static constexpr int32_t kLeaf = 4;
    struct Node {
        Box3f box;
        int32_t first =
            0;  ///< of a leaf: its first beam; else its second child, the first follows it
        int32_t count = 0;  ///< beams of a leaf, else 0
    };
    struct Item;
    void build(std::span<Item> items, int32_t first, int32_t node);

    std::vector<BeamRecord> beams_;
    std::vector<Node> nodes_;
};

}  // namespace openfab::solid
