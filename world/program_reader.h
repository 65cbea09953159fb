// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads what a world says of a program that makes geometry. Nothing runs.

#include <memory>
#include <string>

#include "base/json.h"
#include "world/json_reader.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

/// Reads the program of a mesh, whose value this is; `command` is that of its `program`.
std::shared_ptr<const ProgramRef> read_program(const JsonValue& mesh, const JsonValue& command,
                                               const std::string& what, JsonReader* json,
                                               WorldFiles* files);

}  // namespace openfab::world
