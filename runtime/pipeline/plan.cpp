// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "abi/stages.h"
#include "base/check.h"
#include "base/clock.h"
#include "base/units.h"
#include "runtime/part/bind.h"
#include "runtime/pipeline/slab.h"
#include "runtime/volume/evaluate.h"

namespace openfab::pipeline {

namespace {

// Allowance for what allocators hold back and thread stacks touch.
constexpr int64_t kSlackBytes = 16 << 20;
// Query scratch of a thread: candidate lists and the trees of one block.
constexpr int64_t kQueryScratchBytes = 4 << 20;
// Caches of a displaced surface, together.
constexpr size_t kMinCacheBytes = 24u << 20;
constexpr size_t kMaxCacheBytes = 800u << 20;
constexpr size_t kMaxCrossingBytes = 16u << 20;
// Resident memory at the start differs from run to run: pages of code and data are loaded when
// touched.
constexpr int64_t kResidentSpread = 4 << 20;

/// Rounds up to a number that format_bytes shows exactly and that is enough for the next run, too.
int64_t round_up_budget(int64_t bytes) {
    const int64_t unit = bytes < 900'000'000 ? 1'000'000 : 10'000'000;
    return (bytes + kResidentSpread + bytes / 64 + unit - 1) / unit * unit;
}

// Measured with a mesh of 1.28 M displaced triangles. Per base triangle: sides, corners and
// classes, and a patch. Per diced patch: the search for the bounding box, the index, and the tree
// while it is built.
constexpr int64_t kTriangleBytes = 140;
constexpr int64_t kPatchBytes = 48;
constexpr int64_t kPatchTreeBytes = 340;

// Smaller allocations are made; the plan then names the needed budget to the megabyte.
constexpr int64_t kWorthRefusing = 200 << 20;

/// Splits `per_surface` bytes of each displaced surface into budgets.
CacheBudgets split_budget(size_t per_surface, size_t crossings, size_t surfaces, size_t parts) {
    CacheBudgets budgets;
    budgets.crossings = crossings * surfaces / std::max(parts, surfaces);
    budgets.micropolygons = per_surface / 3;
    // Trees get the rest: they take longest to build, and successive slices need the same.
    budgets.trees =
        (per_surface - std::min(crossings, per_surface / 6) - budgets.micropolygons) * surfaces;
    return budgets;
}

}  // namespace

int64_t texture_bytes(const std::vector<part::Part>& parts) {
    std::set<const texture::Pyramid*> seen;
    int64_t bytes = 0;
    for (const part::Part& part : parts) {
        for (const auto& t : part.textures) {
            if (t == nullptr || !seen.insert(t.get()).second) continue;
            bytes += part::mapped_bytes(*t);
        }
    }
    return bytes;
}

int64_t surface_bytes(const part::Part& part) {
    if (part.fablet->has_surface == 0) return 0;
    return static_cast<int64_t>(part.mesh->triangles.size()) * kTriangleBytes;
}

int64_t tree_bytes(const surface::Surface& surface, bool asked) {
    const auto diced = std::count_if(
        surface.patches().begin(), surface.patches().end(),
        [](const surface::Patch& p) { return p.kind != surface::PatchKind::kIdentity; });
    return static_cast<int64_t>(diced) * (asked ? kPatchBytes + kPatchTreeBytes : kPatchBytes);
}

Result<void> check_memory(int64_t bytes, const PrintOptions& options) {
    const int64_t needed = resident_bytes() + bytes;
    if (bytes < kWorthRefusing || needed <= options.memory_bytes) return {};
    return user_error(fmt::format(
        "a memory budget of {} is too small: the displaced surfaces of this print take about {} to "
        "set up; raise `--memory`, or print simpler meshes",
        format_bytes(options.memory_bytes + options.reserved_bytes),
        format_bytes(round_up_budget(needed + options.reserved_bytes))));
}

CacheBudgets cache_budgets(const PrintOptions& options, int64_t resident, int64_t textures,
                           size_t displaced_surfaces, size_t displaced_parts) {
    const int64_t left = std::max<int64_t>(options.memory_bytes - resident - textures, 0);
    const size_t surfaces = std::max<size_t>(displaced_surfaces, 1);
    const size_t per_surface =
        std::clamp(static_cast<size_t>(left / 2) / surfaces, kMinCacheBytes, kMaxCacheBytes);
    return split_budget(per_surface, std::min(per_surface / 6, kMaxCrossingBytes), surfaces,
                        displaced_parts);
}

CacheBudgets min_cache_budgets(size_t displaced_surfaces, size_t displaced_parts) {
    return split_budget(kMinCacheBytes, kMaxCrossingBytes, std::max<size_t>(displaced_surfaces, 1),
                        displaced_parts);
}

size_t max_pinned_bytes(const PrintOptions& options, int32_t threads) {
    // At least a few patches: a block near a surface needs as many.
    constexpr int64_t kLeast = 8 << 20;
    return static_cast<size_t>(std::clamp(options.memory_bytes / 8 / threads, kLeast,
                                          static_cast<int64_t>(nearest::kMaxPinnedBytes)));
}

MemoryNeeds memory_needs(const std::vector<std::unique_ptr<volume::PlacedPart>>& parts,
                         const Vec3i& size, int32_t materials, int32_t bits, size_t pinned) {
    const int64_t channels = materials + 1;
    MemoryNeeds needs;
    needs.fixed = resident_bytes() + kSlackBytes;
    std::set<const nearest::BlockIndex*> trees;
    size_t held = 0;
    for (const auto& p : parts) {
        if (p->trees == nullptr || !trees.insert(p->trees.get()).second) continue;
        needs.fixed += static_cast<int64_t>(
            nearest::estimated_bytes(*p->trees, p->part->mesh->positions.size()));
        if (!p->surface->identity()) held += nearest::kHeldPatchBytes;
    }
    if (held > 0) held += pinned;
    const int64_t blocks_x = (size.x + 7) / 8;
    const int64_t plane = (int64_t{size.x} * bits + 7) / 8 * size.y;
    int64_t batch = 0, bounds = 0;
    std::map<int32_t, int64_t> starts;  // by slab: masks that begin there, less those that end
    for (const auto& p : parts) {
        const Vec3i extent = p->box.size();
        if (extent.x <= 0 || extent.y <= 0) continue;
        // A byte a column, and 4 a block for culling.
        const int64_t mask = (int64_t{extent.x} + 16) * (extent.y + 16) * 17 / 16;
        starts[p->box.lo.z / 8] += mask;
        starts[(p->box.hi.z + 7) / 8] -= mask;
        bounds = std::max(bounds, volume::CubeBounds::most_bytes(*p, volume::PartCull::kMostCubes));
        // Weights, codes and fractions twice: as they are and packed for normalise.
        const int64_t inputs = p->nearest.floats() * int64_t{p->volume.gradients ? 4 : 1} +
                               p->nearest.ints() + 2 * p->slots() + 2;
        // State, and as much again for what a kernel writes before it is scattered.
        const openfab_segments& segments = p->part->fablet->volume_segments;
        const int64_t state = int64_t{2} * segments.state_count * segments::group_limit(segments) *
                              segments::kLanes * 4;
        batch = std::max(batch, inputs * volume::BlockEvaluator::kBatch * 512 * 4 + state);
    }
    // Packed planes, and as much again for the sink's encoding.
    int64_t masks = 0, max_masks = 0;
    for (const auto& [slab, change] : starts)
        max_masks = std::max(max_masks, masks += change);
    needs.per_slab =
        16 * plane + max_masks + SlabRun::kUniformBlockBytes + blocks_x * 8 * 2 * 8 * channels * 4;
    needs.per_row = blocks_x * (512 * (2 * channels + 1) + 64 * 3);
    needs.per_thread = batch + bounds +
                       int64_t{volume::BlockEvaluator::kBatch} * 512 * (2 * channels + 5) * 2 +
                       kQueryScratchBytes + static_cast<int64_t>(held);
    return needs;
}

Result<MemoryPlan> make_plan(const MemoryNeeds& needs, const PrintOptions& options, int32_t threads,
                             int32_t slabs) {
    MemoryPlan plan;
    // A row that is evaluated, one that waits, and the one that the dither holds.
    plan.rows_in_flight = threads > 1 ? threads + 1 : 1;
    const int32_t max_in_flight = options.slabs_in_flight > 0 ? options.slabs_in_flight : threads;
    const auto total = [&](int32_t in_flight) {
        return needs.fixed +
               in_flight * (needs.per_slab + (plan.rows_in_flight + 1) * needs.per_row) +
               threads * needs.per_thread;
    };
    if (total(1) > options.memory_bytes) {
        return user_error(
            fmt::format("a memory budget of {} is too small: this print needs at least {} with {} "
                        "thread{}; raise `--memory`{}",
                        format_bytes(options.memory_bytes + options.reserved_bytes),
                        format_bytes(round_up_budget(total(1) + options.reserved_bytes)), threads,
                        threads == 1 ? "" : "s", threads == 1 ? "" : ", or lower `--threads`"));
    }
    plan.slabs_in_flight = std::clamp(max_in_flight, 1, std::max(slabs, 1));
    while (plan.slabs_in_flight > 1 && total(plan.slabs_in_flight) > options.memory_bytes)
        --plan.slabs_in_flight;
    OPENFAB_CHECK_GE(plan.slabs_in_flight, 1);
    plan.total_bytes = total(plan.slabs_in_flight);
    return plan;
}

}  // namespace openfab::pipeline
