// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fablet written by hand, with kernels in plain C++ behind the same ABI as compiled ones, so that
// dicing and voxelisation are tested without the compiler. Link openfab_test_surface.
//
//   surface inputs   0 float2 uv    1 int face
//   surface outputs  0 uvOut = uv   1 faceOut = face   2 float height (computed)
//                    3 int zone (computed)
//   nearest          float2 uv, int face [, float height, int zone]
//   uniforms         0 int mode     1 float amplitude mm

#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"
#include "tests/support/reference/dice.h"
#include "tests/support/reference/inside.h"

namespace openfab::testing {

enum class HandMode : int32_t {
    kBack = 0,  ///< like the postcard: face 1 moves along n by amplitude * wave(uv), the rest is an
                ///< identity
    kBumps = 1,      ///< everything moves along n by a wave of p
    kFootprint = 2,  ///< everything moves along n by a function of uv gradients and ng
    kStill = 3,      ///< moves by exactly 0, which its interval form does not show
    kRelief = 5,     ///< like kBack, with photographic detail: waves of 50 down to 0.5 mm on a
                     ///< 100 mm card
    kBroken = 4,     ///< NaN on a part of the surface, infinite on another
    kOffset = 6,     ///< everything moves along n by the amplitude
    kSteps = 7,      ///< face k moves along n by (1 + k % 3) / 3 of the amplitude
    kDents = 8,      ///< everything moves along n by a wave of p from 0 to the amplitude
};

/// With `computed`, the fablet has outputs 2 and 3, and no triangle can be an identity.
const openfab_fablet& hand_fablet(bool computed);
/// Same, but surface_bounds returns no bound.
const openfab_fablet& hand_fablet_unbounded();

std::vector<uint32_t> hand_uniforms(HandMode mode, float amplitude_mm);

/// One micro-vertex of the part's surface stage, for the plain dicer.
reference::EvaluateMicro hand_evaluate(const part::Part& part);

/// Returns which base triangles are identities by the fablet's definition, not by its kernels.
std::vector<uint8_t> hand_identities(const part::Part& part, bool infer_identity = true);

/// Returns all triangles that the voxeliser crosses: those of the mesh for an identity surface,
/// else micropolygons.
std::vector<std::array<Vec3d, 3>> covering_triangles(const part::Part& part,
                                                     const surface::Surface& surface);

/// Returns all triangles of a surface for the voxeliser, or all for queries.
std::vector<std::array<Vec3f, 3>> triangles_of(const surface::Surface& surface,
                                               surface::PatchUse use);
std::vector<std::array<Vec3f, 3>> triangles_of(const std::vector<reference::DicedTriangle>& diced,
                                               surface::PatchUse use);

/// Counts directed edges without an opposite, by the bits of positions: 0 for a closed surface.
int64_t open_edges(const std::vector<std::array<Vec3f, 3>>& triangles);

}  // namespace openfab::testing
