// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The blue-noise masks in generated code: what a dither rule reads of them (abi/blue_noise.h).

#include <Halide.h>

#include <array>
#include <cstdint>

namespace openfab::lower {

/// States the shape of a mask, (8, pixel).
void shape_blue_noise(Halide::ImageParam* mask);

/// Returns the threshold, 0 to 65534, of the mask of a face at voxel `lane` of a column: `lowest` is
/// the print's index of its first, which does not depend on the lane, so that the ranks of a column
/// are one load.
Halide::Expr blue_noise_threshold(const Halide::ImageParam& mask, int32_t face,
                                  const Halide::Expr& seed,
                                  const std::array<Halide::Expr, 3>& lowest,
                                  const Halide::Var& lane);

}  // namespace openfab::lower
