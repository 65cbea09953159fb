// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The end of a print into a store: the coarse levels, which no slab has alone, and the manifest.

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "backends/zarr/shard.h"
#include "backends/zarr/store.h"

namespace openfab::zarr {

/// Completes the store if all of its slices are there; otherwise, or where another process does so just now, does
/// nothing.
Result<void> complete_store(const std::filesystem::path& path);

/// What the manifest of a whole print says.
struct Manifest {
    pipeline::PrintTotals totals;
    std::map<std::string, ShardDigest> coarse;  ///< shards of coarse levels, by their keys
};

std::string manifest_text(const pipeline::PrintInfo& info, const Manifest& manifest);
/// Reads the manifest of a store; none where it has none.
Result<std::optional<Manifest>> read_manifest(const Store& store);

}  // namespace openfab::zarr
