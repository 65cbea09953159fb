// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where attributes at nearest points are written.

#include <cstdint>

namespace openfab::nearest {

/// Output arrays of 512 values in the order of BlockAnswer, one per flattened component of the
/// fablet's @nearest inputs, floats and ints apart (the order of MicroMesh). Null pointers and null
/// arrays are skipped. Voxels that are inactive or have no answer get 0.
struct AttributeTargets {
    float* const* values = nullptr;  ///< [float component] -> 512
    /// [float component * 3 + axis] -> 512: change for one voxel step along i, j, k
    float* const* gradients = nullptr;
    uint32_t* const* flat = nullptr;  ///< [int component] -> 512, 32-bit patterns
};

/// Output arrays of 8 values for a packet of points, with the position and normal of the surface.
/// Null pointers and null arrays are skipped; lanes without an answer get 0.
struct PointTargets {
    float* position[3] = {};  ///< part-local mm: v0 + (bary1 (v1 - v0) + bary2 (v2 - v0))
    /// Unit outward normal of the winning micropolygon, rounded once from double; 0 if it has no
    /// area.
    float* normal[3] = {};
    float* const* values = nullptr;   ///< [float component] -> 8
    uint32_t* const* flat = nullptr;  ///< [int component] -> 8, 32-bit patterns
};

}  // namespace openfab::nearest
