// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// Returns the memory that OpenEXR takes for tables and packed lines when it opens this file, by
/// what its headers say. Fails where an attribute is longer than the file: OpenEXR makes room for
/// it before it reads.
Result<int64_t> exr_table_bytes(const InputFile& file);

}  // namespace openfab::tools
