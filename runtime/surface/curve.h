// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Patches along a curve that fills their box (Morton 1966): neighbours on it are neighbours in
// space, and a power of eight of its places are a cube.

#include <cstdint>
#include <vector>

#include "runtime/surface/surface.h"

namespace openfab::surface {

/// Bits of a place on the curve: the highest is of z, then y, then x, and so on.
constexpr int kCurveBits = 30;

/// The place on the curve of each patch's middle above, the patch below, in order. Of all patches
/// that have a use.
std::vector<uint64_t> along_curve(const std::vector<Patch>& patches);

}  // namespace openfab::surface
