// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Boxes of the triangles of diced patches, so many in a row. Triangles that follow each other in a
// patch lie beside each other, so that a ray, or a step from one voxel to the next, meets few of
// these boxes, and a patch of which it meets none need not be diced again.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Those of the patches that one thread asked for last. What is kept never shows in an answer.
class TriangleRuns {
  public:
    static constexpr size_t kTriangles = 32;  ///< in a run; fewer in the last of a patch

    /// Boxes of the patch's runs, in order, until the next call. `mesh` is set where the patch had
    /// to be looked at.
    const std::vector<Box3f>& of(const surface::Surface& surface, int32_t patch,
                                 std::shared_ptr<const surface::MicroMesh>* mesh);

  private:
    static constexpr size_t kPatches = 64;  ///< about 100 kB of full tiles
    struct Kept {
        int32_t patch = -1;
        std::vector<Box3f> boxes;
    };
    std::vector<Kept> kept_;  ///< a patch has one place, by its number
};

}  // namespace openfab::nearest
