// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a solved part comes to, and where it is weakest.

#include <optional>
#include <vector>

#include "mechanics/part/buckling.h"

namespace openfab::mechanics {

struct WeakPlace {
    Vec3 at_mm{};  ///< in the build
    double safety = 0, von_mises_MPa = 0, tension_MPa = 0, compression_MPa = 0;
    int material = 0;
    double across = 0;                      ///< elements across the wall or strut there, up to 4
    bool at_hold = false, at_load = false;  ///< there stresses depend on how these are applied
};

/// By how much the stress may be more than computed where from two to four elements lie across, in steps of kAcrossStep.
double coarse_excess(uint8_t across);

struct PartSummary {
    double most_moved_mm = 0;
    Vec3 moved_there_mm{}, moved_at_mm{};
    double most_von_mises_MPa = 0;
    double least_safety = 0;       ///< 0: no strength is known
    double least_safety_away = 0;  ///< the same, more than two elements away from holds and loads
    double least_safety_resolved = 0;  ///< the same where two elements lie across, or more
    /// Where less do, by what that may be off, 2.5 or four times; 0: they do everywhere.
    double least_safety_unresolved = 0;
    double least_safety_coarse = 0;  ///< the same where less than four do, but two (coarse_excess)
    double least_safety_cut =
        0;                   ///< the least, by what a surface that goes through elements may be off
    double typical_MPa = 0;  ///< von Mises stress that one in a hundred elements exceeds
    std::vector<WeakPlace> weakest;
    std::optional<Buckling> buckling;  ///< where it was looked at
};
/// Where less than two elements lie across a wall, its stress may be off by several times: nothing holds whose
/// factor there is the least of all, or may be below 1. Where less than four do, or the surface goes
/// through elements, nothing whose factor may be.
enum class Verdict {
    kUnknown,
    kNotStrained,
    kUnresolved,
    kCoarse,
    kCut,
    kBreaks,
    kBuckles,
    kHolds
};
Verdict verdict_of(const PartSummary& summary);
PartSummary summary_of(const PartProblem& problem, const PartFields& fields,
                       const Field<double, kElastic>& moved_mm, size_t most_places);

/// Of each element, whether it is within two of a node that is held or loaded.
std::vector<uint8_t> near_holds_and_loads(const PartProblem& problem);

/// Displacement at a node, [z][y][x] by number.
Vec3 moved_at(const Field<double, kElastic>& moved_mm, int64_t node);

}  // namespace openfab::mechanics
