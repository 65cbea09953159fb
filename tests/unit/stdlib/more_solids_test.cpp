// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Solids, sweeps and deformations: what is inside by definition, what is exact and what is a bound (distance_check.h).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/distance_check.h"

namespace openfab::testing {
namespace {

constexpr Box3 kBox = {{-5, -5, -5}, {5, 5, 5}};
/// Nearly: with steps of the size that the module states.
enum Claim { kExact, kBound, kNearly };

struct Case {
    const char* name;
    const char* modules;
    std::string expression;
    Claim claim;
    std::function<bool(Vec)> is_inside;
};

double dot(Vec a, Vec b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec minus(Vec a, Vec b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

bool in_box_chamfer(Vec p) {
    const double x = 2 - std::abs(p[0]), y = 1.5 - std::abs(p[1]), z = 3 - std::abs(p[2]);
    return x > 0 && y > 0 && z > 0 && x + y > 0.8 && y + z > 0.8 && z + x > 0.8;
}

bool in_ellipsoid(Vec p, double a, double b, double c) {
    return std::hypot(p[0] / a, p[1] / b, p[2] / c) < 1;
}

/// Balls between two, closely.
bool in_round_cone(Vec p) {
    for (double t = 0; t <= 1; t += 1.0 / 2048) {
        if (std::hypot(p[0] + 2 - 4 * t, p[1] + 1 - 2 * t, p[2] - t) < 2 - 1.4 * t) return true;
    }
    return false;
}

/// A regular polygon about the origin with a corner on the axis of x.
bool in_polygon(double x, double y, int sides, double radius) {
    for (int k = 0; k < sides; ++k) {
        const double turn = (2 * k + 1) * std::numbers::pi / sides;
        if (x * std::cos(turn) + y * std::sin(turn) > radius * std::cos(std::numbers::pi / sides))
            return false;
    }
    return true;
}

bool in_pyramid(Vec p) {
    const double share = (2 - p[2]) / 4;
    return std::abs(p[2]) < 2 && std::abs(p[0]) < 3 * share && std::abs(p[1]) < 2 * share;
}

bool in_tetrahedron(Vec p) {
    const Vec corners[4] = {{-3, -2, -2}, {3, -1, -2}, {0, 3, -1}, {1, 0, 3}};
    for (int k = 0; k < 4; ++k) {
        const Vec a = corners[(k + 1) % 4], u = minus(corners[(k + 2) % 4], a),
                  v = minus(corners[(k + 3) % 4], a);
        const Vec n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                       u[0] * v[1] - u[1] * v[0]};
        if (dot(n, minus(p, a)) * dot(n, minus(corners[k], a)) < 0) return false;
    }
    return true;
}

/// Near a curve, by many of its points.
bool near_curve(Vec p, const std::function<Vec(double)>& curve, double radius) {
    for (int k = 0; k <= 4000; ++k) {
        const Vec off = minus(p, curve(k / 4000.0));
        if (dot(off, off) < radius * radius) return true;
    }
    return false;
}

Vec cubic(double t) {
    const Vec p[4] = {{-4, -3, 0}, {-1, 6, 2}, {2, -7, 1}, {4, 3, -2}};
    const double s = 1 - t;
    const double w[4] = {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
    Vec out = {0, 0, 0};
    for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t k = 0; k < 4; ++k)
            out[axis] += w[k] * p[k][axis];
    }
    return out;
}
Vec quadratic(double t) {
    const double s = 1 - t;
    return {-4 * s * s + 4 * t * t, -3 * s * s + 12 * s * t - 3 * t * t, 2 * t * t};
}

bool in_block(Vec p) {
    return std::abs(p[0]) < 1.5 && std::abs(p[1]) < 1 && std::abs(p[2]) < 2;
}

const char* const kBlock = "solid_box(%, float3(3, 2, 4), 0)";

/// A block at another point, and what it is divided by.
std::string block(const std::string& point, const std::string& stretch = "1") {
    std::string text = kBlock;
    return text.replace(text.find('%'), 1, point) + " / " + stretch;
}

std::vector<Case> cases() {
    return {
        {"box_chamfer", "solids", "solid_box_chamfer(p, float3(4, 3, 6), 0.8)", kBound,
         in_box_chamfer},
        {"half", "solids", "solid_half(p, float3(1, 0, 0), float3(1, 2, 2))", kExact,
         [](Vec p) { return p[0] - 1 + 2 * p[1] + 2 * p[2] < 0; }},
        {"ellipsoid", "solids", "solid_ellipsoid(p, float3(4, 2.5, 1))", kExact,
         [](Vec p) { return in_ellipsoid(p, 4, 2.5, 1); }},
        {"needle", "solids", "solid_ellipsoid(p, float3(0.3, 4, 0.5))", kExact,
         [](Vec p) { return in_ellipsoid(p, 0.3, 4, 0.5); }},
        {"round_cone", "solids", "solid_round_cone(p, float3(-2, -1, 0), float3(2, 1, 1), 2, 0.6)",
         kExact, in_round_cone},
        {"link", "solids", "solid_link(p, 3, 2, 0.6)", kExact,
         [](Vec p) {
             const double y = std::max(std::abs(p[1]) - 1.5, 0.0);
             return std::hypot(std::hypot(p[0], y) - 2, p[2]) < 0.6;
         }},
        {"prism", "solids", "solid_prism(p, 5, 3, 4)", kExact,
         [](Vec p) { return std::abs(p[2]) < 2 && in_polygon(p[0], p[1], 5, 3); }},
        {"triangle", "solids", "solid_prism(p, 3, 4, 2)", kExact,
         [](Vec p) { return std::abs(p[2]) < 1 && in_polygon(p[0], p[1], 3, 4); }},
        {"pyramid", "solids", "solid_pyramid(p, float2(6, 4), 4)", kExact, in_pyramid},
        {"tetrahedron", "solids",
         "solid_tetrahedron(p, float3(-3, -2, -2), float3(3, -1, -2), float3(0, 3, -1),"
         "float3(1, 0, 3))",
         kExact, in_tetrahedron},
        {"tetrahedron_turned", "solids",
         "solid_tetrahedron(p, float3(3, -1, -2), float3(-3, -2, -2), float3(0, 3, -1),"
         "float3(1, 0, 3))",
         kExact, in_tetrahedron},
        {"curve", "sweeps",
         "sweep_bezier(p, float3(-4, -3, 0), float3(0, 6, 0), float3(4, -3, 2), 0.7)", kNearly,
         [](Vec p) { return near_curve(p, quadratic, 0.7); }},
        {"cubic", "sweeps",
         "sweep_bezier(p, float3(-4, -3, 0), float3(-1, 6, 2), float3(2, -7, 1),"
         "float3(4, 3, -2), 0.7)",
         kNearly, [](Vec p) { return near_curve(p, cubic, 0.7); }},
        {"turn", "solids deform", block("deform_turn(p, float3(0, 0, 3), 0.5235988)"), kExact,
         [](Vec p) {
             // Turned from x towards y.
             const double c = std::cos(std::numbers::pi / 6), s = 0.5;
             return in_block({c * p[0] + s * p[1], c * p[1] - s * p[0], p[2]});
         }},
        {"mirror", "solids deform",
         "solid_ball(deform_mirror(p, float3(0.5, 0, 0), float3(2, 0, 0)) - float3(2.5, 0, 0), 1)",
         kExact, [](Vec p) { return std::hypot(std::abs(p[0] - 0.5) - 2, p[1], p[2]) < 1; }},
        {"repeat", "solids deform", "solid_ball(deform_repeat(p, float3(3, 4, 0)), 1)", kExact,
         [](Vec p) {
             return std::hypot(std::remainder(p[0], 3), std::remainder(p[1], 4), p[2]) < 1;
         }},
        {"repeat_some", "solids deform",
         "solid_ball(deform_repeat(p, 3, int3(-1, 0, 0), int3(0, 1, 0)), 1)", kExact,
         [](Vec p) {
             return std::hypot(std::min(std::abs(p[0]), std::abs(p[0] + 3)),
                               std::min(std::abs(p[1]), std::abs(p[1] - 3)), p[2]) < 1;
         }},
        {"around", "solids deform", "solid_ball(deform_around(p, 5) - float3(3, 0, 0), 1)", kExact,
         [](Vec p) {
             for (int k = 0; k < 5; ++k) {
                 const double turn = k * 0.4 * std::numbers::pi;
                 if (std::hypot(p[0] - 3 * std::cos(turn), p[1] - 3 * std::sin(turn), p[2]) < 1)
                     return true;
             }
             return false;
         }},
        // 7.08 is how far the box's corners are from the axis: between two points the way is within.
        {"twist", "solids deform", block("deform_twist(p, 0.3)", "deform_twist_stretch(7.08, 0.3)"),
         kBound,
         [](Vec p) {
             const double turn = 0.3 * p[2];
             return in_block({std::cos(turn) * p[0] + std::sin(turn) * p[1],
                              std::cos(turn) * p[1] - std::sin(turn) * p[0], p[2]});
         }},
        {"bend", "solids deform",
         "solid_box(deform_bend(p, 12), float3(9, 2, 3), 0) / deform_bend_stretch(5, 12)", kBound,
         [](Vec p) {
             const double from_axis = std::hypot(p[0], 12 - p[2]);
             const double along = 12 * std::atan2(p[0], 12 - p[2]);
             return std::abs(along) < 4.5 && std::abs(p[1]) < 1 && std::abs(12 - from_axis) < 1.5;
         }},
        {"bend_down", "solids deform",
         "solid_box(deform_bend(p, -12), float3(9, 2, 3), 0) / deform_bend_stretch(5, -12)", kBound,
         [](Vec p) {
             const double from_axis = std::hypot(p[0], 12 + p[2]);
             const double along = 12 * std::atan2(p[0], 12 + p[2]);
             return std::abs(along) < 4.5 && std::abs(p[1]) < 1 && std::abs(12 - from_axis) < 1.5;
         }},
        {"taper", "solids deform",
         block("deform_taper(p, -2, 2, 1.4, 0.7)", "deform_taper_stretch(10.2, -2, 2, 1.4, 0.7)"),
         kBound,
         [](Vec p) {
             const double scale = 1.4 - 0.7 * std::clamp((p[2] + 2) / 4, 0.0, 1.0);
             return in_block({p[0] / scale, p[1] / scale, p[2]});
         }},
        {"shell", "solids", "solid_shell(solid_ball(p, 4), 1)", kBound,
         [](Vec p) { return std::abs(std::sqrt(dot(p, p)) - 3.5) < 0.5; }},
        {"sheet", "solids", "solid_sheet(solid_ball(p, 3), 1)", kExact,
         [](Vec p) { return std::abs(std::sqrt(dot(p, p)) - 3) < 0.5; }},
        {"offset", "solids", "solid_offset(solid_ball(p, 3), -0.5)", kExact,
         [](Vec p) { return dot(p, p) < 2.5 * 2.5; }}};
}

class MoreSolids : public ::testing::TestWithParam<Case> {};

TEST_P(MoreSolids, AreWhatTheyClaim) {
    const Case& solid = GetParam();
    const LibraryFunction f = LibraryFunction::of(solid.modules, solid.expression);
    expect_bound(f, kBox, solid.claim == kNearly ? 0.02 : 2e-5);
    if (solid.claim != kBound) expect_exact(f, kBox);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-5, 5);
    int inside = 0;
    for (int k = 0; k < 4000; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        const double d = f(p);
        if (std::abs(d) < 1e-3) continue;
        ASSERT_EQ(d < 0, solid.is_inside(p)) << p[0] << ", " << p[1] << ", " << p[2] << ": " << d;
        inside += d < 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 5);
}

INSTANTIATE_TEST_SUITE_P(All, MoreSolids, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name; });

