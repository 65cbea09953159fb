// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the micropolygons of one patch. One dicer per thread; the result depends on the patch
// alone.

#include <span>
#include <vector>

#include "runtime/surface/base_mesh.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/micro_batch.h"
#include "runtime/surface/patch_table.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

/// Dices patches.
class Dicer {
  public:
    Dicer(const part::Part& part, const BaseMesh& base, const PatchTable& table,
          const StaticArgs& args, const NearestLayout& nearest, openfab_isa isa);

    /// Replaces `out`; it is empty where the surface kernel failed.
    abi::KernelStatus dice(int32_t patch, MicroMesh* out);
    /// The same for several patches of kind kLattice, with one call of the surface kernel.
    abi::KernelStatus dice_lattices(std::span<const int32_t> patches, std::vector<MicroMesh>* out);

    /// Numbers of displacements of the last call that were not finite, or cut to the user's bound.
    int64_t not_finite() const { return batch_.not_finite; }
    int64_t cut_to_bound() const { return batch_.cut_to_bound; }

  private:
    void dice_identity(int32_t triangle, MicroMesh* out) const;
    void dice_fan(const Patch& patch, MicroMesh* out) const;
    void dice_tile(const Patch& patch, int32_t first, int32_t count, MicroMesh* out);
    void dice_strip(const Seam& seam, MicroMesh* out);
    bool find_folds(const Seam& seam, int32_t forward_at, int32_t backward_at);
    void dice_folded_strip(const Seam& seam, int32_t forward_at, int32_t backward_at,
                           MicroMesh* out);
    void dice_vertex(const Seam& seam, MicroMesh* out);
    void append_vertices(int32_t first, int32_t count, MicroMesh* out) const;
    void append_ints(int32_t vertex, MicroMesh* out) const;
    void add_triangle(int32_t a, int32_t b, int32_t c, int32_t int_vertex, MicroMesh* out) const;

    const BaseMesh& base_;
    const PatchTable& table_;
    const NearestLayout& nearest_;
    MicroBatch batch_;
    std::vector<int32_t> firsts_;  ///< [patch]: its first point in the batch, and the end
    std::vector<Vec3f> edge_;      ///< a strip's points before displacement
    std::vector<uint8_t> folded_;  ///< [point] whether the strip is folded there
};

}  // namespace openfab::surface
