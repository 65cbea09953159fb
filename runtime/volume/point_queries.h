// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nearest-surface queries of a volume stage at points of its own choosing: `distance(p)` and
// `nearest(p)` of the part's own surface, `distance_to(object, p)` of another object of the world.
// One a thread.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/nearest/winding.h"
#include "runtime/segments/handler.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

class PointQueries {
  public:
    explicit PointQueries(size_t parts) : own_(parts) {}

    /// A batch of blocks: `corners` are 3 part-relative voxel indices and `owned` 64 bytes each
    /// (bit z of byte y * 8 + x), both to stay while it is asked. Places that are not owned get 0
    /// and are not asked.
    void begin(const PrintPart& part, const int32_t* corners, const uint8_t* owned);

    /// phases::Handler::query for the batch: group (block * 8 + y) * 8 + x.
    ///
    /// The distance of a point with a NaN, or farther than nearest::kFarthestPoint, is +infinity,
    /// all else there 0. The sign at the voxel's own centre is the coverage bit, elsewhere that of
    /// nearest::Winding. The distance to an object is the least, signed, over its placements.
    abi::KernelStatus answer(const openfab_query& query, std::span<const int32_t> groups,
                             const phases::States& states);

    nearest::QueryCounts counts() const;

  private:
    /// What is kept of each part whose surface is asked.
    struct Own {
        std::unique_ptr<nearest::Engine::Scratch> scratch;
        nearest::AttributeReader::Scratch attributes;
        nearest::Winding::Memory memory;
    };
    uint32_t wanted(const openfab_query& query, int32_t group, const phases::States& states) const;
    nearest::PointGroup centres(int32_t group) const;
    /// Answers all points in one call, which holds the patches that it dices.
    void ask(const nearest::Engine& engine, int32_t part,
             const std::vector<nearest::PointGroup>& points);
    void answer_own(const openfab_query& query, const phases::States& states);
    void write_distance(const openfab_query& query, size_t place, const phases::States& states);
    void answer_object(const openfab_query& query, const phases::States& states);
    void write_surface(const openfab_query& query, int32_t group, const phases::States& states,
                       const nearest::PointAnswer& answer);

    std::vector<Own> own_;  ///< by PrintPart::owner
    const PrintPart* part_ = nullptr;
    const int32_t* corners_ = nullptr;
    const uint8_t* owned_ = nullptr;
    // Of the groups with a place that asks.
    std::vector<int32_t> groups_;
    std::vector<nearest::PointGroup> points_, moved_;
    std::vector<nearest::PointAnswer> answers_;
    std::vector<std::array<float, phases::kLanes>> least_;
    std::vector<float*> values_;
    std::vector<uint32_t*> flat_;
};

}  // namespace openfab::slab
