// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The keys of a file of goals, by kind of object: what the reader accepts, and what fab_fit.schema.json must list (a test
// compares the two).

#include "world/world_keys.h"

namespace openfab::fit {

inline const world::KeySet kFileKeys{
    "fit", {"$schema", "openfab_fit", "unknowns", "goals"}, {"openfab_fit", "unknowns", "goals"}};
inline const world::KeySet kUnknownKeys{"unknown", {"min", "max", "start", "choices"}, {}};
inline const world::KeySet kGoalKeys{
    "goal",
    {"name",           "share",      "volume_ml",     "weight_g",      "cost",
     "property",       "moved_mm",   "deflection_mm", "work_Nmm",      "resistance_ohm",
     "resistance_K_W", "young_MPa",  "poisson",       "stiffness_MPa", "box_mm",
     "object",         "element_mm", "cell_mm",       "equal",         "at_most",
     "at_least",       "aim",        "within"},
    {}};

}  // namespace openfab::fit
