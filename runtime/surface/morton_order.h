// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Morton order of patches (Morton 1966): neighbours along the curve are neighbours in space, and an
// aligned range of a power of eight codes is a cube.

#include <cstdint>
#include <vector>

#include "runtime/surface/surface.h"

namespace openfab::surface {

/// Bits of a Morton code: the highest is of z, then y, then x, and so on.
constexpr int kMortonBits = 30;

/// Returns, for all patches with a use, the Morton code of the box's center in the upper 32 bits
/// and the patch in the lower, sorted.
std::vector<uint64_t> morton_order(const std::vector<Patch>& patches);

}  // namespace openfab::surface
