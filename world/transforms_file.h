// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads files of transforms, which place many copies of one object.

#include <filesystem>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::world {

/// Upper bound of the coordinates of placements.
constexpr double kFarthest_mm = 1e6;

/// Reads text with one transform per line: 3 numbers (a translation, mm) or 12 (a 3 x 4 matrix row
/// by row), separated by blanks or commas; empty lines and what follows a # are ignored. Errors
/// name the line: a malformed number, another count, a singular matrix, more than `most` lines,
/// none.
Result<std::vector<Affine3d>> read_transforms(const std::filesystem::path& file, size_t most);
Result<std::vector<Affine3d>> parse_transforms(std::string_view bytes,
                                               const std::filesystem::path& file, size_t most);

/// Builds a transform from 12 numbers, row by row.
Affine3d affine_of_rows(const std::vector<double>& n);

}  // namespace openfab::world
