// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads a texture of a world.

#include "base/json.h"
#include "world/json_reader.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

/// Adds the texture to the world's.
void read_texture(const JsonMember& m, JsonReader* json, WorldFiles* files, World* world);

}  // namespace openfab::world
