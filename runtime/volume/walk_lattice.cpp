// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/walk_lattice.h"

#include <algorithm>
#include <array>

#include "base/infinity.h"

namespace openfab::volume {

struct alignas(64) WalkLattice::Kept {
    float miss = 0, side = 0;
    std::array<Slot, 8> eighths{};
    WalkNodes own{}, object{};
    float over = 0;
    bool settled = false;  ///< its nodes are not what was asked
};

WalkLattice::WalkLattice(const Box3f& box, bool with_object, size_t bytes)
    : with_object_(with_object), most_bytes_(bytes), box_(box), grid_(box) {
    roots_ = std::make_unique<Slot[]>(root_count());
}

WalkLattice::~WalkLattice() {
    clear();
}

size_t WalkLattice::root_count() const {
    const auto& count = grid_.count();
    return size_t{count[0]} * count[1] * count[2];
}

void WalkLattice::release(Kept* kept) {
    if (kept == nullptr) return;
    const std::unique_ptr<Kept> owned(kept);
    for (Slot& slot : kept->eighths)
        release(slot.load());
}

void WalkLattice::clear() {
    for (size_t k = 0; k < root_count(); ++k)
        release(roots_[k].exchange(nullptr));
    taken_ = 0;
    full_ = false;
}

std::unique_ptr<WalkLattice> WalkLattice::another(size_t bytes) const {
    return std::make_unique<WalkLattice>(box_, with_object_, bytes);
}

/// Whether there is room for so much more; call with the lock.
bool WalkLattice::take(size_t bytes) {
    full_ = full_ || taken_ + bytes > most_bytes_;
    if (!full_) taken_ += bytes;
    return !full_;
}

/// A cell's corners are nodes of the cell around it.
bool WalkLattice::compute(const WalkCell& cell, const Kept* around, size_t octant,
                          WalkSampler* sampler, Kept* out) const {
    std::array<Vec3f, kWalkNodes> points;
    std::array<size_t, kWalkNodes> nodes{};
    size_t count = 0;
    for (size_t node = 0; node < kWalkNodes; ++node) {
        const std::array<size_t, 3> place = {node % 3, node / 3 % 3, node / 9};
        if (around != nullptr && !around->settled && place[0] != 1 && place[1] != 1 &&
            place[2] != 1) {
            const size_t same = (place[0] / 2 + (octant & 1)) +
                                3 * (place[1] / 2 + (octant >> 1 & 1)) +
                                9 * (place[2] / 2 + (octant >> 2 & 1));
            out->own[node] = around->own[same];
            if (with_object_) out->object[node] = around->object[same];
            continue;
        }
        points[count] = grid_.node(cell, node);
        nodes[count++] = node;
    }
    std::array<float, kWalkNodes> own{}, object{};
    if (!sampler->sample({points.data(), count}, own.data(),
                         with_object_ ? object.data() : nullptr))
        return false;
    for (size_t k = 0; k < count; ++k) {
        out->own[nodes[k]] = own[k];
        if (with_object_) out->object[nodes[k]] = object[k];
    }
    if (!with_object_) out->object.fill(kInfinity);
    out->settled = walk_settle(&out->own, out->side);
    if (with_object_) out->settled = walk_settle(&out->object, out->side) || out->settled;
    const WalkErrors errors = walk_errors(out->own, out->object, out->side);
    out->miss = errors.miss;
    out->over = errors.over;
    return true;
}

WalkLattice::Kept* WalkLattice::make(Slot* slot, const WalkCell& cell, const Kept* around,
                                     size_t octant, WalkSampler* sampler, Outcome* outcome) {
    auto made = std::make_unique<Kept>();
    made->side = grid_.side(cell);
    {
        const std::lock_guard lock(making_);
        *outcome = Outcome::kFull;
        if (full_) return nullptr;
    }
    *outcome = Outcome::kStopped;
    if (!compute(cell, around, octant, sampler, made.get())) return nullptr;
    const std::lock_guard lock(making_);
    // Another thread may have been quicker.
    if (Kept* kept = slot->load(std::memory_order_relaxed); kept != nullptr) return kept;
    *outcome = Outcome::kFull;
    if (!take(sizeof(Kept))) return nullptr;
    slot->store(made.get(), std::memory_order_release);
    return made.release();
}

/// Goes down one level in all points, then the next: cells that are not in a cache come while others are looked at.
void WalkLattice::read(std::span<Point> points, WalkSampler* sampler) {
    struct Way {
        WalkPlace at;
        WalkCell cell;
        Slot* slot;
        Kept* kept;
        const Kept* around;
        size_t octant;
    };
    std::array<Way, kMostPoints> ways;
    std::array<size_t, kMostPoints> open{};
    size_t left = 0;
    const auto& count = grid_.count();
    for (size_t k = 0; k < points.size(); ++k) {
        Way& way = ways[k];
        way.kept = nullptr;
        points[k].outcome = Outcome::kOutside;
        if (!grid_.find(points[k].p, &way.at)) continue;
        const auto root = [&](size_t a) { return size_t{way.at[a] >> kWalkUnitBits}; };
        way.cell = walk_root(way.at);
        way.slot = &roots_[(root(2) * count[1] + root(1)) * count[0] + root(0)];
        way.around = nullptr;
        way.octant = 0;
        open[left++] = k;
    }
    while (left > 0) {
        for (size_t i = 0; i < left; ++i) {
            Way& way = ways[open[i]];
            way.kept = way.slot->load(std::memory_order_acquire);
            __builtin_prefetch(way.kept);
        }
        size_t still = 0;
        for (size_t i = 0; i < left; ++i) {
            Way& way = ways[open[i]];
            Point& point = points[open[i]];
            if (way.kept == nullptr)
                way.kept =
                    make(way.slot, way.cell, way.around, way.octant, sampler, &point.outcome);
            if (way.kept == nullptr) continue;
            const size_t octant = walk_octant(way.cell, way.at);
            if (walk_reads(way.kept->side, way.cell.bits, way.kept->miss, point.stop)) {
                point.outcome = Outcome::kRead;
                __builtin_prefetch(&way.kept->own[octant]);
                __builtin_prefetch(&way.kept->own[octant + 13]);
                __builtin_prefetch(&way.kept->object[octant]);
                __builtin_prefetch(&way.kept->object[octant + 13]);
                continue;
            }
            way.slot = &way.kept->eighths[octant];
            way.around = way.kept;
            way.octant = octant;
            way.cell = walk_child(way.cell, octant);
            open[still++] = open[i];
        }
        left = still;
    }
    for (size_t k = 0; k < points.size(); ++k) {
        const Way& way = ways[k];
        if (points[k].outcome != Outcome::kRead) continue;
        points[k].field.over = way.kept->over;
        walk_read(way.kept->own, way.kept->object, way.cell, way.kept->side, way.at, with_object_,
                  &points[k].field);
    }
}

}  // namespace openfab::volume
