// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of a loaded part.

#include <string>

#include "base/json_text.h"
#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

/// A case that is solved.
struct PartRun {
    PartProblem problem;
    PartSolution solution;
    PartFields fields;
    PartSummary summary;
};

std::string describe(const PartRun& run, const LoadCase& load_case, const std::string& law);
void write_result(const PartRun& run, const LoadCase& load_case, JsonText* out);
/// Whether a number tends to a limit as the pitch is halved: its changes keep their sign and shrink, faster than
/// by the pitch. Without a third pitch a large change tells that it does not.
bool settling(double fine, double coarse, std::optional<double> coarser);
/// What the pitch costs: of the numbers at half of it and at it, and at twice of it, if that is known. What they
/// tend to is left out where they do not settle.
std::string describe_convergence(const PartRun& fine, const PartRun& coarse,
                                 const PartRun* coarser);

}  // namespace openfab::mechanics
