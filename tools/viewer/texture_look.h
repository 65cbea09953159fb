// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a texture of a world looks like: a picture of at most 64 pixels a side, as it is sampled.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"
#include "world/world.h"

namespace openfab::viewer {

/// Returns a PNG: colours in sRGB, of data the range from its least to its greatest value; of a volume the slice in its
/// middle. The pyramid comes from the cache, where a print has left it. `roots`: folders that its file must lie below.
Result<std::vector<uint8_t>> texture_look(const world::Texture& texture, bool is_volume,
                                          const std::vector<std::filesystem::path>& roots);

}  // namespace openfab::viewer
