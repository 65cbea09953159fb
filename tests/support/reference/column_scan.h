// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reference of support: each column is scanned from its top, and below the first voxel of a
// material that needs support every void voxel is support.

#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::reference {

/// `codes` and `asks` (nonzero: the voxel has a material that must be supported) x fastest, then y,
/// then z. Returns the codes with support.
std::vector<uint8_t> add_support(std::vector<uint8_t> codes, const std::vector<uint8_t>& asks,
                                 const Vec3i& size, uint8_t support_code);

}  // namespace openfab::reference
