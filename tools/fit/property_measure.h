// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A measured property of mixtures, from a table of `openfab property`.

#include <filesystem>
#include <memory>
#include <string>

#include "base/result.h"
#include "program/kept_print.h"
#include "world/world.h"

namespace openfab::fit {

struct Property {
    std::string name, unit;
    std::shared_ptr<const program::SumMeasure> measure;
};

/// Reads a table whose materials have the names of the world's. It is linear between rows; a mixture beside them has the
/// value of the nearest between two.
Result<Property> read_property(const std::filesystem::path& file, const world::World& world);

}  // namespace openfab::fit
