// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the mask of the ordered dither (runtime/dither/blue_noise.h). A generator program writes it
// when the project is built.

#include <cstdint>
#include <vector>

namespace openfab::dither {

/// Returns a permutation of 0 .. side² - 1 on a square that tiles the plane, [y * side + x]: the
/// pixels of rank below n are spread evenly for every n, and so are those of any range of ranks. By
/// the void step of Ulichney's void-and-cluster method (SPIE 1913, 1993), starting from an empty
/// square: each pixel in turn goes to the largest void that the previous ones leave. Beside the
/// Gaussian of that method, pixels repel others of their own row and column, so that every line of
/// the mask has its share of every range of ranks: layers a few voxels wide must keep their mean
/// too. And since the mask moves by (step_x, step_y) from a slice to the next, pixels repel those
/// that come to stand over them: near ones like neighbours, if less, and all others a little, so
/// that columns of voxels keep their mean. Those that rods 8 voxels thick can hold both, or strips
/// of the mask 8 wide, repel each other the more the more of these do. Integer sums, so the same on
/// every machine. side² squared steps: 61 takes a tenth of a second.
std::vector<uint16_t> void_and_cluster(int32_t side, int32_t step_x, int32_t step_y);

}  // namespace openfab::dither
