// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exact signs of the two determinants that a ray along +x needs, for points with float coordinates:
// in double with an error bound first, then in exact sums of doubles (Shewchuk, "Adaptive
// precision floating-point arithmetic and fast robust geometric predicates", 1997). Floats as
// inputs keep every product far from overflow and underflow.

#include "base/vec.h"

namespace openfab::nearest {

/// Returns the sign of
/// (q.y - p.y) (s.z - p.z) - (q.z - p.z) (s.y - p.y): twice the (y, z) area of p, q, s.
int area_sign(const Vec3f& p, const Vec3f& q, const Vec3f& s);

/// Returns the sign of ((b - a) x (c - a)) . (s - a).
int volume_sign(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& s);

}  // namespace openfab::nearest
