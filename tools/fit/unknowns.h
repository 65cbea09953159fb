// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The unknowns of a file of goals: uniforms of objects, with their bounds or choices.

#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "tools/fit/goals.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::fit {

/// Reads the value of the key `unknowns`; `file` is of locations. Errors are in `json`. `settings` are those of the command
/// line.
std::vector<Unknown> read_unknowns(const JsonValue& value, const std::string& file,
                                   const world::World& world, const openfab_fablet_list& fablets,
                                   const std::vector<std::string>& settings,
                                   world::JsonReader* json);

}  // namespace openfab::fit
