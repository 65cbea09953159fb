// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/memory_needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "abi/stages.h"
#include "base/check.h"
#include "base/clock.h"
#include "base/units.h"
#include "runtime/part/bind_textures.h"
#include "runtime/pipeline/slab_parts.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/point_queries.h"

namespace openfab::pipeline {

namespace {

// Allowance for memory retained by allocators, and for thread stacks.
constexpr int64_t kSlackBytes = 16 << 20;
// Query scratch of a thread: candidate lists and the trees of one block.
constexpr int64_t kQueryScratchBytes = 4 << 20;

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

MemoryNeeds memory_needs(const std::vector<std::unique_ptr<volume::PlacedPart>>& parts,
                         const Vec3i& size, int32_t fraction_channels, int32_t bits,
                         size_t pinned) {
    const int64_t channels = fraction_channels;
    MemoryNeeds needs;
    needs.fixed = resident_bytes() + kSlackBytes;
    std::set<const solid::Solid*> asked, evaluated;
    size_t held = 0;
    for (const auto& p : parts) {
        if (evaluated.insert(p->solid.get()).second) needs.fixed += p->solid->body_bytes();
        if (p->placed->engine() == nullptr || !asked.insert(p->solid.get()).second) continue;
        needs.fixed += p->solid->query_bytes();
        if (p->solid->dicing() != nullptr) held += nearest::kHeldPatchBytes;
    }
    if (held > 0) held += pinned;
    std::set<const volume::WalkLattice*> lattices;
    for (const auto& p : parts) {
        for (const auto& lattice : p->lattices) {
            if (lattice != nullptr && lattices.insert(lattice.get()).second)
                needs.fixed += static_cast<int64_t>(lattice->most_bytes());
        }
    }
    const int64_t blocks_x = (size.x + 7) / 8;
    const int64_t plane = (int64_t{size.x} * bits + 7) / 8 * size.y;
    int64_t batch = 0, bounds = 0, stored = 0;
    std::map<int32_t, int64_t> starts;  // by slab: masks that begin there minus those that end
    for (const auto& p : parts) {
        const Vec3i extent = p->box.size();
        if (extent.x <= 0 || extent.y <= 0) continue;
        // A byte per column, and 4 per block for culling.
        const int64_t mask = (int64_t{extent.x} + 16) * (extent.y + 16) * 17 / 16;
        starts[p->box.lo.z / 8] += mask;
        starts[(p->box.hi.z + 7) / 8] -= mask;
        bounds = std::max(bounds, volume::CubeBounds::most_bytes(*p, volume::PartCull::kMostCubes));
        // Query results, fractions; and codes, counts and demand.
        const int64_t inputs = p->nearest.floats() * int64_t{p->volume.gradients ? 4 : 1} +
                               p->nearest.ints() + p->slots() + 4;
        // State, and as much again for what a kernel writes before it is scattered.
        const openfab_segments& segments = p->part->fablet->volume_segments;
        const int64_t state = int64_t{2} * segments.state_count * segments::group_limit(segments) *
                              segments::kLanes * 4;
        stored = std::max(stored, p->part->fablet->stored_bytes);
        batch = std::max(batch, inputs * volume::BlockEvaluator::kBatch * 512 * 4 + state);
    }
    // Packed planes, and as much again for the sink's encoding.
    int64_t masks = 0, max_masks = 0;
    for (const auto& [slab, change] : starts)
        max_masks = std::max(max_masks, masks += change);
    needs.per_slab = 16 * plane + max_masks + SlabParts::kUniformBlockBytes +
                     blocks_x * 8 * 2 * 8 * channels * 4;
    needs.per_row = blocks_x * (512 * (2 * channels + 1) + 64 * 7);
    needs.per_thread = batch + bounds + stored + kQueryScratchBytes + static_cast<int64_t>(held);
    if (!lattices.empty()) needs.per_thread += int64_t{volume::PointQueries::kSpareBytes};
    return needs;
}

}  // namespace openfab::pipeline
