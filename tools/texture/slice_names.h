// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the names of files of slices say: which number is that of the slice, and which that of a channel or a time.

#include <filesystem>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

/// Fails where the names say that the files are not all slices of one volume, as `z00_c0`, `z00_c1`,
/// `z01_c0`, ... do: a slice has one number, and no other channel, time or series has a slice of that number.
/// `have_pages`: each file is a volume of its own. Tells what the names say of gaps, and that a channel's or
/// time's number is taken as a slice's, where there is no other.
Result<void> check_slice_names(const std::vector<std::filesystem::path>& files, bool have_pages);

}  // namespace openfab::tools
