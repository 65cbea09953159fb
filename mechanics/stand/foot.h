// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a part stands on: a flat side, or an edge, a tip or something round, told by how its lowest layers grow.

#include <array>
#include <cstdint>
#include <vector>

namespace openfab::mechanics {

/// The convex hull, against the clock, without points on its edges.
std::vector<std::array<double, 2>> convex_hull(std::vector<std::array<double, 2>> points);

/// So many layers tell how a foot grows.
constexpr int32_t kFootLayers = 16;

/// Layers of voxels from the ground on, [z][y][x]: 0 void.
struct FootLayers {
    std::array<int32_t, 3> size{};
    std::array<double, 3> pitch_mm{}, origin_mm{};
    std::vector<uint8_t> inside;
};

struct Foot {
    enum class Kind {
        kStands,      ///< on what is flat, or on several places
        kRocks,       ///< it stands on what is round, and its centre of mass is low
        kRolls,       ///< on what is round, an edge or a tip, too high for it
        kFalls,       ///< its centre of mass is not above its foot
        kNotResolved  ///< nearer to the foot's edge than voxels tell
    };
    Kind kind = Kind::kNotResolved;
    double margin_mm =
        0;  ///< from the centre of mass to the nearest edge of what is flat; below 0 outside
    double round_mm = 0;                  ///< radius of what it rocks or rolls on
    double error_mm = 0;                  ///< of `margin_mm`
    std::array<double, 2> towards{1, 0};  ///< unit vector out of the nearest edge
};

/// `height_mm` of the centre of mass above the ground.
Foot foot_of(const FootLayers& layers, const std::array<double, 2>& centre_mm, double height_mm);

}  // namespace openfab::mechanics
