// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files that a header names for its numbers: one, or one a slice, which NRRD and MetaImage give as a
// pattern with its first and last number and a step (`s%03d.raw 0 3 1`) or as a list in the lines behind
// (`LIST`).

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::texture {

/// Reads the names, in the order of their numbers, relative to the header's folder; `listed` are the lines
/// behind. Fails for a pattern that is malformed, or names too many.
Result<std::vector<std::string>> read_data_files(const std::string& text,
                                                 const std::vector<std::string>& listed);

/// Returns whether the files are listed in the lines behind: `LIST`, or with their dimensions, `LIST 2`.
bool is_file_list(std::string_view text);

/// Splits into lines without their blanks, and leaves out empty ones.
std::vector<std::string> lines_of(std::string_view text);

}  // namespace openfab::texture
