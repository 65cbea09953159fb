// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Solids against many points of their surface, and against what is inside by definition.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

using Corner = std::array<double, 2>;

struct Case {
    const char* name;
    std::string body;             ///< ends a function that returns the distance
    std::vector<Corner> outline;  ///< of (radius, z)
    std::function<bool(Vec)> is_inside;
};

/// Distance to a line of (radius, height), which a solid of revolution has for its surface.
double from_outline(const std::vector<Corner>& corners, double r, double z) {
    double least = 1e9;
    for (size_t k = 0; k + 1 < corners.size(); ++k) {
        const auto [x0, z0] = corners[k];
        const double x = corners[k + 1][0] - x0, y = corners[k + 1][1] - z0;
        const double t = std::clamp(((r - x0) * x + (z - z0) * y) / (x * x + y * y), 0.0, 1.0);
        least = std::min(least, std::hypot(r - x0 - t * x, z - z0 - t * y));
    }
    return least;
}

std::vector<Corner> circle(double x, double radius) {
    std::vector<Corner> out;
    for (int k = 0; k <= 2000; ++k) {
        const double turn = k * std::numbers::pi / 1000;
        out.push_back({x + radius * std::cos(turn), radius * std::sin(turn)});
    }
    return out;
}

bool in_cone(Vec p) {
    return std::abs(p[2]) < 2 && std::hypot(p[0], p[1]) < 3 - (p[2] + 2) / 2;
}
bool in_vase(Vec p) {
    const double r = std::hypot(p[0], p[1]), z = p[2];
    const double side = z < 0 ? 2 - (z + 3) / 3 : 1 + 2 * z / 3;
    return z > -3 && z < 2 + r / 3 && r < side;
}

std::vector<Case> cases() {
    return {
        {"ball", "return solid_ball(p, 2.5);", circle(0, 2.5),
         [](Vec p) { return std::hypot(p[0], p[1], p[2]) < 2.5; }},
        {"cylinder",
         "return solid_cylinder(p, 2, 5);",
         {{0, -2.5}, {2, -2.5}, {2, 2.5}, {0, 2.5}},
         [](Vec p) { return std::abs(p[2]) < 2.5 && std::hypot(p[0], p[1]) < 2; }},
        {"cone", "return solid_cone(p, 3, 1, 4);", {{0, -2}, {3, -2}, {1, 2}, {0, 2}}, in_cone},
        {"tip",
         "return solid_cone(p, 3, 0, 4);",
         {{0, -2}, {3, -2}, {0, 2}},
         [](Vec p) { return std::abs(p[2]) < 2 && std::hypot(p[0], p[1]) < 3 * (2 - p[2]) / 4; }},
        {"torus", "return solid_torus(p, 2.5, 1);", circle(2.5, 1),
         [](Vec p) { return std::hypot(std::hypot(p[0], p[1]) - 2.5, p[2]) < 1; }},
        {"vase",
         "float2 corners[32] = {}; corners[0] = float2(0, -3); corners[1] = float2(2, -3);\n"
         "corners[2] = float2(1, 0); corners[3] = float2(3, 3); corners[4] = float2(0, 2);\n"
         "return polygon_area(float2(length(p.xy), p.z), corners, 5);",
         // The axis is an edge too, inside the solid: a point there is as far from it as it is.
         {{0, -3}, {2, -3}, {1, 0}, {3, 3}, {0, 2}, {0, -3}},
         in_vase}};
}

class Solids : public ::testing::TestWithParam<Case> {};

TEST_P(Solids, AreExactOnBothSides) {
    const Case& solid = GetParam();
    const LibraryFunction function("solids", solid.body);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-4, 4);
    int inside = 0;
    for (int k = 0; k < 2000; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        const double found = function(p);
        const double exact = from_outline(solid.outline, std::hypot(p[0], p[1]), p[2]);
        EXPECT_NEAR(std::abs(found), exact, 2e-5) << p[0] << ' ' << p[1] << ' ' << p[2];
        if (exact > 1e-4) {
            EXPECT_EQ(found < 0, solid.is_inside(p));
        }
        inside += found < 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 60);
}

INSTANTIATE_TEST_SUITE_P(All, Solids, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name; });

double value(const std::string& expression) {
    return LibraryFunction::of("solids", expression)({});
}

TEST(SolidsByHand, BoxesCapsulesAndExtrusions) {
    EXPECT_NEAR(value("solid_box(float3(4, 0, 0), float3(4, 6, 8), 1)"), 2, 1e-6);
    EXPECT_NEAR(value("solid_box(float3(1.5, 0, 0), float3(4, 6, 8), 1)"), -0.5, 1e-6);
    EXPECT_NEAR(value("solid_box(float3(5, 7, 0), float3(4, 6, 8), 0)"), 5, 1e-6);
    // The round of an edge: its centre is at (1, 2).
    EXPECT_NEAR(value("solid_box(float3(4, 6, 0), float3(4, 6, 8), 1)"), 4, 1e-6);
    EXPECT_NEAR(value("solid_capsule(float3(3, 4, 0), 0, float3(0, 0, 9), 2)"), 3, 1e-6);
    EXPECT_NEAR(value("solid_capsule(float3(0, 3, 13), 0, float3(0, 0, 9), 2)"), 3, 1e-6);
    EXPECT_NEAR(value("solid_capsule(float3(0, 3, 4), 0, 0, 2)"), 3, 1e-6);
    EXPECT_NEAR(value("solid_extruded(3, 6, 4)"), 5, 1e-6);
    EXPECT_NEAR(value("solid_extruded(-3, 1, 4)"), -1, 1e-6);
}

}  // namespace
}  // namespace openfab::testing
