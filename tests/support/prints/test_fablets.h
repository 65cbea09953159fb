// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablet tables written by hand, with kernels in plain C++, to test the slab loop without the
// compiler. None has a surface stage. All have the slots `a`, `b` (materials) and VOID,
// in this order.

#include <span>

#include "abi/fablet_table.h"

namespace openfab::testing {

/// Material a everywhere; no query.
const openfab_fablet& solid_fablet();
/// 30 % a, 70 % b everywhere; no query.
const openfab_fablet& tint_fablet();
/// 25 % a, 60 % b, 15 % void where the distance to the surface is at most kSkin mm. Deeper: a.
const openfab_fablet& skin_fablet();
constexpr float kSkin = 0.33f;
/// VOID everywhere: cuts a hole. No query.
const openfab_fablet& hole_fablet();
/// Reads the @nearest int attribute `face` and the float2 attribute `uv`: within kSkin of face 0
/// (the top of a box) b with weight uv.x, rounded down to eighths, and a for the rest; else a.
const openfab_fablet& picture_fablet();
/// The kernel of its volume stage returns an error code.
const openfab_fablet& broken_fablet();

/// Weights of slots a, b, VOID as the fablets' kernels give them, for a voxel at `distance`
/// (unsigned, mm) from the surface, with the nearest point's face and uv.x.
struct Weights {
    float a, b, empty;
};
Weights skin_weights(float distance);
Weights picture_weights(float distance, int32_t face, float u);

}  // namespace openfab::testing
