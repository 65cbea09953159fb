// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Boxes of runs of consecutive triangles of diced patches. Consecutive triangles are adjacent, so a
// ray, or a step from one voxel to the next, meets few of these boxes, and a patch none of whose
// boxes it meets need not be diced again.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// The boxes of the patches that one thread used last. What is cached never affects an answer.
class TriangleRuns {
  public:
    static constexpr size_t kTriangles = 32;  ///< in a run; fewer in the last of a patch

    /// Returns the boxes of the patch's runs, in order, valid until the next call. `mesh` is set if
    /// the patch had to be diced.
    const std::vector<Box3f>& of(const surface::Surface& surface, int32_t patch,
                                 std::shared_ptr<const surface::MicroMesh>* mesh);

  private:
    static constexpr size_t kPatches = 64;  ///< about 100 kB of full tiles
    struct Kept {
        int32_t patch = -1;
        std::vector<Box3f> boxes;
    };
    std::vector<Kept> kept_;  ///< direct-mapped by patch number
};

}  // namespace openfab::nearest
