// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solid shapes of one mixture, and the printed fractions on their visible surfaces.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/support/reference/dither.h"

namespace openfab::testing {

/// Returns the fractions of void, 0, of material 1, which takes the rest, and of the others.
std::vector<uint16_t> quantised(const std::vector<double>& others);

using Inside = std::function<bool(const Vec3i&)>;

/// Makes a field of `mixture` where `inside` holds, void elsewhere.
reference::FractionField shaped(const Vec3i& size, const std::vector<uint16_t>& mixture,
                                const Inside& inside);
reference::FractionField box(const Vec3i& size, const std::vector<uint16_t>& mixture);
/// Makes a ball in a cube with a margin of at least a voxel.
reference::FractionField ball(double radius, const std::vector<uint16_t>& mixture);

/// Returns the fraction of this code among voxels that are not void and for which `where` holds.
double share_of(const reference::FractionField& field, const std::vector<uint8_t>& codes,
                uint8_t code, const Inside& where);

/// Returns the fractions in the outermost layers of a box: -x, +x, -y, +y, -z, +z; or `depth` below
/// them.
std::array<double, 6> face_shares(const reference::FractionField& field,
                                  const std::vector<uint8_t>& codes, uint8_t code,
                                  int32_t depth = 0);
/// Returns the fractions among voxels with a void neighbour, by octant of the cube.
std::array<double, 8> skin_shares(const reference::FractionField& field,
                                  const std::vector<uint8_t>& codes, uint8_t code);

}  // namespace openfab::testing
