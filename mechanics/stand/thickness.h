// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How thick walls are: twice the distance of their middles from the surface.

#include <vector>

#include "mechanics/part/surface.h"

namespace openfab::mechanics {

struct ThinPlace {
    Vec3 at_mm{};
    double thickness_mm = 0;
    int material = 0;
};

/// Squared distances, in mm, of the middles of solid elements from the surface; 0 elsewhere. Exact of the
/// elements, by parabolas along each axis (Felzenszwalb and Huttenlocher).
std::vector<float> squared_depth(const Grid& grid, std::span<const uint8_t> kind);

/// The thinnest walls, struts and necks, the thinnest first, at places that lie apart: middles are elements
/// that none of their neighbours lies deeper than. To about half an element.
std::vector<ThinPlace> thinnest(const Grid& grid, const Voxels& voxels,
                                std::span<const uint8_t> kind, size_t most);

}  // namespace openfab::mechanics
