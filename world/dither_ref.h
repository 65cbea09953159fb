// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The dither rule of a world.

#include "base/json.h"
#include "world/json_reader.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

/// Reads the value of a world's `dither`.
DitherRef read_dither(const JsonValue& value, JsonReader* json, WorldFiles* files);

}  // namespace openfab::world
