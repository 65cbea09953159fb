// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture of a loaded part: its surface, moved as it is, or more than it is, coloured by stress.

#include <cstdint>
#include <string>
#include <vector>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

struct PictureOptions {
    std::string show = "von-mises";  ///< one of kShown (shown.h)
    std::string title;               ///< empty: what is shown
    double turn_deg = 30, tilt_deg = 25;
};

/// A PNG. Held nodes' faces are grey.
std::vector<uint8_t> part_picture(const PartProblem& problem, const PartFields& fields,
                                  const Field<double, kElastic>& moved_mm,
                                  const PictureOptions& options);

}  // namespace openfab::mechanics
