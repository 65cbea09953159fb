// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What makes a function of the library a signed distance, or a bound of one, without knowing the nearest point. A
// function that never changes by more than the way, and is 0 on the surface, is nowhere farther from 0 than the distance.
// If from p, against its gradient, by its value one comes to the surface, it is not nearer to 0 either.

#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {

struct Box3 {
    Vec low, high;
};

/// Fails the test where the function changes by more than the way between two points of the box, and `slack`.
void expect_bound(const LibraryFunction& f, const Box3& box, double slack = 2e-5);
/// Fails the test where the surface is not reached so, but on ridges, where there is no gradient.
void expect_exact(const LibraryFunction& f, const Box3& box);
/// Points of the surface, on random lines through the box.
std::vector<Vec> surface_points(const LibraryFunction& f, const Box3& box, size_t count);
/// The least of the function's share of the distance to the surface, at points that are `away` from it or more.
double tightness(const LibraryFunction& f, const Box3& box, double away);

}  // namespace openfab::testing
