// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of a cell.

#include <optional>
#include <string>

#include "base/json_text.h"
#include "mechanics/cell/engineering.h"
#include "mechanics/model/voxels.h"

namespace openfab::mechanics {

/// What one cell came to.
struct CellResult {
    Homogenised<6> stiffness;
    std::optional<Homogenised<3>> heat, current;
    std::optional<Engineering> engineering;
    std::optional<Stiffness> compliance;
    Voxels voxels;  ///< without its large arrays
};

std::string describe(const CellResult& result, const std::string& law);
void write_result(const CellResult& result, JsonText* out);
/// What the pitch costs: of the numbers at half of it and at it.
std::string describe_convergence(const CellResult& fine, const CellResult& coarse);

}  // namespace openfab::mechanics
