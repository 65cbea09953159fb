// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Rods against points of their axes, and voids of foams against their centres, in double precision.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

double apart(const Vec& a, const Vec& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The distance to the nearest of points that repeat along a lattice of three edges.
double nearest(const Vec& p, const std::vector<Vec>& points, const Vec& edges) {
    double least = 1e9;
    for (const Vec& point : points) {
        Vec off{};
        for (size_t k = 0; k < 3; ++k) {
            const double d = p[k] - point[k];
            off[k] = edges[k] > 0 ? d - edges[k] * std::round(d / edges[k]) : 0;
        }
        least = std::min(least, apart(off, {}));
    }
    return least;
}

struct Case {
    const char* module;
    const char* call;
    double radius;
    std::vector<Vec> points;  ///< of a cell; of rods, in its plane
    Vec edges;                ///< 0: along the rods
};

const double kRoot3 = std::numbers::sqrt3;
const Case kCases[] = {
    {"lattice", "rods_straight(p, 5, 1)", 1, {{0, 0, 0}}, {5, 5, 0}},
    {"lattice",
     "rods_hexagonal(p, 5, 1)",
     1,
     {{0, 0, 0}, {2.5, 2.5 * kRoot3, 0}},
     {5, 5 * kRoot3, 0}},
    {"foam", "foam_voids_cubic(p, 5, 2)", 2, {{2.5, 2.5, 2.5}}, {5, 5, 5}},
    {"foam", "foam_voids_bcc(p, 5, 2)", 2, {{2.5, 2.5, 2.5}, {0, 0, 0}}, {5, 5, 5}},
    {"foam",
     "foam_voids_fcc(p, 5, 1.6)",
     1.6,
     {{0, 0, 0}, {2.5, 2.5, 0}, {2.5, 0, 2.5}, {0, 2.5, 2.5}},
     {5, 5, 5}},
};

TEST(RodsAndVoids, AreExact) {
    std::mt19937 random(19);
    std::uniform_real_distribution<double> place(-12, 12);
    for (const Case& of : kCases) {
        SCOPED_TRACE(of.call);
        const LibraryFunction function = LibraryFunction::of(of.module, of.call);
        for (int k = 0; k < 500; ++k) {
            const Vec p = {place(random), place(random), place(random)};
            EXPECT_NEAR(function(p), nearest(p, of.points, of.edges) - of.radius, 5e-6);
        }
    }
}

/// Helices as many points, of either hand; the rod is a third as thick as its coil.
TEST(RodsAndVoids, HelicesAreAsThickAsAsked) {
    constexpr double kCoil = 1.5, kRadius = 0.5, kSpacing = 5;
    struct Helix {
        double pitch, error;  ///< of the distance, in radii
    };
    for (const auto [pitch, error] : {Helix{8.0, 0.06}, Helix{-6.0, 0.14}}) {
        const LibraryFunction rod = LibraryFunction::of(
            "lattice", "rods_helical(p, 5, 1.5, " + std::to_string(pitch) + ", 0.5)");
        std::vector<Vec> axis;
        for (int k = -3000; k < 3000; ++k) {
            const double z = 1e-3 * k * std::abs(pitch), turn = 2 * std::numbers::pi * z / pitch;
            axis.push_back({kCoil * std::cos(turn), kCoil * std::sin(turn), z});
        }
        std::mt19937 random(23);
        std::uniform_real_distribution<double> across(-2.2, 2.2), up(-4, 4);
        int inside = 0, found = 0;
        for (int k = 0; k < 3000; ++k) {
            const Vec p = {across(random), across(random), up(random)};
            double exact = 1e9;
            for (const Vec& point : axis)
                exact = std::min(exact, apart(p, point));
            const double d = rod({p[0] + kSpacing, p[1] - kSpacing, p[2]}) + kRadius;
            inside += exact < kRadius ? 1 : 0;
            found += d < kRadius ? 1 : 0;
            if (exact >= kRadius) continue;
            EXPECT_NEAR(d, exact, error * kRadius);
        }
        // The share that the rods fill: the sampling error is that of what lies between both.
        EXPECT_NEAR(found, inside, 0.02 * inside + 4);
    }
}

}  // namespace
}  // namespace openfab::testing
