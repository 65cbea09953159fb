// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The set-up of a print: solids, displacement bounds, query trees, the grid, the plan of its memory.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/nearest/engine.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/memory_planner.h"
#include "runtime/pipeline/print_input.h"
#include "runtime/pipeline/print_options.h"
#include "runtime/pipeline/slab.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/solid/solid.h"
#include "runtime/support_material/depth_map.h"
#include "runtime/surface/surface.h"
#include "runtime/volume/placed_part.h"

namespace openfab::pipeline {

/// Slices of one slab.
struct SlabSlices {
    int32_t slab = -1;
    int32_t first = 0, end = 0;
    int32_t shift = 0;  ///< to their numbers in the sink
    process::SliceEffects effects;
};

/// A print that is set up. It stays as it is from the first slab to the last; caches in it fill.
struct PrintSetup {
    PrintInput input;
    PrintOptions options;
    int32_t threads = 1;
    part::Grid grid;
    Vec2<int32_t> range;  ///< slices that are printed: [x, y)
    PrintInfo info;
    surface::SurfaceOptions surface_options;
    std::vector<int32_t> owners;                        ///< by part: the first one with its solid
    std::vector<std::shared_ptr<solid::Solid>> solids;  ///< by part
    std::shared_ptr<nearest::PatchCache> trees;         ///< of displaced patches
    std::vector<std::unique_ptr<volume::PlacedPart>> parts;  ///< in build order
    std::unique_ptr<const support_material::DepthMap> support;
    SlabSetup slabs;  ///< points to the parts
    MemoryPlan plan;
    std::vector<std::string> warnings;
    double seconds = 0;  ///< that set-up took

    bool owns_solid(size_t part) const { return owners[part] == static_cast<int32_t>(part); }
    /// Returns what is diced of the solid that a part owns; null where nothing is, or another owns it.
    const solid::Dicing* own_dicing(size_t part) const {
        return owns_solid(part) ? solids[part]->dicing() : nullptr;
    }
    solid::QuerySetUp queries() const { return {options.isa, trees}; }
    SlabSlices slices_of(int32_t slab) const {
        return {slab, std::max(8 * slab, range.x), std::min(8 * slab + 8, range.y), 0};
    }
    /// Returns how many patches were diced so far, again after they had left the cache, too.
    int64_t patches_diced() const;
    /// A patch whose kernel failed is empty in all slabs from the first one that needed it.
    Result<void> solid_status() const;
};

/// Sets a print up. Fails where the budget is too small, with the smallest sufficient one, and before
/// what cannot fit is allocated.
Result<std::unique_ptr<PrintSetup>> set_up_print(PrintInput input, PrintOptions options);

}  // namespace openfab::pipeline
