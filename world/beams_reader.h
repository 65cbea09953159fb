// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads a mesh of a world that is beams.

#include <filesystem>
#include <string>

#include "mesh/load/load_beams.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::world {

/// Adds the beams of a file to a world as a new mesh, which is their box. Returns the bytes that they
/// hold, 0 after an error, which `json` has.
int64_t add_beams(const std::filesystem::path& file, const mesh::BeamOptions& options,
                  const std::string& name, JsonReader* json, World* world);

}  // namespace openfab::world
