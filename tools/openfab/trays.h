// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Puts things on trays by their boxes, in rows.

#include <array>
#include <vector>

#include "base/vec.h"

namespace openfab::tools {

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

/// Returns the six right-angled rotations, as it is first, then turned on the bed.
std::vector<std::array<double, 9>> right_angled();

/// Puts each thing, in the first of its poses that fits, on the first tray with room, `gap_mm` apart;
/// large ones first. Things that fit no tray are left out.
std::vector<Spot> put_on_trays(const std::vector<std::vector<Pose>>& things, const Vec3d& tray_mm,
                               double gap_mm);

}  // namespace openfab::tools
