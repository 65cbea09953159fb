// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Puts things on trays by their boxes: a tray is filled from its front.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::tools {

/// How a thing may be turned: not, about z, or to lie on any of its sides.
enum class Turns : uint8_t { kNone, kUpright, kAll };

/// A right-angled pose of a thing: a rotation, and its box then.
struct Pose {
    std::array<double, 9> turn{1, 0, 0, 0, 1, 0, 0, 0, 1};
    Box3d box;
};

/// Where a thing is put.
struct Spot {
    int32_t thing = 0;
    int32_t tray = 0;
    size_t pose = 0;
    Vec3d move_mm;  ///< of the thing in that pose; the tray's corner is the origin
};

/// Returns right-angled rotations, as it is first, then turned on the bed, then on its sides.
std::vector<std::array<double, 9>> right_angled(Turns turns);

/// Puts each thing on the first tray with room, `gap_mm` apart, as far to the front as it goes; of several orders
/// the one that takes the fewest trays. On their sides lie only things that fit no other way. Those that fit no
/// tray are left out.
std::vector<Spot> put_on_trays(const std::vector<std::vector<Pose>>& things, const Vec3d& tray_mm,
                               double gap_mm);

}  // namespace openfab::tools
