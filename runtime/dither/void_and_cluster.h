// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the masks of the ordered dither (runtime/dither/blue_noise.h). A generator program writes
// them at build time.

#include <cstdint>
#include <vector>

namespace openfab::dither {

enum class MaskUse {
    kSides,   ///< upright in sides
    kInside,  ///< in slices, moved from each to the next
};

/// Returns a permutation of 0 .. row²: pixel x - row y + slice_step z modulo row² + 1 is at (x, y)
/// in slice z. The pixels of rank below n are evenly distributed for every n, and so are those of
/// any range of ranks. Uses the void step of Ulichney's void-and-cluster method (SPIE 1913, 1993),
/// starting from an empty mask: each pixel in turn goes to the largest void that the previous ones
/// leave.
///
/// To that method's Gaussian three things are added. A fraction takes any range of ranks, not only
/// the lowest, so pixels are also repelled by the last 0.5, 1, 2, 5, 10 and 25 % of ranks, each as
/// far as these have room. Pixels in one line of voxels repel each other, so that every line holds
/// every range of ranks in proportion: layers a few voxels wide must keep their mean, too. And so do
/// pixels in what a rod of 8 x 8 x 64 voxels takes of the mask, in proportion to the number of such
/// rods: on sides strips; inside what is left of a rod within its sides. There pixels also repel
/// those that come to lie over them, near ones like neighbours, but less.
///
/// Integer sums, so the same on every machine. Takes 13 row⁴ steps: a third of a second for 64.
std::vector<uint16_t> void_and_cluster(int32_t row, MaskUse use, int32_t slice_step);

}  // namespace openfab::dither
