// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures and volumes in `openfab info`: their size and place, and what their converters tell of them.

#include <cstdint>
#include <filesystem>

#include "base/result.h"
#include "world/world.h"

namespace openfab::tools {

/// Whether it is a picture or a volume, by its name or by its first bytes.
bool is_texture_file(const std::filesystem::path& file);

/// Whether a folder holds a volume: slices, or a medium that a hospital hands out.
bool is_volume_folder(const std::filesystem::path& folder);

/// Shows one, and says the notes.
Result<void> list_texture(const std::filesystem::path& file, int64_t memory_bytes);

/// Shows the textures of a world, converted as a print of it does. One that cannot be read is a warning.
void list_textures(const world::World& world, int64_t memory_bytes);

}  // namespace openfab::tools