TEST(MoreSolidsByHand, ChamferedBoxesAreTight) {
    const LibraryFunction f =
        LibraryFunction::of("solids", "solid_box_chamfer(p, float3(4, 3, 6), 0.8)");
    EXPECT_GT(tightness(f, kBox, 0.5), 0.81);
}

double value(const std::string& modules, const std::string& expression) {
    return LibraryFunction::of(modules, expression)({});
}

TEST(MoreSolidsByHand, DegenerateOnesAreFinite) {
    // Where one ball holds the other, and where both are one.
    EXPECT_NEAR(value("solids", "solid_round_cone(float3(0, 0, 5), 0, float3(0, 0, 1), 3, 1)"), 2,
                1e-5);
    EXPECT_NEAR(value("solids", "solid_round_cone(float3(0, 0, -5), 0, float3(0, 0, 1), 1, 3)"), 3,
                1e-5);
    EXPECT_NEAR(value("solids", "solid_round_cone(float3(0, 4, 0), 0, 0, 1, 1)"), 3, 1e-5);
    EXPECT_NEAR(value("solids", "solid_ellipsoid(0, float3(4, 2, 1))"), -1, 1e-5);
    EXPECT_NEAR(value("solids", "solid_ellipsoid(float3(0, 3, 4), 2)"), 3, 1e-5);
    // Inside the focal ellipse, where the nearest point is beside the short axis: of x = 1 on an
    // ellipse of 2 and 1, at (4 / 3, sqrt(5) / 3).
    EXPECT_NEAR(value("solids", "solid_ellipsoid(float3(1, 0, 0), float3(2, 1, 9))"),
                -std::sqrt(6) / 3, 1e-5);
    EXPECT_NEAR(value("solids", "solid_prism(0, 6, 2, 9)"), -std::sqrt(3), 1e-5);
    EXPECT_NEAR(value("solids", "solid_share(1, 1, 2)"), 0.5, 1e-6);
    EXPECT_EQ(value("solids", "solid_share(3, 1, 2)"), 1);
    EXPECT_EQ(value("solids", "solid_share(1, 3, 2)"), 0);
    EXPECT_EQ(value("solids", "solid_share(1, 3, 0)"), 0);
    EXPECT_EQ(
        value("sweeps", "path_distance(path_line(path(float3(0, 4, 0)), 1, 1), 0) < 4 ? 1 : 0"), 1);
    EXPECT_EQ(value("deform", "deform_repeat_number(float3(7, -1, 5), float3(3, 3, 0)).x"), 2);
}

