// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds with a texture replaced by a field that was computed.

#include <array>
#include <filesystem>
#include <string>

#include "base/result.h"
#include "world/edit/world_edit.h"

namespace openfab::mechanics {

/// A world whose texture `name` is a volume for a part that stands in the build without being turned or
/// scaled.
class FieldWorld {
  public:
    /// `folder` is where the world with the field will be; paths count from it then.
    static Result<FieldWorld> open(const std::filesystem::path& world, const std::string& texture,
                                   const std::filesystem::path& folder);
    /// The part's origin in the build.
    const std::array<double, 3>& moved_mm() const { return moved_mm_; }
    /// Whether the world with the field names files outside of its folder, which it may read if they are allowed.
    bool names_others() const;
    /// The world's text with the field, a file in that folder, as texture, its lowest corner in the build.
    Result<std::string> text(const std::filesystem::path& field,
                             const std::array<double, 3>& origin_mm,
                             const std::array<double, 3>& pitch_mm) const;

  private:
    FieldWorld(world::WorldEdit world, std::string texture, const std::array<double, 3>& moved_mm)
        : world_(std::move(world)), texture_(std::move(texture)), moved_mm_(moved_mm) {}

    world::WorldEdit world_;
    std::string texture_;
    std::array<double, 3> moved_mm_;
};

}  // namespace openfab::mechanics
