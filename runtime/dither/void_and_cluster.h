// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the mask of the ordered dither (runtime/dither/blue_noise.h). A generator program writes it
// at build time.

#include <cstdint>
#include <vector>

namespace openfab::dither {

/// Returns a permutation of 0 .. side² - 1 on a square that tiles the plane, [y * side + x]: the
/// pixels of rank below n are evenly distributed for every n, and so are those of any range of
/// ranks. Uses the void step of Ulichney's void-and-cluster method (SPIE 1913, 1993), starting from
/// an empty square: each pixel in turn goes to the largest void that the previous ones leave. In
/// addition to that method's Gaussian, pixels repel others in their own row and column, so that
/// every line of the mask holds every range of ranks in proportion: layers a few voxels wide must
/// keep their mean, too. Since the mask moves by (step_x, step_y) from slice to slice, pixels also
/// repel those that come to lie over them: near ones like neighbours, but less, and all others a
/// little, so that columns of voxels keep their mean. Pixels that fit together into rods 8 voxels
/// thick, or into strips of the mask 8 wide, repel each other in proportion to the number of these.
/// Integer sums, so the same on every machine. Takes (side²)² steps: a tenth of a second for 61.
std::vector<uint16_t> void_and_cluster(int32_t side, int32_t step_x, int32_t step_y);

}  // namespace openfab::dither
