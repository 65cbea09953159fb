// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table of a surface's patches with their bounds: identity triangles, tiles of displaced
// triangles, fans of identity triangles beside them, seams.

#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/surface/base_mesh.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

/// A piece of a strip, or all fans that close one vertex.
struct Seam {
    int32_t side = -1;  ///< strip: the side from the edge's lower end to the upper; -1: a vertex
    int32_t i0 = 0, i1 = 0;  ///< strip: edge points, both included
    int32_t vertex = -1;     ///< welded vertex
    bool folds = false;      ///< strip: it may be folded at some points (strip_fold.h)
};

/// All patches of a surface.
struct PatchTable {
    std::vector<Patch> patches;
    PatchRanges ranges;
    std::vector<int32_t> first_patch;  ///< [triangle]
    std::vector<Seam> seams;           ///< [patch - first_seam]
    int32_t first_seam = 0;
    bool identity = true;  ///< nothing is displaced
};

/// Pieces of an identity triangle's boundary that a fan covers: sides that are divided, or all
/// three around a centroid.
struct FanShape {
    int32_t apex_corner = -1;  ///< opposite the one divided side; -1: the centroid
    std::array<int32_t, 3> pieces{};
    int32_t total() const { return pieces[0] + pieces[1] + pieces[2]; }
};
/// Returns the fan of an identity triangle; total 0 if no side is divided into two or more.
FanShape fan_shape(const BaseMesh& base, int32_t triangle);

/// Decides base->classes: a triangle is an identity if it moves nothing and every output is a copy.
/// Sets edge factors if there is a surface stage.
Result<void> classify(const part::Part& part, const SurfaceOptions& options, const StaticArgs& args,
                      const NearestLayout& nearest, BaseMesh* base);

/// Decides base->classes, connects the mesh if something is displaced, and bounds all patches.
Result<PatchTable> make_patch_table(const part::Part& part, const SurfaceOptions& options,
                                    const StaticArgs& args, const NearestLayout& nearest,
                                    BaseMesh* base);

}  // namespace openfab::surface
