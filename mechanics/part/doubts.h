// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of materials that no solid has, mostly another unit, and how sure measured ones are.

#include <span>
#include <string>
#include <vector>

#include "mechanics/model/materials.h"

namespace openfab::mechanics {

/// One text for each number that is beyond what is known of solids.
std::vector<std::string> unit_doubts(std::span<const Material> materials);

/// One text for each material whose modulus is known without its temperature and rate, where that matters;
/// none by a table of mixtures, which has moduli of its own.
std::vector<std::string> condition_doubts(std::span<const Material> materials,
                                          const Properties& properties);
/// A text where the table that is used says how its specimens scatter.
std::vector<std::string> table_doubts(const Properties& properties);

}  // namespace openfab::mechanics
