// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Has worlds printed as arrays of mixtures or codes, by `openfab print` beside this program.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::mechanics {

struct PrintRequest {
    std::filesystem::path world;
    std::filesystem::path programs;
    double voxel_mm = 0;
    int supersample = 1;
    bool codes = false;
    std::string dither;  ///< of codes
    std::vector<std::string> settings, allow;
    int threads = 1;
    int64_t memory_bytes = 0;
};

/// Writes `folder`/NAME.npy and returns its path.
Result<std::filesystem::path> print_voxels(const PrintRequest& request,
                                           const std::filesystem::path& folder,
                                           const std::string& name);

/// The size of what is built, in mm.
Result<std::array<double, 3>> build_size(const PrintRequest& request,
                                         const std::filesystem::path& folder);

/// The text of a world with one object only, where the build places it, or at the origin where the build
/// does not have it: all of it of the world's first material, whatever its fablet does.
Result<std::string> object_world(const std::filesystem::path& input, const std::string& object,
                                 const std::filesystem::path& scratch);

/// The text of a world with a box of a fablet's, which stands at the world's files wherever it is
/// written. `input`: a fablet (.fl), whose materials are named as its uniforms are, or a world, of which
/// `object` or the first object is taken.
struct CellWorld {
    std::string text;
    std::string object;
    std::vector<std::filesystem::path> folders;  ///< that it may read
};
Result<CellWorld> cell_world(const std::filesystem::path& input, const std::string& object,
                             const std::array<double, 3>& cell_mm,
                             const std::filesystem::path& programs,
                             const std::filesystem::path& scratch);

}  // namespace openfab::mechanics
