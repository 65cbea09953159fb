// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far the shapes of a world reach, which takes its fablets: the print program of the world tells.

#include <string>
#include <vector>

#include "base/result.h"
#include "world/world.h"

namespace openfab::tools {

/// How a world is read, as the print of what is made will be.
struct WorldOptions {
    std::vector<std::string> allow, settings;
    std::string memory;
};

/// Sets the extents of the placements whose meshes are only boxes around them, and where they stand;
/// their objects get boxes that hold these as meshes. Does nothing where there are none, but for reading
/// the settings.
Result<void> find_extents(const std::string& file, const WorldOptions& options,
                          world::World* world);

}  // namespace openfab::tools
