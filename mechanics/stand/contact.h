// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether something stands: its centre of mass over the hull of what it stands on.

#include <array>
#include <vector>

#include "mechanics/part/surface.h"

namespace openfab::mechanics {

struct Stand {
    double mass_g = 0, volume_mm3 = 0;
    Vec3 centre_mm{};                            ///< of mass
    std::vector<std::array<double, 2>> hull_mm;  ///< of the contact, against the clock
    double contact_mm2 = 0;
    double floor_mm = 0;  ///< height of the contact
    /// By how much it may be tilted, over the weakest edge of the hull; below 0 it falls by itself.
    double margin_deg = 0;
    std::array<double, 2> falls_towards{};  ///< unit vector out of that edge
};

/// Densities of `voxels` count, 1 g/cm3 where `known` is false. The contact are the lowest solid elements.
Stand stand_of(const Grid& grid, const Voxels& voxels, const PartElements& elements, bool known);

/// The convex hull, against the clock, without points on its edges.
std::vector<std::array<double, 2>> convex_hull(std::vector<std::array<double, 2>> points);

}  // namespace openfab::mechanics
