// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "inspection/bits.h"

namespace openfab::inspection {

/// Returns how much of the neighbourhood of each voxel is set, 0 to 255: weights 1 4 6 4 1 along each
/// axis, about a Gaussian of one voxel. What is beyond the box counts as `outside`, 0 or 1.
Box<uint8_t> smooth(const Bits& bits, int outside);

}  // namespace openfab::inspection
