// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// STEP files become 3MF files by a program of its own, which links OpenCASCADE.

#include <filesystem>

#include "base/result.h"

namespace openfab::tools {

bool is_step_file(const std::filesystem::path& file);

/// Makes `output`, a 3MF file with an object for each solid of a STEP file, whose triangles are at most
/// `tolerance_mm` from the surfaces. What the program says goes to standard error. Errors: it was not built.
Result<void> solids_of_step(const std::filesystem::path& file, const std::filesystem::path& output,
                            double tolerance_mm);

}  // namespace openfab::tools
