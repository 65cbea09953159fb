// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OpenFL sources of a world.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "world/world.h"

namespace openfab::world {

/// Returns each source of the world's fablets once. Fails where one is missing, or all are; `input`
/// names the world then.
Result<std::vector<std::filesystem::path>> fablet_sources(const World& world,
                                                          const std::string& input);

}  // namespace openfab::world
