// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solid shapes of one mixture, and the shares printed of what is seen of them.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/support/reference/dither.h"

namespace openfab::tests {

/// The fractions of void, 0, of material 1, which takes what is left, and of the others.
std::vector<uint16_t> quantised(const std::vector<double>& others);

using Inside = std::function<bool(const Vec3i&)>;

/// `mixture` where `inside` says so, void elsewhere.
reference::FractionField shaped(const Vec3i& size, const std::vector<uint16_t>& mixture,
                                const Inside& inside);
reference::FractionField box(const Vec3i& size, const std::vector<uint16_t>& mixture);
/// In a cube with a margin of a voxel at least.
reference::FractionField ball(double radius, const std::vector<uint16_t>& mixture);

/// Of voxels that are not void and that `where` takes, the share that has this code.
double share_of(const reference::FractionField& field, const std::vector<uint8_t>& codes,
                uint8_t code, const Inside& where);

/// The outermost layers of a box: -x, +x, -y, +y, -z, +z; or those `depth` below them.
std::array<double, 6> face_shares(const reference::FractionField& field,
                                  const std::vector<uint8_t>& codes, uint8_t code,
                                  int32_t depth = 0);
/// Voxels with a void neighbour, by the octant of the cube that they are in.
std::array<double, 8> skin_shares(const reference::FractionField& field,
                                  const std::vector<uint8_t>& codes, uint8_t code);

}  // namespace openfab::tests
