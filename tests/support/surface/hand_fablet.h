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
    kBumps = 1,      ///< all of it moves along n by a wave of p
    kFootprint = 2,  ///< all of it moves along n by what its triangle's uv gradients and ng say
    kStill = 3,      ///< moves by exactly 0, but the interval form does not know
    kRelief = 5,     ///< as kBack, with detail like a photograph's: waves of 50 down to 0.5 mm on a
                     ///< 100 mm card
    kBroken = 4,     ///< NaN on a part of the surface, infinite on another
};

/// With `computed`, the fablet has outputs 2 and 3, and no triangle can be an identity.
const openfab_fablet& hand_fablet(bool computed);
/// The same without its surface_bounds interval: it answers "unknown".
const openfab_fablet& hand_fablet_unbounded();

std::vector<uint32_t> hand_uniforms(HandMode mode, float amplitude_mm);

/// One micro-vertex of the part's surface stage, for the plain dicer.
reference::EvaluateMicro hand_evaluate(const scene::Part& part);

/// Which base triangles are identities by the fablet's definition, not by its kernels.
std::vector<uint8_t> hand_identities(const scene::Part& part, bool infer_identity = true);

/// All triangles that the voxeliser crosses: of an identity surface those of the mesh, else
/// micropolygons.
std::vector<std::array<Vec3d, 3>> covering_triangles(const scene::Part& part,
                                                     const surface::Surface& surface);

/// All triangles that a surface gives to the voxeliser, or all that it gives to queries.
std::vector<std::array<Vec3f, 3>> triangles_of(const surface::Surface& surface,
                                               surface::PatchUse use);
std::vector<std::array<Vec3f, 3>> triangles_of(const std::vector<reference::DicedTriangle>& diced,
                                               surface::PatchUse use);

/// Directed edges of triangles that have no opposite, by the bits of positions: 0 for a closed
/// surface.
int64_t open_edges(const std::vector<std::array<Vec3f, 3>>& triangles);

}  // namespace openfab::testing