TEST(MoreSolidsByHand, PolylinesAndSections) {
    const std::string corners =
        "float3 corners[32] = {}; corners[0] = float3(-3, 0, 0); corners[1] = float3(0, 0, 0);\n"
        "corners[2] = float3(0, 4, 0);\n";
    const LibraryFunction pipe("sweeps", corners + "return sweep_polyline(p, corners, 3, 0.5);");
    expect_bound(pipe, kBox);
    expect_exact(pipe, kBox);
    EXPECT_NEAR(pipe({-4, 0, 0}), 0.5, 1e-6);
    EXPECT_NEAR(pipe({2, 3, 0}), 1.5, 1e-6);
    EXPECT_NEAR(pipe({2, 3, 1}), std::sqrt(5) - 0.5, 1e-5);
    const std::string way =
        "Path way = path_line(path_line(path(p), float3(-3, 0, 0), 0), 0, float3(0, 4, 0));\n";
    const LibraryFunction at("sweeps", way + "return way.at;");
    EXPECT_NEAR(at({-1.5, -1, 0}), 0.5, 1e-6);
    EXPECT_NEAR(at({2, 3, 0}), 1.75, 1e-6);
    const LibraryFunction side("sweeps", way + "return path_section(way, float3(0, 0, 1)).x;");
    const LibraryFunction up("sweeps", way + "return path_section(way, float3(0, 0, 1)).y;");
    EXPECT_NEAR(side({2, 3, 0.25}), 2, 1e-5);
    EXPECT_NEAR(side({-2, -1, 0.25}), 1, 1e-5);
    EXPECT_NEAR(up({2, 3, 0.25}), 0.25, 1e-5);
}

