// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nearest-surface queries of a volume stage at arbitrary points: `distance(p)` and `nearest(p)` of
// the part's own surface, `distance_to(object, p)` of another object of the world; and walks that end at them. One per
// thread.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/segments/handler.h"
#include "runtime/volume/placed_part.h"
#include "runtime/volume/point_order.h"

namespace openfab::volume {

class PointQueries : private WalkSampler {
  public:
    /// What cells take at most that a thread makes for itself.
    static constexpr size_t kSpareBytes = 1u << 20;

    explicit PointQueries(size_t parts) : scratch_(parts) {}

    /// Begins a batch of blocks: `corners` are 3 part-relative voxel indices and `owned` 64 bytes
    /// each (bit z of byte y * 8 + x); both must outlive the batch. Voxels that are not owned get 0
    /// without a query. `isa`: the best set of walks. Once `stop` is set, `answer` ends early, stopped; null: never.
    void begin(const PlacedPart& part, const int32_t* corners, const uint8_t* owned,
               openfab_isa isa, const std::atomic<bool>* stop = nullptr);

    /// segments::Handler::query for the batch: group (block * 8 + y) * 8 + x.
    ///
    /// The distance of a point with a NaN, or farther than nearest::kMaxCoordinate, is +infinity,
    /// and all other results are 0. The sign at the voxel's own centre is the coverage bit,
    /// elsewhere that of solid::Placed::inside. The distance to an object is the least, signed, over its
    /// placements. A walk that begins or goes where nothing is known ends there.
    abi::KernelStatus answer(const openfab_query& query, std::span<const int32_t> groups,
                             const segments::States& states);

    nearest::QueryCounts counts() const;

  private:
    uint32_t wanted(const openfab_query& query, int32_t group,
                    const segments::States& states) const;
    nearest::PointPacket centres(int32_t group) const;
    /// Queries all points in one call, which pins the patches that it dices. `scattered`: they may be anywhere.
    abi::KernelStatus ask(const solid::Placed& placed, int32_t part,
                          const std::vector<nearest::PointPacket>& points, bool scattered);
    abi::KernelStatus answer_own(const openfab_query& query, const segments::States& states);
    void write_distance(const openfab_query& query, size_t entry, const segments::States& states);
    abi::KernelStatus answer_object(const openfab_query& query, const segments::States& states);
    /// Finds the least signed distance of points_ over the placements of an object: into least_.
    abi::KernelStatus find_least(int32_t object, bool scattered);
    abi::KernelStatus answer_walk(const openfab_query& query, const segments::States& states);
    bool read(WalkLattice* lattice, WalkLanes* lanes, size_t lane);
    bool sample(std::span<const Vec3f> points, float* own, float* object) override;
    void write_surface(const openfab_query& query, int32_t group, const segments::States& states,
                       const nearest::PointAnswer& answer);

    std::vector<std::unique_ptr<solid::Scratch>> scratch_;  ///< by PlacedPart::owner
    const PlacedPart* part_ = nullptr;
    const int32_t* corners_ = nullptr;
    const uint8_t* owned_ = nullptr;
    const std::atomic<bool>* stop_ = nullptr;
    // One entry for each lane group with an active lane.
    std::vector<int32_t> groups_;
    std::vector<nearest::PointPacket> points_, moved_, walked_;
    std::vector<nearest::PointAnswer> answers_, gathered_;
    PointOrder order_;
    std::vector<std::array<float, segments::kLanes>> least_;
    std::vector<float*> values_;
    std::vector<uint32_t*> flat_;
    WalkKernels walk_{};
    int32_t walks_to_ = -1;               ///< the object of the walks
    std::unique_ptr<WalkLattice> spare_;  ///< of cells that another lattice has no room for
    const WalkLattice* spare_of_ = nullptr;
};

}  // namespace openfab::volume
