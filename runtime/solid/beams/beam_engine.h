// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers queries for the nearest beam of voxels and points, and reads attributes there. In answers
// the item is a beam of the tree; distance2 is the square of the signed distance to the union, whose sign is
// that of coverage.

#include <memory>
#include <vector>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/targets.h"
#include "runtime/solid/beams/beam_block.h"

namespace openfab::solid {

/// The @nearest inputs of a fablet, over beams.
class BeamAttributes {
  public:
    /// Both must outlive it.
    BeamAttributes(const part::PartBeams& source, const openfab_fablet& fablet);

    int32_t floats() const { return static_cast<int32_t>(floats_.size()); }
    int32_t ints() const { return static_cast<int32_t>(ints_.size()); }
    /// Writes them at the answers of a block; `steps`: part-local mm of a voxel step along i, j, k.
    void read(const BeamTree& tree, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
              const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets) const;
    void read_points(const BeamTree& tree, const nearest::PointAnswer& answer,
                     const nearest::PointTargets& targets) const;
    /// Adds a beam's values to the ranges of a case.
    void add_case(const BeamRecord& beam, float distance_lo, nearest::BoxBounds* out) const;
    /// Adds those of all beams.
    void add_all(float distance_lo, nearest::BoxBounds* out) const;

  private:
    /// A component: values of nodes or beams, `stride` apart; or a default.
    struct Component {
        const void* values = nullptr;  ///< floats or ints
        size_t stride = 0;
        uint32_t otherwise = 0;  ///< bits
        bool is_bool = false;
    };
    static float value(const Component& c, int32_t node);
    static uint32_t flat(const Component& c, int32_t beam);

    std::vector<Component> floats_, ints_;
    std::vector<float> float_lo_, float_hi_;  ///< of all nodes
};

/// Makes the engine of a placement; `attributes`: null where nothing reads nearest points.
std::unique_ptr<nearest::Engine> make_beam_engine(const BeamTree& tree, const VoxelFrame& frame,
                                                  const BeamAttributes* attributes);

}  // namespace openfab::solid