// ---- Two solids ---------------------------------------------------------------------------------

constexpr double kRound = 1.5;

/// Distance to the area left of or below two axes, whose inner corner is filled: by a round of
/// that radius, or by a straight line.
double corner_distance(double x, double y, bool is_round) {
    const double r = kRound;
    std::vector<std::array<double, 2>> line;
    for (double t = 0; t <= 12; t += 1e-3) {
        line.push_back({0, r + t});
        line.push_back({r + t, 0});
    }
    for (double t = 0; t <= 1; t += 1e-4) {
        const double turn = t * std::numbers::pi / 2;
        if (is_round) line.push_back({r - r * std::sin(turn), r - r * std::cos(turn)});
        if (!is_round) line.push_back({r * t, r * (1 - t)});
    }
    double least = 1e9;
    for (const auto& [a, b] : line)
        least = std::min(least, std::hypot(x - a, y - b));
    const bool filled = is_round ? x < r && y < r && std::hypot(x - r, y - r) > r : x + y < r;
    return x < 0 || y < 0 || filled ? -least : least;
}

TEST(Joined, CornersAreRoundsAndChamfers) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-3, 4);
    for (const bool is_round : {true, false}) {
        const LibraryFunction f =
            LibraryFunction::of("solids", is_round ? "solid_union_smooth(p.x, p.y, 1.5)"
                                                   : "solid_union_chamfer(p.x, p.y, 1.5)");
        double least = 1e9;
        for (int k = 0; k < 300; ++k) {
            const Vec p = {place(random), place(random), 0};
            const double exact = corner_distance(p[0], p[1], is_round), found = f(p);
            if (std::abs(exact) < 2e-3) continue;
            ASSERT_EQ(found < 0, exact < 0) << p[0] << ' ' << p[1];
            ASSERT_LE(std::abs(found), std::abs(exact) + 1e-3) << p[0] << ' ' << p[1];
            if (exact > 0 || is_round) least = std::min(least, std::abs(found) / std::abs(exact));
        }
        EXPECT_GT(least, 0.69) << is_round;
    }
}

