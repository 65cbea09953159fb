// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lattice of random walks (walk.h), kept: cells are made where a walk comes first, by queries of their nodes, and
// stay. Threads share it. A cell is a pure function of its place, so it does not matter who makes it, or whether it is
// kept.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "base/vec.h"
#include "runtime/volume/walk_lanes.h"

namespace openfab::volume {

/// Computes nodes: distances as in WalkField. False: the print is to stop.
class WalkSampler {
  public:
    virtual ~WalkSampler() = default;
    virtual bool sample(std::span<const Vec3f> points, float* own, float* object) = 0;
};

class WalkLattice {
  public:
    /// What is in the box is known, `bytes` are kept. `with_object`: nodes have distances to one, too.
    WalkLattice(const Box3f& box, bool with_object, size_t bytes);
    ~WalkLattice();
    WalkLattice(const WalkLattice&) = delete;
    WalkLattice& operator=(const WalkLattice&) = delete;

    enum class Outcome : uint8_t { kRead, kOutside, kFull, kStopped };
    /// Reads the field at a point, and makes the cells on the way there.
    Outcome read(const Vec3f& p, float stop, WalkSampler* sampler, WalkField* out);
    /// What is there, which other threads may add to.
    const WalkCells& cells() const { return cells_; }
    /// Forgets all cells; call while no other thread uses it.
    void clear();
    /// Returns an empty one of the same kind.
    std::unique_ptr<WalkLattice> another(size_t bytes) const;
    size_t most_bytes() const { return most_bytes_; }

  private:
    using Kept = WalkKept;
    using Slot = Kept*;

    size_t root_count() const;
    /// Makes the cell of a slot, an eighth of `around` or of level 0; null: `outcome` says why.
    Kept* make(Slot* slot, const WalkCell& cell, const Kept* around, size_t octant,
               WalkSampler* sampler, Outcome* outcome);
    bool compute(const WalkCell& cell, const Kept* around, size_t octant, WalkSampler* sampler,
                 Kept* out) const;
    bool take(size_t bytes);
    static void release(Kept* kept);

    const bool with_object_;
    const size_t most_bytes_;
    const Box3f box_;
    const WalkGrid grid_;
    std::unique_ptr<Slot[]> roots_;
    WalkCells cells_;
    std::mutex making_;
    size_t taken_ = 0;
    bool full_ = false;
};

}  // namespace openfab::volume
