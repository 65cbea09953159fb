// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Plans the memory of a print. The budget is for the whole process; it determines cache sizes and
// the number of slabs in flight, never what is printed.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/print_job.h"
#include "runtime/volume/placed_part.h"

namespace openfab::pipeline {

/// Returns the bytes of the mapped textures of all parts, each counted once; they become resident
/// as the print reads them.
int64_t texture_bytes(const std::vector<part::Part>& parts);

/// Returns a lower bound, from counts, of the memory for setting up the surface of a part; 0 where
/// the fablet displaces nothing.
int64_t surface_bytes(const part::Part& part);
/// Returns the same for the bounding box, the index of patches and, if `asked`, the trees over a
/// surface that is set up.
int64_t tree_bytes(const surface::Surface& surface, bool asked);
/// Fails where a large allocation of `bytes` would exceed the budget, before it is made.
Result<void> check_memory(int64_t bytes, const PrintOptions& options);

/// Cache budgets in bytes.
struct CacheBudgets {
    size_t micropolygons = 0;  ///< per displaced surface, surface::SurfaceOptions
    size_t crossings = 0;      ///< per displaced part, voxel::Voxeliser
    size_t trees = 0;          ///< shared by all, nearest::PatchCache
};

/// Chooses cache budgets before anything but the resident memory is known.
CacheBudgets cache_budgets(const PrintOptions& options, int64_t resident, int64_t textures,
                           size_t displaced_surfaces, size_t displaced_parts);
/// Returns the smallest usable budgets, for prints where the usual ones leave too little for the
/// rest; crossings stay at their maximum.
CacheBudgets min_cache_budgets(size_t displaced_surfaces, size_t displaced_parts);

/// Returns the bytes of displaced patches' trees that a thread may pin at once.
size_t max_pinned_bytes(const PrintOptions& options, int32_t threads);

/// Returns the resident memory of a tree cache of `bytes`: the allocator keeps the gaps between
/// trees that stay (16 to 25 % more, measured).
inline int64_t resident_trees(size_t bytes) {
    return static_cast<int64_t>(bytes + bytes / 4);
}

struct MemoryPlan {
    int32_t slabs_in_flight = 1;
    int32_t rows_in_flight = 2;
    int64_t total_bytes = 0;  ///< expected peak of the process
};

/// The terms of the plan, bytes.
struct MemoryNeeds {
    int64_t fixed = 0;       ///< resident after set-up, plus textures and caches yet to be filled
    int64_t per_slab = 0;    ///< planes, coverage, culling, errors, and encoded slices
    int64_t per_row = 0;     ///< a band with all its fractions
    int64_t per_thread = 0;  ///< kernel buffers and query scratch
};

/// Computes the terms. `materials` of the stage set, `bits` of a packed voxel, `pinned` from
/// max_pinned_bytes().
MemoryNeeds memory_needs(const std::vector<std::unique_ptr<volume::PlacedPart>>& parts,
                         const Vec3i& size, int32_t materials, int32_t bits, size_t pinned);

/// Makes the plan; the error names the smallest sufficient budget.
Result<MemoryPlan> make_plan(const MemoryNeeds& needs, const PrintOptions& options, int32_t threads,
                             int32_t slabs);

}  // namespace openfab::pipeline
