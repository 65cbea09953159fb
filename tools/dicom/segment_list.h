// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of a segmentation, for `openfab import`.

#include <filesystem>

#include "base/result.h"
#include "texture/cache.h"

namespace openfab::tools {

/// Writes as JSON the size of a segmentation's grid and its segments: number, label, and their colour where
/// the file has one. Fails where it is none.
Result<void> write_segment_list(const std::filesystem::path& file, const std::filesystem::path& out,
                                const texture::ReadLimits& limits);

}  // namespace openfab::tools
