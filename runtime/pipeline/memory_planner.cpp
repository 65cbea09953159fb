// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/memory_planner.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/units.h"
#include "runtime/nearest/engine.h"
#include "runtime/pipeline/messages.h"

namespace openfab::pipeline {

namespace {

// Caches of a displaced surface, together.
constexpr size_t kMinCacheBytes = 24u << 20;
constexpr size_t kMaxCacheBytes = 800u << 20;
constexpr size_t kMaxCrossingBytes = 16u << 20;
// Micropolygons of one surface: those around some slabs. What lies behind the print is of no use.
constexpr size_t kMaxMicropolygonBytes = 48u << 20;

// The part of a budget that a slab may take which no thread works at.
constexpr int64_t kWaitingShare = 16;

// Smaller allocations are always made; the plan then states the needed budget to the megabyte.
constexpr int64_t kWorthRefusing = 200 << 20;

/// Rounds up to a number that format_bytes shows exactly and that suffices for the next run, too.
int64_t round_up_budget(int64_t bytes) {
    // Resident memory at the start differs from run to run: pages of code and data are loaded when
    // touched.
    constexpr int64_t kResidentSpread = 4 << 20;
    const int64_t unit = bytes < 900'000'000 ? 1'000'000 : 10'000'000;
    return (bytes + kResidentSpread + bytes / 64 + unit - 1) / unit * unit;
}

/// Splits `per_surface` bytes of each displaced surface into budgets.
CacheBudgets split_budget(size_t per_surface, size_t crossings, const SurfaceCounts& displaced) {
    const size_t surfaces = std::max<size_t>(displaced.surfaces, 1);
    CacheBudgets budgets;
    budgets.crossings = crossings * surfaces / std::max(displaced.parts, surfaces);
    budgets.micropolygons = std::min(per_surface / 3, kMaxMicropolygonBytes);
    // Trees get the rest: they take longest to build, and successive slices need the same ones.
    budgets.trees =
        (per_surface - std::min(crossings, per_surface / 6) - budgets.micropolygons) * surfaces;
    return budgets;
}

/// Returns the resident memory of a tree cache of `bytes`: the allocator keeps the gaps between
/// trees that stay (16 to 25 % more, measured).
int64_t resident_trees(size_t bytes) {
    return static_cast<int64_t>(bytes + bytes / 4);
}

/// Returns what full caches keep resident.
int64_t resident_caches(const CacheBudgets& caches, const SurfaceCounts& diced) {
    if (diced.parts == 0) return 0;
    return static_cast<int64_t>(caches.crossings * diced.parts +
                                caches.micropolygons * diced.surfaces) +
           resident_trees(caches.trees);
}

}  // namespace

Error MemoryPlanner::too_small(const std::string& why, const std::string& way_out) const {
    return user_error(fmt::format(messages::kBudgetTooSmall,
                                  format_bytes(most() + budget_.reserved), why, way_out));
}

std::string MemoryPlanner::sufficient(int64_t bytes) const {
    return format_bytes(round_up_budget(bytes + budget_.reserved));
}

Result<void> MemoryPlanner::check(int64_t bytes, int64_t resident) const {
    const int64_t needed = resident + bytes;
    if (bytes < kWorthRefusing || needed <= most()) return {};
    return too_small(fmt::format(messages::kSurfacesTake, sufficient(needed)),
                     messages::kSimplerMeshes);
}

CacheBudgets MemoryPlanner::caches(const SurfaceCounts& displaced, int64_t resident,
                                   int64_t textures) const {
    const int64_t left = std::max<int64_t>(budget_.bytes - resident - textures, 0);
    const size_t per_surface =
        std::clamp(static_cast<size_t>(left / 2) / std::max<size_t>(displaced.surfaces, 1),
                   kMinCacheBytes, kMaxCacheBytes);
    return split_budget(per_surface, std::min(per_surface / 6, kMaxCrossingBytes), displaced);
}

size_t MemoryPlanner::max_pinned_bytes() const {
    // At least a few patches, which a block near a surface needs.
    constexpr int64_t kLeast = 8 << 20;
    return static_cast<size_t>(std::clamp(budget_.bytes / 8 / threads_, kLeast,
                                          static_cast<int64_t>(nearest::kMaxPinnedBytes)));
}

size_t MemoryPlanner::walk_bytes() const {
    // Those of one part mostly take less than the most.
    constexpr int64_t kLeast = 4 << 20, kMost = 192 << 20;
    return static_cast<size_t>(std::clamp(budget_.bytes / 8, kLeast, kMost));
}

Result<MemoryPlan> MemoryPlanner::plan_with(const MemoryNeeds& needs, const CacheBudgets& caches,
                                            const SurfaceCounts& diced, int32_t slabs,
                                            int32_t max_slabs_in_flight) const {
    MemoryPlan plan;
    plan.caches = caches;
    // One row in evaluation, one waiting, and the one that the dither holds.
    plan.rows_in_flight = threads_ > 1 ? threads_ + 1 : 1;
    const int64_t slab = needs.per_slab + (plan.rows_in_flight + 1) * needs.per_row;
    const auto total = [&](int32_t in_flight) {
        return needs.fixed + resident_caches(caches, diced) + in_flight * slab +
               threads_ * needs.per_thread;
    };
    const int64_t limit = total(1) > budget_.bytes ? most() : budget_.bytes;
    if (total(1) > limit) {
        const bool one = threads_ == 1;
        return too_small(
            fmt::format(messages::kPrintNeeds, sufficient(total(1)), threads_, one ? "" : "s"),
            one ? "" : messages::kFewerThreads);
    }
    // With one more than threads, the thread of a slab that waits for the one below goes on. That is
    // worth some memory, but no part of what caches need.
    const bool waits = threads_ > 1 && slab <= budget_.bytes / kWaitingShare;
    const int32_t usual = threads_ + (waits ? 1 : 0);
    plan.slabs_in_flight =
        std::clamp(max_slabs_in_flight > 0 ? max_slabs_in_flight : usual, 1, std::max(slabs, 1));
    while (plan.slabs_in_flight > 1 && total(plan.slabs_in_flight) > limit)
        --plan.slabs_in_flight;
    plan.total_bytes = total(plan.slabs_in_flight);
    return plan;
}

Result<MemoryPlan> MemoryPlanner::plan(const MemoryNeeds& needs, const CacheBudgets& caches,
                                       const SurfaceCounts& displaced, const SurfaceCounts& diced,
                                       int32_t slabs, int32_t max_slabs_in_flight) const {
    OPENFAB_CHECK_LE(diced.surfaces, diced.parts);
    const auto with = [&](const CacheBudgets& some) {
        return plan_with(needs, some, diced, slabs, max_slabs_in_flight);
    };
    Result<MemoryPlan> plan = with(caches);
    // Crossings stay at their maximum: a voxeliser keeps its budget.
    const CacheBudgets least = split_budget(kMinCacheBytes, kMaxCrossingBytes, displaced);
    if (!plan) plan = with(least);
    if (plan && diced.parts > 0) {
        // Trees get a share of what the plan leaves: a slab needs those of the previous one, and
        // rebuilding them takes longer than anything else.
        const int64_t over = std::max<int64_t>(budget_.bytes - plan->total_bytes, 0) / 3;
        plan->total_bytes += resident_trees(static_cast<size_t>(over));
        plan->caches.trees += static_cast<size_t>(over);
    }
    return plan;
}

}  // namespace openfab::pipeline
