// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `gradient` and `mean_curvature`: closed forms; differences of each function of the library that takes a point.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "tests/support/places/places.h"
#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

/// Three components of a gradient.
struct Gradient {
    Gradient(const std::string& modules, const std::string& call, const std::string& functions = "")
        : parts{LibraryFunction(modules, "return (" + call + ").x;", functions),
                LibraryFunction(modules, "return (" + call + ").y;", functions),
                LibraryFunction(modules, "return (" + call + ").z;", functions)} {}
    Vec operator()(const Vec& p) const { return {parts[0](p), parts[1](p), parts[2](p)}; }
    std::array<LibraryFunction, 3> parts;
};

std::vector<Vec> places(int count, double reach = 4) {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> place(-reach, reach);
    std::vector<Vec> out;
    for (int k = 0; k < count; ++k)
        out.push_back({place(random), place(random), place(random)});
    return out;
}

void expect_near(const Vec& found, const Vec& exact, double error, const Vec& p) {
    for (size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found[axis], exact[axis], error) << p[0] << ", " << p[1] << ", " << p[2];
}

TEST(Gradients, AreClosedForms) {
    const Gradient polynomial("", "gradient(f, p, 3)",
                              "float f(float3 q, float by) { return q.x * q.x * q.y - by * q.z; }");
    const Gradient functions("", "gradient(f, p)",
                             "float f(float3 q) { return sin(q.x) * exp(q.y / 4) + atan2(q.z, 5) + "
                             "sqrt(q.x * q.x + 1); }");
    const Gradient ball("solids", "gradient(solid_ball, p, 2)");
    for (const Vec& p : places(200)) {
        expect_near(polynomial(p), {2 * p[0] * p[1], p[0] * p[0], -3}, 1e-5, p);
        expect_near(functions(p),
                    {std::cos(p[0]) * std::exp(p[1] / 4) + p[0] / std::hypot(p[0], 1),
                     std::sin(p[0]) * std::exp(p[1] / 4) / 4, 5 / (p[2] * p[2] + 25)},
                    2e-6, p);
        const double r = std::hypot(p[0], p[1], p[2]);
        expect_near(ball(p), {p[0] / r, p[1] / r, p[2] / r}, 1e-6, p);
    }
    // In the middle of a ball, and inside a box, whose length is that of 0.
    expect_near(ball({0, 0, 0}), {0, 0, 0}, 0, {});
    expect_near(Gradient("solids", "gradient(solid_box, p, float3(4, 6, 8), 0.5)")({0.5, 0, 0}),
                {1, 0, 0}, 0, {});
}

TEST(Gradients, OfConstantAndEqualComponents) {
    EXPECT_EQ(
        LibraryFunction("", "return gradient(f, 3.0);", "float f(float x) { return x * x; }")({}),
        6);
    const LibraryFunction y("", "return gradient(f, float2(t, t)).y;",
                            "float f(float2 q) { return q.x * q.x + 5 * q.y; }");
    EXPECT_EQ(y({}, 2), 5);
}

TEST(Gradients, GoThroughBranchesLoopsAndCalls) {
    const Gradient found("", "gradient(f, p)",
                         "float inner(float3 q, int k) { return k % 2 == 0 ? q.x * q.y : q.z; }\n"
                         "float f(float3 q) { float s = 0; for (int k = 0; k < 4; ++k) {\n"
                         "if (q.x > 0) s += k * inner(q, k); else s -= abs(q.y); } return s; }");
    for (const Vec& p : places(100)) {
        const double side = p[1] < 0 ? 4 : -4;
        expect_near(found(p), p[0] > 0 ? Vec{2 * p[1], 2 * p[0], 4} : Vec{0, side, 0}, 1e-5, p);
    }
}

/// An index takes no part; what lies between elements is their difference.
TEST(Gradients, GoThroughTables) {
    const Gradient squares(
        "", "gradient(f, p)",
        "float f(float3 q) { static const float t[20] = {0, 1, 4, 9, 16, 25, 36, 49, "
        "64, 81, 100, 121, 144, 169, 196, 225, 256, 289, 324, 361};\n"
        "int k = (int)floor(q.x + 6); return lerp(t[k], t[k + 1], q.x + 6 - k) * q.z; }");
    const Gradient own("", "gradient(f, p)",
                       "float f(float3 q) { float t[10]; for (int i = 0; i < 10; ++i) "
                       "t[i] = i * q.x * q.y; return t[(int)floor(q.z + 5)]; }");
    for (const Vec& p : places(100)) {
        const double k = std::floor(p[0] + 6), f = p[0] + 6 - k, slope = 2 * k + 1;
        expect_near(squares(p), {slope * p[2], 0, k * k + f * slope}, 1e-4, p);
        const double element = std::floor(p[2] + 5);
        expect_near(own(p), {element * p[1], element * p[0], 0}, 1e-4, p);
    }
}

/// A loop that is not unrolled, but whose result does not depend on the point, counts as constant.
TEST(Gradients, TakeWhatOtherLoopsGiveAsConstant) {
    const Gradient found("", "gradient(f, p, t)",
                         "float f(float3 q, float t) { float s = t; int n = 0;\n"
                         "while (s > 1 && n < 300) { s *= 0.5; ++n; } return s * q.x; }");
    const LibraryFunction& x = found.parts[0];
    EXPECT_EQ(x({1, 2, 3}, 6), 0.75);
}

