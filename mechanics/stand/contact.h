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
    /// Above 0: layers grow from the contact as those of a ball, a cone or an edge do, and this is about the
    /// radius of that curve. The contact is a staircase of voxels then, and vanishes with the pitch.
    double round_mm = 0;

    /// By its shape: on a round side while its centre of mass is well below the curve's centre.
    bool stands() const {
        constexpr double kBelow = 0.8;
        return margin_deg > 0 && !(round_mm > 0 && centre_mm[2] - floor_mm > kBelow * round_mm);
    }
};

/// Densities of `voxels` count, 1 g/cm3 where `known` is false. The contact are the lowest solid elements.
Stand stand_of(const Grid& grid, const Voxels& voxels, const PartElements& elements, bool known);

/// The convex hull, against the clock, without points on its edges.
std::vector<std::array<double, 2>> convex_hull(std::vector<std::array<double, 2>> points);

}  // namespace openfab::mechanics
