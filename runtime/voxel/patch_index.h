// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds the patches of a surface that a slab of slices may meet: a hierarchy of boxes in part-local
// space, shared by all placements of the surface.

#include <cstdint>
#include <span>
#include <vector>

#include "base/check.h"
#include "base/vec.h"
#include "runtime/surface/surface.h"
#include "runtime/surface/transform_box.h"

namespace openfab::voxel {

/// The hierarchy of one surface.
class PatchIndex {
  public:
    /// Indexes the patches for coverage, in parallel. The surface need not outlive it. `morton` is
    /// surface::morton_order of its patches.
    PatchIndex(const surface::Surface& surface, std::span<const uint64_t> morton);
    explicit PatchIndex(const surface::Surface& surface);

    bool empty() const { return nodes_.empty(); }
    /// Returns the box of all patches; only if not empty().
    const Box3f& bounds() const { return nodes_.front().box; }
    size_t bytes() const {
        return nodes_.capacity() * sizeof(Node) + patches_.capacity() * sizeof(int32_t);
    }

    /// Calls visit(patch) for each patch for which meets(box) holds in all boxes above it, in no
    /// particular order.
    template <typename Meets, typename Visit>
    void find(const Meets& meets, const Visit& visit) const {
        int32_t stack[kMaxDepth];
        int32_t depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[static_cast<size_t>(stack[--depth])];
            if (!meets(node.box)) continue;
            if (node.child > 0) {
                OPENFAB_CHECK_LE(depth + 2, kMaxDepth);
                stack[depth++] = node.child;
                stack[depth++] = node.child + 1;
                continue;
            }
            for (int32_t i = node.first; i < node.end; ++i)
                visit(patches_[i]);
        }
    }

  private:
    /// Halving ends at leaves, so that 2^31 patches are 31 levels deep.
    static constexpr int32_t kMaxDepth = 64;
    static constexpr int32_t kLeafPatches = 4;
    struct Node {
        Box3f box;
        int32_t first = 0, end = 0;  ///< in patches_
        int32_t child = 0;           ///< the first of two neighbours; 0: a leaf
    };
    struct Builder;

    std::vector<Node> nodes_;
    std::vector<int32_t> patches_;
};

}  // namespace openfab::voxel