TEST(Joined, IsABoundOfAnyTwoAndSharpAwayFromTheEdge) {
    const std::string a = "solid_ball(p, 3)",
                      b = "solid_box(p - float3(1, 2, 0), float3(3, 4, 5), 0)";
    const LibraryFunction of_a = LibraryFunction::of("solids", a),
                          of_b = LibraryFunction::of("solids", b);
    for (const std::string how : {"union", "intersection", "difference"}) {
        const LibraryFunction sharp =
            LibraryFunction::of("solids", "solid_" + how + "(" + a + ", " + b + ")");
        expect_bound(sharp, kBox);
        for (const std::string edge : {"smooth", "chamfer"}) {
            const LibraryFunction f = LibraryFunction::of(
                "solids", "solid_" + how + "_" + edge + "(" + a + ", " + b + ", 0.75)");
            const LibraryFunction none = LibraryFunction::of(
                "solids", "solid_" + how + "_" + edge + "(" + a + ", " + b + ", 0)");
            expect_bound(f, kBox);
            std::mt19937 random(4);
            std::uniform_real_distribution<double> place(-5, 5);
            int same = 0;
            for (int k = 0; k < 2000; ++k) {
                const Vec p = {place(random), place(random), place(random)};
                const double x = of_a(p), y = how == "difference" ? -of_b(p) : of_b(p);
                ASSERT_EQ(none(p), sharp(p));
                if (std::abs(x - y) > 0.7501) {
                    ASSERT_EQ(f(p), sharp(p));
                    ++same;
                }
                // A union grows, what is left of a shrinks.
                ASSERT_LE(how == "union" ? f(p) : sharp(p), how == "union" ? sharp(p) : f(p));
            }
            EXPECT_GT(same, 500);
        }
    }
}

TEST(Joined, ShareIsTheSlopeOfTheSmoothUnion) {
    for (double a = -2; a <= 2; a += 0.37) {
        const LibraryFunction f =
            LibraryFunction::of("solids", "solid_union_smooth(p.x, p.y, 1.3)");
        const LibraryFunction share = LibraryFunction::of("solids", "solid_share(p.x, p.y, 1.3)");
        const double slope = (f({a, 0.3 + 1e-2, 0}) - f({a, 0.3 - 1e-2, 0})) / 2e-2;
        EXPECT_NEAR(share({a, 0.3, 0}), slope, 5e-3) << a;
    }
}

}  // namespace
}  // namespace openfab::testing
