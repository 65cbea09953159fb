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
// Repulsion along a row and a column. Of layers one voxel thick with 2 % of a material, in a cube
// of 64, the printed share is then off by 5 % (root mean square), against 8 % without; the mask
// stays as even in the plane.
constexpr double kLine = 0.125;

std::vector<int64_t> energies(int32_t side) {
    std::vector<double> gaussian(static_cast<size_t>(side * side) / 2 + 1, 1.0);
    for (size_t d2 = 1; d2 < gaussian.size(); ++d2)
        gaussian[d2] = gaussian[d2 - 1] * kGaussianAtOne;
    std::vector<int64_t> energy;
    for (int32_t y = 0; y < side; ++y) {
        for (int32_t x = 0; x < side; ++x) {
            const int32_t dx = std::min(x, side - x), dy = std::min(y, side - y);
            const double line = kLine * ((dx == 0 ? 1 : 0) + (dy == 0 ? 1 : 0));
            energy.push_back(static_cast<int64_t>(
                kOne * (gaussian[static_cast<size_t>(dx * dx + dy * dy)] + line)));
        }
    }
    return energy;
}

}  // namespace

std::vector<uint16_t> void_and_cluster(int32_t side) {
    const std::vector<int64_t> of_one = energies(side);
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
