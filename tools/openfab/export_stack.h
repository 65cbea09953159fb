// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The fractions of a print as stacks of grey images of 16 bits, one for each material and one of what is
// not void, for 3MF files.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct FractionStack {
    std::array<int32_t, 3> size{};  ///< along x, y and z
    Vec3d origin_mm, pitch_mm;
    std::vector<std::string> materials;  ///< names
    std::vector<bool> used;              ///< of each material
    std::filesystem::path file;          ///< the array
    int64_t data_at = 0;                 ///< where its values begin
};

/// What is printed, and how, as for `openfab print`.
struct FractionPrint {
    std::string world, voxel;
    bool programs = false;  ///< those that the world names may run
    std::vector<std::string> settings;
};

/// Prints a world into the folder.
Result<FractionStack> print_fractions(const FractionPrint& print,
                                      const std::filesystem::path& folder);

/// Takes a picture of a slice: its number, the material, or -1 of all of them, and a PNG file.
using TakeSheet =
    std::function<Result<void>(int32_t slice, int32_t material, const std::vector<uint8_t>& png)>;

/// Makes the pictures, the lowest slice first; of used materials, and of all.
Result<void> make_sheets(const FractionStack& stack, const TakeSheet& take);

}  // namespace openfab::tools
