// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds of segmentations: each segment is a shape, with the name and colour that the file gives it.

#include <filesystem>

#include "base/result.h"
#include "tools/openfab/commands.h"

namespace openfab::tools {

bool is_scan_file(const std::filesystem::path& file);

/// Makes a world of a DICOM segmentation. Errors of the reader, which are said by it, have no text.
Result<std::filesystem::path> import_scan(const ImportArguments& arguments);

}  // namespace openfab::tools
