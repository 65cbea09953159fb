// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What hangs together in a box of voxels.

#include <cstdint>
#include <vector>

#include "tools/inspection/bits.h"

namespace openfab::inspection {

/// Neighbours share a face, or also an edge or a corner.
enum class Touch : uint8_t { kFaces, kCorners };

/// Labels the voxels that have one of the bits of `mask`: label k + 1 of `labels` is that of the k-th cluster, 0 of none.
/// Clusters are in the order of their first voxels.
std::vector<Cluster> components(const Bits& bits, Touch touch, Box<int32_t>* labels,
                                uint8_t mask = 0xff);

}  // namespace openfab::inspection
