// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/void_and_cluster.h"

#include <algorithm>

#include "runtime/abi/voxel_hash.h"

namespace openfab::slab {

namespace {

// exp(-1 / (2 sigma²)) for sigma = 1.5 pixels, Ulichney's choice. Powers by multiplication: libm
// may differ between machines.
constexpr double kGaussianAtOne = 0.80073740291680806;
constexpr double kOne = 0x1p32;
// Repulsion along rows, columns of the mask and columns of voxels.
constexpr double kLine = 0.125;
// Of the Gaussian, one and two slices up or down. Measured with 61, 20, 13: in layers one voxel
// thick, in a cube of 64, the printed share of 2 % is off by 6 % at most, in columns of 64 voxels
// by 0.5 voxels (root mean square; 1.1 by chance), and of an even mixture 54 % of the voxels differ
// from the one above. Without these two: 7 %, 1.3 voxels and 49 %.
constexpr double kNextSlice = 0.2, kSecondSlice = 0.05;

std::vector<int64_t> energies(int32_t side, int32_t step_x, int32_t step_y) {
    std::vector<double> gaussian(static_cast<size_t>(side * side) / 2 + 1, 1.0);
    for (size_t d2 = 1; d2 < gaussian.size(); ++d2)
        gaussian[d2] = gaussian[d2 - 1] * kGaussianAtOne;
    // Of a pixel (x, y) away from where the mask stands `slices` later.
    const auto near = [&](int32_t x, int32_t y, int32_t slices) {
        const int32_t mx = ((x - slices * step_x) % side + side) % side;
        const int32_t my = ((y - slices * step_y) % side + side) % side;
        const int32_t dx = std::min(mx, side - mx), dy = std::min(my, side - my);
        return gaussian[static_cast<size_t>(dx * dx + dy * dy)];
    };
    std::vector<double> energy;
    for (int32_t y = 0; y < side; ++y) {
        for (int32_t x = 0; x < side; ++x) {
            energy.push_back(near(x, y, 0) + kNextSlice * (near(x, y, 1) + near(x, y, -1)) +
                             kSecondSlice * (near(x, y, 2) + near(x, y, -2)) +
                             kLine * ((x == 0 ? 1 : 0) + (y == 0 ? 1 : 0)));
        }
    }
    for (int32_t slice = 0; slice < side; ++slice)
        energy[static_cast<size_t>(slice * step_y % side * side + slice * step_x % side)] += kLine;
    std::vector<int64_t> rounded;
    for (double e : energy)
        rounded.push_back(static_cast<int64_t>(kOne * e));
    return rounded;
}

}  // namespace

std::vector<uint16_t> void_and_cluster(int32_t side, int32_t step_x, int32_t step_y) {
    const std::vector<int64_t> of_one = energies(side, step_x, step_y);
    const int32_t pixels = side * side;
    std::vector<int64_t> energy(static_cast<size_t>(pixels), 0);
    std::vector<uint16_t> ranks(static_cast<size_t>(pixels), 0);
    std::vector<bool> taken(static_cast<size_t>(pixels), false);
    for (int32_t rank = 0; rank < pixels; ++rank) {
        int32_t best = -1;
        // Equal voids are the rule at first; a hash decides, lest the first in order be a lattice.
        const auto before = [&](int32_t a, int32_t b) {
            const auto ia = static_cast<size_t>(a), ib = static_cast<size_t>(b);
            if (energy[ia] != energy[ib]) return energy[ia] < energy[ib];
            return abi::mix32(static_cast<uint32_t>(a)) < abi::mix32(static_cast<uint32_t>(b));
        };
        for (int32_t p = 0; p < pixels; ++p) {
            if (!taken[static_cast<size_t>(p)] && (best < 0 || before(p, best))) best = p;
        }
        taken[static_cast<size_t>(best)] = true;
        ranks[static_cast<size_t>(best)] = static_cast<uint16_t>(rank);
        for (int32_t y = 0; y < side; ++y) {
            const int32_t row = (y + side - best / side) % side * side;
            for (int32_t x = 0; x < side; ++x) {
                energy[static_cast<size_t>(y * side + x)] +=
                    of_one[static_cast<size_t>(row + (x + side - best % side) % side)];
            }
        }
    }
    return ranks;
}

}  // namespace openfab::slab
