// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stores of Zarr that prints have filled.

#include <filesystem>

#include "base/result.h"

namespace openfab::tools {

/// Checks all shards by their digests, the codes of the slices by their hash, and the manifest, if all of the print
/// is there. `memory_bytes`: what may be taken.
Result<void> verify_store(const std::filesystem::path& path, int64_t memory_bytes);

/// Returns the slices that no list of a store has, as words; empty where none is missing.
Result<std::string> missing_in_store(const std::filesystem::path& path);

}  // namespace openfab::tools
