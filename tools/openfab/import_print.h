// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds of prints: a box whose voxels are of the materials that the slices say.

#include <filesystem>

#include "base/result.h"
#include "tools/openfab/commands.h"

namespace openfab::tools {

/// Whether a path is a print: an .ofr file, a GCVF, or a folder of slices.
bool is_print_path(const std::filesystem::path& path);

/// Makes a world of a print, with a copy of it. Without a printer of the arguments, its printer has the
/// print's voxels, so that it prints the same again.
Result<std::filesystem::path> import_print(const ImportArguments& arguments);

}  // namespace openfab::tools