TEST(Gradients, OfGradients) {
    const LibraryFunction second("", "return gradient(slope, p.x);",
                                 "float f(float x) { return x * x * x; }\n"
                                 "float slope(float x) { return gradient(f, x); }");
    EXPECT_NEAR(second({2, 0, 0}), 12, 1e-5);
}

TEST(Curvatures, AreClosedForms) {
    const LibraryFunction ball = LibraryFunction::of("solids", "mean_curvature(solid_ball, p, 1)");
    // Of a cylinder half as much as of a ball; of a torus 1 / tube and what its ring adds.
    const LibraryFunction cylinder =
        LibraryFunction::of("solids", "mean_curvature(solid_cylinder, p, 2, 90)");
    const LibraryFunction torus =
        LibraryFunction::of("solids", "mean_curvature(solid_torus, p, 6, 1)");
    const LibraryFunction circle("", "return mean_curvature(f, p.xy);",
                                 "float f(float2 q) { return length(q) - 1; }");
    const LibraryFunction tube("", "return mean_curvature(f, p);",
                               "float f(float3 q) { return dot(q.xy, q.xy); }");
    for (const Vec& p : places(200)) {
        const double r = std::hypot(p[0], p[1], p[2]), across = std::hypot(p[0], p[1]);
        if (across < 0.3) continue;
        EXPECT_NEAR(cylinder(p), 0.5 / across, 1e-5 / across) << across;
        EXPECT_NEAR(ball(p), 1 / r, 1e-5 / r) << r;
        EXPECT_NEAR(circle(p), 1 / across, 1e-5 / across) << across;
        EXPECT_NEAR(tube(p), 0.5 / across, 1e-5 / across) << across;
        const double from_ring = std::hypot(across - 6, p[2]);
        if (from_ring < 0.3) continue;
        const double exact = 0.5 / from_ring + 0.5 * (across - 6) / (from_ring * across);
        EXPECT_NEAR(torus(p), exact, 2e-5 / from_ring);
    }
}

TEST(Curvatures, OfNoiseAreByDifferences) {
    const LibraryFunction found("", "return gradient(slope, p.x);",
                                "float f(float x) { return noise(x, 3u); }\n"
                                "float slope(float x) { return gradient(f, x); }");
    const LibraryFunction slope("", "return gradient(f, p.x);",
                                "float f(float x) { return noise(x, 3u); }");
    double worst = 0;
    for (const Vec& p : places(300)) {
        const double step = 1e-2, x = p[0];
        if (std::floor(x - 0.05) != std::floor(x + 0.05)) continue;
        const double exact = (slope({x + step, 0, 0}) - slope({x - step, 0, 0})) / (2 * step);
        worst = std::max(worst, std::abs(found({x, 0, 0}) - exact));
    }
    // OPENFL.md states it.
    EXPECT_LT(worst, 0.03);
}

/// Calls of the table of costs, `f(p, …)`, as fields: against differences that agree with each other.
TEST(Gradients, OfTheLibraryAreDifferences) {
    const std::string file = source_dir() / "stdlib/costs.json";
    const Result<std::string> text = read_text_file(file, 1'000'000);
    ASSERT_TRUE(text);
    const Result<JsonValue> table = parse_json(*text, file);
    ASSERT_TRUE(table);
    size_t functions = 0;
    for (const JsonValue& row : member_of(*table, "functions")->items) {
        const JsonValue* given = member_of(row, "call");
        const std::string signature = member_of(row, "function")->text;
        const std::string module = member_of(row, "module")->text;
        if (given == nullptr || !signature.starts_with("float ") || module == "voronoi") continue;
        // These cut their intervals off by bits: refused.
        const bool by_bits =
            module == "lattice" && signature.find("_distance(") != std::string::npos;
        if (by_bits && given->text.find("gyroid") == std::string::npos) continue;
        if (by_bits && given->text.find("float3") != std::string::npos) continue;
        const size_t open = given->text.find("(p, ");
        if (signature.find("(float3, ") == std::string::npos || open == std::string::npos ||
            given->text.substr(0, open).find('(') != std::string::npos ||
            given->text.find("HOOK") != std::string::npos)
            continue;
        SCOPED_TRACE(given->text);
        const std::string call =
            "gradient(" + given->text.substr(0, open) + ", p, " + given->text.substr(open + 4);
        const Gradient found(module, call);
        const LibraryFunction f = LibraryFunction::of(module, given->text);
        int compared = 0, wrong = 0;
        for (const Vec& p : places(60, 8)) {
            const Vec exact = found(p);
            const double value = f(p);
            for (size_t axis = 0; axis < 3; ++axis) {
                constexpr double kStep = 4e-3;
                Vec before = p, after = p;
                before[axis] -= kStep;
                after[axis] += kStep;
                const double left = (value - f(before)) / kStep, right = (f(after) - value) / kStep;
                const double scale = 1 + std::abs(left) + std::abs(right);
                // Not at edges, where these differ.
                if (!(std::abs(left - right) < 0.02 * scale)) continue;
                ++compared;
                wrong += std::abs(exact[axis] - (left + right) / 2) < 0.02 * scale ? 0 : 1;
            }
        }
        // Where a random cell ends, and differences on both sides happen to be alike.
        EXPECT_LE(wrong, compared / 100) << "of " << compared;
        ++functions;
    }
    EXPECT_GT(functions, 60U);
}

}  // namespace
}  // namespace openfab::testing
