// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stretches, the symmetric factors of placements (base/polar.h), of geometry that is stretched as a whole.

#include <array>
#include <memory>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/part/part.h"

namespace openfab::part {

/// Returns the least and the greatest factor of a stretch.
Vec2<double> stretch_range(const std::array<double, 9>& stretch);

std::array<double, 9> inverse_stretch(const std::array<double, 9>& stretch);

/// Checks that factors are alike enough for distances: they are too small by as much as these differ.
Result<void> check_uneven_stretch(const std::array<double, 9>& stretch, const char* help);

/// Makes what a part is stretched from: `of`, with a shape or beams that are not stretched, in a mesh that
/// has the place of its centre alone.
Stretched make_stretched(const Part& of, const std::array<double, 9>& by,
                         const openfab_fablet& fablet);

}  // namespace openfab::part
