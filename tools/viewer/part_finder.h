// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which part of a world is at a point, by its undisplaced mesh.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "world/world.h"

namespace openfab::viewer {

class PartFinder {
  public:
    explicit PartFinder(std::shared_ptr<const world::World> world);

    /// Returns the name of the part with the highest priority whose mesh winds around a point in
    /// build space, the later of equals; empty where there is none.
    std::string at(const Vec3d& point_mm) const;

  private:
    std::shared_ptr<const world::World> world_;
    std::vector<Box3d> boxes_;  ///< of the meshes
};

}  // namespace openfab::viewer
