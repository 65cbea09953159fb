// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stresses of a solved part, and where it is weakest.

#include <vector>

#include "mechanics/part/part_problem.h"

namespace openfab::mechanics {

/// Of the solid elements, [z][y][x]; 0 of others. Stresses are those of the solid in an element, in its
/// middle.
struct PartFields {
    std::vector<float> von_mises_MPa;
    std::vector<float> tension_MPa, compression_MPa;  ///< largest and least principal stress
    std::vector<float> safety;  ///< strength over von Mises stress; 0: not known
};
PartFields fields_of(const PartProblem& problem, Field<double, kElastic>* moved_mm);

struct WeakPlace {
    Vec3 at_mm{};  ///< in the build
    double safety = 0, von_mises_MPa = 0, tension_MPa = 0, compression_MPa = 0;
    int material = 0;
    bool at_hold = false, at_load = false;  ///< there stresses depend on how these are applied
};

struct PartSummary {
    double most_moved_mm = 0;
    Vec3 moved_there_mm{}, moved_at_mm{};
    double most_von_mises_MPa = 0;
    double least_safety = 0;       ///< 0: no strength is known
    double least_safety_away = 0;  ///< the same, more than two elements away from holds and loads
    double typical_MPa = 0;        ///< von Mises stress that one in a hundred elements exceeds
    std::vector<WeakPlace> weakest;
};
PartSummary summary_of(const PartProblem& problem, const PartFields& fields,
                       const Field<double, kElastic>& moved_mm, size_t most_places);

/// Of each element, whether it is within two of a node that is held or loaded.
std::vector<uint8_t> near_holds_and_loads(const PartProblem& problem);

/// Displacement at a node, [z][y][x] by number.
Vec3 moved_at(const Field<double, kElastic>& moved_mm, int64_t node);

}  // namespace openfab::mechanics
