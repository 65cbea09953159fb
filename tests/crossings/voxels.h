// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Voxels of a print, as its array has them, and the comparison of two.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace openfab::testing {

struct Voxels {
    std::array<int, 3> size{};  ///< x, y, z
    std::array<double, 3> origin_mm{}, pitch_mm{};
    std::vector<uint8_t> codes;  ///< x fastest

    uint8_t at(int x, int y, int z) const {
        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return 0;
        return codes[(static_cast<size_t>(z) * static_cast<size_t>(size[1]) +
                      static_cast<size_t>(y)) *
                         static_cast<size_t>(size[0]) +
                     static_cast<size_t>(x)];
    }
    int64_t solid() const;
};

/// Reads an .npy file of codes and the .json beside it; no voxels where it can't.
Voxels read_voxels(const std::filesystem::path& npy);

/// How two prints of one solid compare.
struct Difference {
    bool same_grid = false;         ///< up to a twentieth of a voxel
    std::array<double, 3> apart{};  ///< of the grids, in voxels
    int64_t border = 0;             ///< voxels of the second next to other material
    int64_t at_border = 0;  ///< that differ, where a neighbour of the second is as the first is
    int64_t elsewhere = 0;  ///< that differ in another way
    std::string text() const;
    bool none() const { return same_grid && at_border + elsewhere == 0; }
    /// At most this share of the border differs, and of others, which dither, a tenth of that.
    bool within(double share) const {
        const double most = share * static_cast<double>(border);
        return same_grid && static_cast<double>(at_border) <= most &&
               static_cast<double>(elsewhere) <= 0.1 * most;
    }
};
Difference compare(const Voxels& one, const Voxels& other);

}  // namespace openfab::testing
