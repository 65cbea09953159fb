// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Completes the surface stage: the returned vector d becomes the displaced position p + d',
/// part-local, and the output SURFACE_STATUS says how it was changed (rule 12). With B the
/// frame's MAX_DISPLACEMENT,
///   m   = max(|d.x|, |d.y|, |d.z|)
///   q   = d / (m > 0 ? m : 1)
///   len = m * sqrt((q.x*q.x + q.y*q.y) + q.z*q.z)
///   not all of |d.x|, |d.y|, |d.z| < inf:   d' = 0, status 1
///   else len > B:                           d' = d * ((B / len) * kShrink)
///   else:                                   d' = d
///   status 2 if len * kShrink > B, else 0
/// kShrink = 1 - 2^-20 covers the rounding of all of this, so the length of d' never exceeds B, and a
/// displacement by B along a normal does not count as one that is cut. A len beyond floats gives 0.
void bound_displacement(ir::Stage* surface);

constexpr float kShrink = 0.99999904632568359375f;

}  // namespace openfab::passes
