// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture of Young's modulus by direction.

#include <cstdint>
#include <vector>

#include "mechanics/cell/engineering.h"

namespace openfab::mechanics {

/// A PNG of three polar curves, of the planes xy, yz and xz, with circles of the modulus in MPa.
std::vector<uint8_t> polar_picture(const Stiffness& compliance, double young_most);

}  // namespace openfab::mechanics
