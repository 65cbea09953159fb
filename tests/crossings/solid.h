// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one solid of the table of crossings, the hull of two balls, and the ways to write it.

#include <string>

#include "base/vec.h"

namespace openfab::testing {

/// That of crossings.fl, in mm, asymmetric in each direction, on z = 0. The greatest depth is more than its skin.
struct Hull {
    Vec3d from{-1.93, -0.55, 1.15}, to{1.77, 0.61, 2.21};
    double radius = 1.15, other = 0.7 * 1.15;
};

/// Facets of a hull, by rings about its axis. They are at most `kSagitta` times the radius inside.
constexpr int kAround = 80;
constexpr double kSagitta = 0.0008;  ///< 1 - cos(pi / kAround), rounded up

/// An OBJ of it, divided by `by`; with `name`, as that object after a box of 1 mm far from it.
std::string hull_obj(const Hull& hull, double by = 1, const std::string& name = "");
/// The answer of a program: `mesh`, its vertices and triangles, without `done`.
std::string hull_answer(const Hull& hull);
/// The signed distance of a point, as a closed form.
double hull_distance(const Hull& hull, const Vec3d& p);

}  // namespace openfab::testing
