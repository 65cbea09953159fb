// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/walk_lattice.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/infinity.h"

namespace openfab::volume {

WalkLattice::WalkLattice(const Box3f& box, bool with_object, size_t bytes)
    : with_object_(with_object), most_bytes_(bytes), box_(box), grid_(box) {
    roots_ = std::make_unique<Slot[]>(root_count());
    cells_ = {grid_.origin(), grid_.per_unit(), grid_.count(), roots_.get(), with_object};
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
    for (Kept* eighth : kept->eighths)
        release(eighth);
}

void WalkLattice::clear() {
    for (size_t k = 0; k < root_count(); ++k)
        release(std::exchange(roots_[k], nullptr));
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
    out->reads_from = walk_reads_from(out->side, errors.miss);
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
    if (*slot != nullptr) return *slot;
    *outcome = Outcome::kFull;
    if (!take(sizeof(Kept))) return nullptr;
    __atomic_store_n(slot, made.get(), __ATOMIC_RELEASE);
    return made.release();
}

WalkLattice::Outcome WalkLattice::read(const Vec3f& p, float stop, WalkSampler* sampler,
                                       WalkField* out) {
    WalkPlace at;
    if (!grid_.find(p, &at)) return Outcome::kOutside;
    const auto& count = grid_.count();
    const auto root = [&](size_t a) { return size_t{at[a] >> kWalkUnitBits}; };
    Slot* slot = &roots_[(root(2) * count[1] + root(1)) * count[0] + root(0)];
    WalkCell cell = walk_root(at);
    const Kept* around = nullptr;
    size_t octant = 0;
    while (true) {
        Kept* kept = __atomic_load_n(slot, __ATOMIC_ACQUIRE);
        Outcome outcome = Outcome::kRead;
        if (kept == nullptr) kept = make(slot, cell, around, octant, sampler, &outcome);
        if (kept == nullptr) return outcome;
        octant = walk_octant(cell, at);
        if (stop >= kept->reads_from || cell.bits <= 2) {
            out->over = kept->over;
            walk_read(kept->own, kept->object, cell, kept->side, at, with_object_, out);
            return Outcome::kRead;
        }
        slot = &kept->eighths[octant];
        around = kept;
        cell = walk_child(cell, octant);
    }
}

}  // namespace openfab::volume
