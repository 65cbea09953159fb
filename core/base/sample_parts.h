// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace openfab {

/// A voxel's means are of at most so many samples along each axis: 32768 samples are enough.
constexpr int32_t kMostSupersampling = 32;

/// Returns how many of the printer's voxels lie along a side, a part of one counted: at least 1, and 1 where theirs is not
/// known, or 0.
inline double own_voxels_along(double side_mm, double own_mm) {
    constexpr double kSlack = 1e-6;  // of a quotient that is a whole number
    return own_mm > 0 ? std::max(1.0, std::ceil(side_mm / own_mm - kSlack)) : 1.0;
}

/// Returns of how many samples along a side a mean is, where nothing else is asked for.
inline int32_t samples_along(double side_mm, double own_mm) {
    return static_cast<int32_t>(
        std::min(own_voxels_along(side_mm, own_mm), double{kMostSupersampling}));
}

}  // namespace openfab
