// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part while it is printed, layer by layer.

#include <vector>

#include "mechanics/part/surface.h"

namespace openfab::mechanics {

/// What begins in a layer with nothing solid below it: support carries it, or nothing does.
struct AirPlace {
    Vec3 at_mm{};          ///< middle of what begins, at its lower side
    double area_mm2 = 0;   ///< in its first layer
    int64_t elements = 0;  ///< there
};

/// The largest first. The lowest layer stands on the ground.
std::vector<AirPlace> begins_in_the_air(const Grid& grid, const Vec3& origin_mm,
                                        std::span<const uint8_t> kind);

/// The lowest `layers` of it.
Voxels lowest_layers(const Voxels& voxels, int32_t layers);

}  // namespace openfab::mechanics
