// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Points of a query in an order in which those of a packet lie near each other. Voxels side by side
// may ask for points anywhere, as those of random walks are, and at other times than their
// neighbours: a packet of such points shares little of its traversal. An answer does not depend on
// the packet that its point is in.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/nearest/engine.h"

namespace openfab::volume {

class PointOrder {
  public:
    /// Returns whether it is worth to gather them: where lanes are idle or far apart, by `near_mm`.
    static bool scattered(std::span<const nearest::PointPacket> points, float near_mm);

    /// Returns the active lanes of `points` in full packets of neighbours, valid until the next
    /// call.
    std::span<const nearest::PointPacket> gather(std::span<const nearest::PointPacket> points);

    /// Writes the answers to the packets that gather returned where their points came from. Other
    /// lanes are those of no answer.
    void scatter(std::span<const nearest::PointAnswer> gathered,
                 std::span<nearest::PointAnswer> answers) const;

  private:
    std::vector<uint64_t> order_;  ///< by place along a curve: that, and the lane's number
    std::vector<nearest::PointPacket> packets_;
};

}  // namespace openfab::volume
