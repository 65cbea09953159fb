// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers queries for the nearest beam or body of what grows, by the engine of beams over those of a place, and by
// asking its bodies. In answers `item` counts among the beams that the scratch holds, then the bodies; the rest is as
// of beams.

#include <memory>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/targets.h"
#include "runtime/solid/grow/local_beams.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

/// Makes the engine of a placement. `fablet`: as LocalBeams::set.
std::unique_ptr<nearest::Engine> make_grow_engine(
    const Grown& grown, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
    const openfab_fablet* fablet);

/// The scratch of such engines.
class GrowScratch final : public nearest::Engine::Scratch {
  public:
    /// The beams around a row of blocks.
    struct Region {
        const void* engine_of = nullptr;  ///< placements share scratches
        Vec3i key;
        uint64_t used = 0;
        LocalBeams beams;
        LocalBodies bodies;
        std::unique_ptr<nearest::Engine> engine;
        std::unique_ptr<nearest::Engine::Scratch> scratch;
    };
    static constexpr size_t kRegions = 8;
    static constexpr size_t kMostKept = size_t{1} << 16;  ///< beams of all, but for the last
    std::array<Region, kRegions> regions;
    Region around;            ///< of a block, with those that do not touch it
    Region* asked = nullptr;  ///< that the last block was answered by
    uint64_t uses = 0;
    GatheredBeams gathered;
    LocalBeams of_points;  ///< nearest to the points asked for last
    LocalBodies bodies_of_points;
    std::vector<float> depths;  ///< signed distances of a block's voxels
    std::vector<Vec3d> points;
    std::vector<Standing::Found> found;
};

}  // namespace openfab::solid
