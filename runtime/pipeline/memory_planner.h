// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Divides the memory budget of a print between caches, slabs in flight and threads. The
// budget is for the whole process; it decides how much is kept, never what is printed.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"

namespace openfab::pipeline {

/// Cache budgets in bytes.
struct CacheBudgets {
    size_t micropolygons = 0;  ///< per displaced surface, surface::SurfaceOptions
    size_t crossings = 0;      ///< per displaced part, voxel::Voxeliser
    size_t trees = 0;          ///< shared by all, nearest::PatchCache
};

/// The number of surfaces, and of parts that have one; parts may share a surface.
struct SurfaceCounts {
    size_t surfaces = 0, parts = 0;
};

/// The terms of a plan, bytes.
struct MemoryNeeds {
    int64_t fixed = 0;       ///< resident after set-up, plus textures, under any plan
    int64_t per_slab = 0;    ///< planes, coverage, culling, errors, and encoded slices
    int64_t per_row = 0;     ///< a band with all its fractions
    int64_t per_thread = 0;  ///< kernel buffers and query scratch
};

struct MemoryPlan {
    CacheBudgets caches;
    int32_t slabs_in_flight = 1;
    int32_t rows_in_flight = 2;
    int64_t total_bytes = 0;  ///< expected peak of the process
};

class MemoryPlanner {
  public:
    struct Budget {
        int64_t bytes = 0;     ///< without the reserved part
        int64_t reserved = 0;  ///< part of the user's budget, for previews
        /// What a print that needs more than `bytes` may take; caches are sized by `bytes`. 0: no more.
        int64_t most = 0;
    };

    MemoryPlanner(const Budget& budget, int32_t threads) : budget_(budget), threads_(threads) {}

    /// Fails where a large allocation of `bytes` beside what is `resident` would exceed the budget,
    /// before it is made.
    Result<void> check(int64_t bytes, int64_t resident) const;

    /// Chooses cache budgets when only the resident memory and the textures are known.
    CacheBudgets caches(const SurfaceCounts& displaced, int64_t resident, int64_t textures) const;

    /// Returns the bytes of displaced patches' trees that a thread may pin at once.
    size_t max_pinned_bytes() const;

    /// Returns the bytes that the lattices of random walks may keep.
    size_t walk_bytes() const;

    /// Plans the print of `slabs` slabs whose caches were chosen for `displaced` surfaces, of which
    /// the `diced` ones need theirs. If the budget is too small, caches shrink to their minimum;
    /// any rest goes to the trees. `max_slabs_in_flight` 0: as many as there are threads, and one
    /// more where that takes little of the budget. The error names the smallest sufficient budget.
    Result<MemoryPlan> plan(const MemoryNeeds& needs, const CacheBudgets& caches,
                            const SurfaceCounts& displaced, const SurfaceCounts& diced,
                            int32_t slabs, int32_t max_slabs_in_flight) const;

  private:
    Result<MemoryPlan> plan_with(const MemoryNeeds& needs, const CacheBudgets& caches,
                                 const SurfaceCounts& diced, int32_t slabs,
                                 int32_t max_slabs_in_flight) const;
    Error too_small(const std::string& why, const std::string& way_out) const;
    int64_t most() const { return std::max(budget_.bytes, budget_.most); }
    /// Returns, as text, a budget that suffices for `bytes`.
    std::string sufficient(int64_t bytes) const;

    Budget budget_;
    int32_t threads_;
};

}  // namespace openfab::pipeline
