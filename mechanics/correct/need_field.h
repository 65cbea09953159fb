// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A field, 0 to a limit, that says where a fablet should make a part stronger.

#include <filesystem>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

struct NeedField {
    Grid grid;
    Vec3 origin_mm{};
    std::vector<float> value;  ///< [z][y][x]
};

struct NeedRule {
    double safety = 1.5;  ///< that is wanted
    double limit = 1;     ///< of the field
    double reach_mm = 0;  ///< what is around a weak place grows with it
    double step = 0.25;   ///< of the limit, that a place grows by at most
};

/// What a solution makes of the field.
struct NeedStep {
    int64_t weak = 0;      ///< elements below the wanted safety, away from holds and loads
    int64_t at_limit = 0;  ///< of them where the field cannot grow
    double most_grown = 0;
};

/// Grows the field around elements that are weaker than wanted, the more the weaker they are. Nothing
/// shrinks, so that it ends.
NeedStep grow(const PartProblem& problem, const PartFields& fields, const NeedRule& rule,
              NeedField* field);

/// An array for numpy and for a texture.
Result<void> write_field(const std::filesystem::path& file, const NeedField& field);

}  // namespace openfab::mechanics
