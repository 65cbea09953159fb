// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

struct ExrHeader {
    /// The memory that OpenEXR takes for tables and packed lines when it opens this file.
    int64_t table_bytes = 0;
    /// The number of its compression, the highest of its parts.
    int compression = 0;
};

/// Reads what the headers of a file say. Fails where an attribute is longer than the file: OpenEXR makes
/// room for it before it reads.
Result<ExrHeader> read_exr_header(const InputFile& file);

/// Returns the name of a compression that is newer than OpenEXR 3.3; nothing for others.
std::string_view newer_exr_compression(int number);

}  // namespace openfab::tools
