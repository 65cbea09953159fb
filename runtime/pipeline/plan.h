// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print may keep in memory at once. The budget is for the whole process; it decides sizes of
// caches and how many groups are in flight, never what is printed.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/print.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

/// Bytes of the mapped textures of all parts, each counted once: read as the print goes on, they
/// become resident.
int64_t texture_bytes(const std::vector<scene::Part>& parts);

/// What setting up the surface of a part takes at least, by counts, before any of it is there. For
/// one whose fablet displaces nothing, nothing.
int64_t surface_bytes(const scene::Part& part);
/// The same for the box of a print, the index of patches and, where anything is asked for, the trees
/// over a surface that is set up.
int64_t tree_bytes(const surface::Surface& surface, bool asked);
/// Refuses what is large and cannot be had beside what is resident, before it is asked for.
Result<void> check_room(int64_t bytes, const PrintOptions& options);

/// Of one displaced surface and, the crossings, of one part that has it, in bytes.
struct CacheBudgets {
    size_t micropolygons = 0;  ///< surface::SurfaceOptions, each surface
    size_t crossings = 0;      ///< voxel::Voxeliser, each part
    size_t trees = 0;          ///< nearest::PatchCache, of all together
};

/// Decided before anything else is known but what is resident now.
CacheBudgets cache_budgets(const PrintOptions& options, int64_t resident, int64_t textures,
                           size_t displaced_surfaces, size_t displaced_parts);
/// What a print can do with where those leave too little for the rest of it; crossings, which keep
/// theirs, at the most that they may have.
CacheBudgets least_caches(size_t displaced_surfaces, size_t displaced_parts);

/// What a thread may hold at once of the trees of displaced patches.
size_t most_pinned(const PrintOptions& options, int32_t threads);

/// What trees of so many bytes make resident, as they come and go: the allocator keeps what lies
/// between those that stay (16 to 25 % more, measured).
inline int64_t resident_trees(size_t bytes) {
    return static_cast<int64_t>(bytes + bytes / 4);
}

struct MemoryPlan {
    int32_t groups_in_flight = 1;
    int32_t rows_in_flight = 2;
    int64_t total_bytes = 0;  ///< expected peak of the process
};

/// What the plan adds up.
struct MemoryNeeds {
    int64_t fixed = 0;       ///< resident after set-up, textures and caches still to be filled
    int64_t per_group = 0;   ///< planes, coverage, culling, errors, and encoded slices
    int64_t per_row = 0;     ///< a band with all its fractions
    int64_t per_thread = 0;  ///< kernel buffers and query scratch
};

/// `materials` of the stage set, `bits` of a packed voxel, `pinned` bytes as of most_pinned().
MemoryNeeds memory_needs(const std::vector<std::unique_ptr<PrintPart>>& parts, const Vec3i& size,
                         int32_t materials, int32_t bits, size_t pinned);

/// Refuses with the least budget that would do.
Result<MemoryPlan> make_plan(const MemoryNeeds& needs, const PrintOptions& options, int32_t threads,
                             int32_t groups);

}  // namespace openfab::slab
