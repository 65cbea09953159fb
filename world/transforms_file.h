// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A file of transforms: where many copies of one thing stand.

#include <filesystem>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::scene {

/// Coordinates of placements are smaller than this.
constexpr double kFarthest_mm = 1e6;

/// Text, a transform a line: 3 numbers (a translation, mm) or 12 (a 3 x 4 matrix row by row),
/// parted by blanks or commas; empty lines and what follows a # count for nothing. Errors name the
/// line: a number that is none, another count, a matrix that flattens, more than `most` lines,
/// none.
Result<std::vector<Affine3d>> read_transforms(const std::filesystem::path& file, size_t most);
Result<std::vector<Affine3d>> parse_transforms(std::string_view text,
                                               const std::filesystem::path& file, size_t most);

/// 12 numbers, row by row.
Affine3d affine_of_rows(const std::vector<double>& n);

}  // namespace openfab::scene
