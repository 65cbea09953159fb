// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Elements of a print: its mixtures or its codes, as `openfab print` writes them for numpy.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "mechanics/model/mixture.h"
#include "mechanics/solver/element_operator.h"

namespace openfab::mechanics {

struct VoxelFile {
    std::filesystem::path file;
    std::array<int32_t, 3> size{};
    std::array<double, 3> pitch_mm{}, origin_mm{};
    std::vector<std::string> materials;
    bool codes = false;  ///< a byte a voxel, 0 void, else a fraction of each material
};

/// Opens FILE.npy by the FILE.npy.json beside it.
Result<VoxelFile> open_voxels(const std::filesystem::path& file);

struct Voxels {
    std::array<int32_t, 3> size{};
    std::array<double, 3> pitch_mm{}, origin_mm{};
    std::vector<std::string> materials;
    std::vector<float> lambda, mu;         ///< MPa, [z][y][x]
    std::vector<float> strength, density;  ///< MPa, 0 unknown; g/cm3
    std::vector<float> conductivity;
    std::vector<float> solid;   ///< share of all materials
    std::vector<float> shares;  ///< [voxel][material], where they were asked for
    std::vector<uint8_t> code;  ///< largest material from 1, 0: nothing
    std::vector<double> share;  ///< of all voxels, of each material

    size_t count() const { return code.size(); }
    static int64_t bytes_per_voxel() { return 4 * 6 + 1; }

    /// Makes what each voxel has, but for `shares`, of another's: make(from, to) for each vector.
    template <class Make>
    void make_of(const Voxels& other, const Make& make) {
        make(other.lambda, &lambda);
        make(other.mu, &mu);
        make(other.strength, &strength);
        make(other.density, &density);
        make(other.conductivity, &conductivity);
        make(other.solid, &solid);
        make(other.code, &code);
    }
};

/// Of each material, whether any voxel has some of it.
Result<std::vector<uint8_t>> used_materials(const VoxelFile& file);

/// The codes of a file of such, [z][y][x].
Result<std::vector<uint8_t>> read_codes(const VoxelFile& file);

Result<Voxels> read_voxels(const VoxelFile& file, const Mixture& mixture, bool keep_shares = false);

/// The same in elements of half the pitch, without `shares`: eight of each.
Voxels halved(const Voxels& voxels);

}  // namespace openfab::mechanics
