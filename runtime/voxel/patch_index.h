// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which patches of a surface a group of slices may meet: a hierarchy of boxes in part-local space,
// shared by all places where the surface stands.

#include <cstdint>
#include <span>
#include <vector>

#include "base/check.h"
#include "base/vec.h"
#include "runtime/surface/map_box.h"
#include "runtime/surface/surface.h"

namespace openfab::voxel {

class PatchIndex {
  public:
    /// Of the patches that the voxeliser sees, in parallel. The surface need not outlive it.
    /// `along` is surface::along_curve of its patches.
    PatchIndex(const surface::Surface& surface, std::span<const uint64_t> along);
    explicit PatchIndex(const surface::Surface& surface);

    bool empty() const { return nodes_.empty(); }
    /// All patches; only where there are any.
    const Box3f& bounds() const { return nodes_.front().box; }
    size_t bytes() const {
        return nodes_.capacity() * sizeof(Node) + patches_.capacity() * sizeof(int32_t);
    }

    /// Calls visit(patch) for each patch whose boxes above it all have meets(box). No order is
    /// promised.
    template <typename Meets, typename Visit>
    void find(const Meets& meets, const Visit& visit) const {
        int32_t stack[kDeepest];
        int32_t depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[static_cast<size_t>(stack[--depth])];
            if (!meets(node.box)) continue;
            if (node.child > 0) {
                OPENFAB_CHECK_LE(depth + 2, kDeepest);
                stack[depth++] = node.child;
                stack[depth++] = node.child + 1;
                continue;
            }
            for (int32_t i = node.first; i < node.end; ++i)
                visit(patches_[static_cast<size_t>(i)]);
        }
    }

  private:
    /// Halving ends at leaves, so that 2^31 patches are 31 levels deep.
    static constexpr int32_t kDeepest = 64;
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
