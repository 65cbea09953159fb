// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesh/model/mesh.h"
#include "world/json_reader.h"

namespace openfab::world {

/// Returns the keys of a mesh that make a primitive.
const std::vector<std::string>& primitive_keys();

/// Makes the primitive that a mesh's key of primitive_keys asks for; `name` names it in messages. None
/// after an error, which `json` has.
std::optional<mesh::Mesh> read_primitive(const JsonMember& source, const std::string& name,
                                         JsonReader* json);

}  // namespace openfab::world
