// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the `pieces` of an object, in the world or in a file of its own.

#include <memory>
#include <string>

#include "base/json.h"
#include "world/json_reader.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

/// `what`: "object `bunny`". Null after an error.
std::shared_ptr<const ObjectPieces> read_pieces(const JsonValue& value, const std::string& what,
                                                const World& world, JsonReader* json,
                                                WorldFiles* files);

/// Fails with the place of a cut that leaves a piece without anything of the mesh, if one does. An
/// object whose geometry is no mesh, or whose mesh was not read, is not looked at.
void check_pieces_hold_something(const mesh::Mesh& mesh, const ObjectPieces& pieces,
                                 const std::string& what, JsonReader* json);

}  // namespace openfab::world
