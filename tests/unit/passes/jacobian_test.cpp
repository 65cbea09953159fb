// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_jacobian.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/derivatives/double_inputs.h"
#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

constexpr const char* kUniforms =
    "@uniform { float u = 0.7; float3 v = float3(0.3, -0.4, 0.9); float a[6] = {1, 2, 0.5, 0.25, "
    "3, 4};"
    " float2x2 m = float2x2(1, 0.5, -0.25, 2); int n = 3; Material m0, m1; }\n";
constexpr int kFloats = 1 + 3 + 6 + 4;

/// A fablet with the amount 3 + f of one material and 5 of the other.
ir::Fablet fablet_of(const std::string& body, const std::string& before = "") {
    return compile("fablet A { " + std::string(kUniforms) + before + "float f(float3 p) {" + body +
                   "}\n@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;"
                   " mc.Set(m0, 3 + f(attr.voxelCenter)); mc.Set(m1, 5.0); return mc; } }");
}

/// Voxel centres are the coordinates themselves.
DoubleInputs inputs_at(const ir::Fablet& fablet, const std::array<double, 3>& p) {
    DoubleInputs out;
    out.set_defaults(fablet);
    for (int32_t k = 0; k < 3; ++k) {
        out.numbers[{OPENFAB_ARG_FRAME, 4 * k, 0}] = 1;  // the steps' diagonal
        out.numbers[{ir::kVoxelCoord, k, 0}] = p[static_cast<size_t>(k)];
    }
    return out;
}

std::vector<passes::Direction> all_directions() {
    std::vector<passes::Direction> out;
    for (int32_t k = 0; k < kFloats; ++k)
        out.push_back({{{k, -1}}});
    return out;
}

class Body : public ::testing::TestWithParam<const char*> {};

TEST_P(Body, HasTheDerivativesOfCentralDifferences) {
    const ir::Fablet fablet = fablet_of(GetParam());
    const passes::Jacobian jacobian = passes::form_jacobian(fablet, all_directions());
    ASSERT_TRUE(jacobian.none.empty()) << jacobian.none[0].what;
    ASSERT_EQ(ir::verify(jacobian.stage), "");
    double most = 0;
    for (const std::array<double, 3>& p :
         {std::array{0.31, 0.42, -0.23}, {1.37, -2.21, 0.65}, {-0.83, 0.12, 2.57}}) {
        const DoubleInputs inputs = inputs_at(fablet, p);
        const std::vector<double> got = interp::evaluate_double(jacobian.stage, inputs);
        const std::vector<double> amounts = interp::evaluate_double(fablet.volume, inputs);
        // Signs of noises that are expanded change through the bits of a float.
        EXPECT_NEAR(got[0], amounts[0], 1e-6 * std::fabs(amounts[0]));
        for (int32_t k = 0; k < kFloats; ++k) {
            const auto expected = differences(fablet.volume, inputs, k);
            ASSERT_TRUE(expected.has_value()) << "value " << k;
            for (size_t slot = 0; slot < 2; ++slot) {
                const double other = (*expected)[slot];
                most = std::max(most, std::fabs(other));
                EXPECT_NEAR(got[2 + 2 * static_cast<size_t>(k) + slot], other,
                            1e-6 * std::max(std::fabs(other), 1e-3))
                    << "value " << k << " at " << p[0];
            }
        }
    }
    EXPECT_GT(most, 1e-3) << "nothing changes";
}

INSTANTIATE_TEST_SUITE_P(
    All, Body,
    ::testing::Values(
        "return u * p.x - p.y / u;", "return fmod(7 * u, 0.6) - u;",
        "return min(u * p.x, 0.2) + max(u, p.y);", "return abs(u * p.x - 0.3);",
        "return sqrt(u + p.x * p.x);", "return length(p - v);", "return p.x > 0 ? u * u : exp(-u);",
        "return sin(u * p.x) + cos(u) + tan(u);", "return asin(u) * acos(u / 2) + atan(u * p.y);",
        "return atan2(u, p.x) + atan2(p.y, u);", "return sinh(u) + cosh(u * p.x) + tanh(u);",
        "return exp(u) + exp2(u * p.x) + cbrt(u * p.y);",
        "return log(u) + log2(u + 3) + log10(u * 2);",
        "return pow(u, 2.5) + pow(2.0, u) + pow(u, u);",
        "return pow(max(p.x * u, 0.0), 0.5) + acos(clamp(3 * p.x + u, -1.0, 1.0));",
        "return noise(p * u) + noise(p.xy + v.xy) + noise(u * p.x);",
        "return noise(float4(p, u)) + pnoise(p * u, int3(3, 4, 5)) + pnoise_gradient(p * u, "
        "int3(3, 4, 5)).y;",
        "return simplex(p * u) + simplex(p.xy * u) + simplex(float4(p, u));",
        "return dot(noise_gradient(p * u), v);", "return length(simplex_gradient(p * u + v));",
        "return cellular(p * u).x - cellular(p.xy + v.xy).y;",
        "return smoothstep(-1.0, v.z, u * p.x);",
        "return lerp(v.x, v.y, saturate(0.2 + 0.1 * u * p.z)) + dot(mul(m, p.xy), float2(1, u));",
        "return a[int(abs(p.x) * 3.1)] * u + a[n];",
        "float s = 0; for (int i = 0; i < 4; ++i) s += a[i] * pow(u, float(i)); return s;",
        "float s = u; int i = 0; @bound(9) while (i < int(3 + 2 * abs(p.x))) { s = s * 0.5 + sin(s "
        "* p.y); i++; } return s;",
        "float s = u; float t = 1; @bound(12) while (abs(t) > 0.01) { t = t * 0.3 * u; s += t; } "
        "return s;",
        "float b[3] = {u, p.x, v.y}; b[int(abs(p.y) * 2.9)] = u * u; return b[0] * b[1] + b[2];"));

TEST(Jacobian, OfShapesAndQueries) {
    // A ball of radius u that is asked at the voxel and beside it.
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { float u = 7; float s = 0.3; Material m0, m1; }\n"
        "@Shape(@varying { ShapeAttributes attr }) { return (length(attr.p) - u) * 2; }\n"
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;"
        " mc.Set(m0, 20 + distance(attr.voxelCenter)); "
        " mc.Set(m1, 20 + distance(attr.voxelCenter * (1 + s))); return mc; } }");
    const passes::Jacobian jacobian =
        passes::form_jacobian(fablet, std::vector<passes::Direction>{{{{0, -1}}}, {{{1, -1}}}});
    ASSERT_TRUE(jacobian.none.empty()) << jacobian.none[0].what;
    ASSERT_EQ(ir::verify(jacobian.stage), "");
    const std::array p = {2.0, 3.0, -4.0};
    DoubleInputs inputs = inputs_at(fablet, p);
    for (int32_t axis = 0; axis < 3; ++axis)
        inputs.numbers[{OPENFAB_ARG_FRAME, OPENFAB_FRAME_SHAPE_SHRINK + axis, 0}] = 1;
    double u = 7;
    inputs.surface = [&](int32_t kind, int32_t axis, std::span<const double, 3> at) {
        const double radius = std::hypot(at[0], at[1], at[2]);
        if (kind == OPENFAB_QUERY_DISTANCE) return radius - u;
        const double unit = at[static_cast<size_t>(axis)] / radius;
        return kind == OPENFAB_QUERY_NORMAL ? unit : u * unit;
    };
    const double radius = std::hypot(p[0], p[1], p[2]);
    inputs.numbers[{OPENFAB_ARG_DISTANCE, 0, 0}] = radius - u;
    const std::vector<double> got = interp::evaluate_double(jacobian.stage, inputs);
    // The closed form.
    const auto share = [&](double of_u, double of_s) {
        const double a = 20 + radius - of_u, b = 20 + radius * (1 + of_s) - of_u;
        return a / (a + b);
    };
    const double h = 1e-5;
    EXPECT_NEAR(got[2], (share(u + h, 0.3) - share(u - h, 0.3)) / (2 * h), 1e-8);
    EXPECT_NEAR(got[4], (share(u, 0.3 + h) - share(u, 0.3 - h)) / (2 * h), 1e-8);
    EXPECT_NEAR(got[3], -got[2], 1e-12);
}

/// Returns what has no derivative, as text.
std::string refused(const std::string& text) {
    const ir::Fablet fablet = compile(text);
    const passes::Jacobian jacobian =
        passes::form_jacobian(fablet, std::vector<passes::Direction>{{{{0, -1}}}});
    std::string out;
    for (const passes::NoDerivative& none : jacobian.none)
        out += none.what + "\n";
    EXPECT_EQ(out.empty(), !jacobian.stage.outputs.empty());
    return out;
}

TEST(Jacobian, RefusesByName) {
    const std::string volume =
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; ";
    const std::string uniforms =
        "fablet A { @uniform { float u = 2; ImageTexture2D t; Material m; }\n";
    EXPECT_EQ(refused(uniforms + volume +
                      "mc.Set(m, t.Sample1(attr.voxelCenter.x * u, 0.5, 0)); return mc; } }"),
              "a texture lookup whose place depends on it\n");
    EXPECT_EQ(refused(uniforms + volume +
                      "mc.Set(m, u * t.Sample1(attr.voxelCenter.x, 0.5, 0)); return mc; } }"),
              "");
    EXPECT_EQ(refused(uniforms +
                      "@Surface(@varying { SurfaceAttributes attr }) { return attr.n * u; }\n" +
                      volume + "mc.Set(m, distance(attr.voxelCenter)); return mc; } }"),
              "the displacement of its surface\n");
    for (const char* of :
         {"asfloat(asuint(u))", "hash(u * attr.voxelCenter.x)", "asfloat(asuint(u) ^ 1u) + u"}) {
        EXPECT_EQ(refused(uniforms + volume + "mc.Set(m, " + of + "); return mc; } }"),
                  "the bits of a number that depends on it\n")
            << of;
    }
    EXPECT_EQ(refused(uniforms + volume +
                      "mc.Set(m, u * hash(floor(u * attr.voxelCenter))); return mc; } }"),
              "");
    for (const char* place : {"attr.voxelCenter * u, 0.1", "attr.voxelCenter, u"}) {
        EXPECT_EQ(
            refused(uniforms + volume + "mc.Set(m, walk_end(" + place + ", 1).x); return mc; } }"),
            "where a random walk ends\n")
            << place;
    }
    EXPECT_EQ(refused(uniforms + volume +
                      "mc.Set(m, u * walk_end(attr.voxelCenter, 0.1, 1).x); return mc; } }"),
              "");
}

/// The share of m0, 20 + d to 20, where d is the distance to a shape in a box that is asked at the voxel.
ir::Fablet with_distance(const std::string& of_shape, const std::string& shape) {
    return compile(
        "fablet A { @uniform { float u = 2; Material m0, m1; }\n"
        "@Shape(@varying { ShapeAttributes attr }) " +
        of_shape + "{ float3 p = attr.p; " + shape +
        " }\n"
        "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;"
        " mc.Set(m0, 20 + distance(attr.voxelCenter)); mc.Set(m1, 20); return mc; } }");
}

/// Returns the change of the distance by u at a point, of a part with these frame values.
double change_of_distance(const ir::Fablet& fablet, const std::array<double, 3>& p, double distance,
                          const std::array<double, 3>& nearest,
                          const std::array<double, 4>& frame) {
    const passes::Jacobian jacobian =
        passes::form_jacobian(fablet, std::vector<passes::Direction>{{{{0, -1}}}});
    EXPECT_TRUE(jacobian.none.empty());
    EXPECT_EQ(ir::verify(jacobian.stage), "");
    DoubleInputs inputs = inputs_at(fablet, p);
    for (int32_t k = 0; k < 4; ++k)
        inputs.numbers[{OPENFAB_ARG_FRAME, OPENFAB_FRAME_SHAPE_SHRINK + k, 0}] =
            frame[static_cast<size_t>(k)];
    inputs.numbers[{OPENFAB_ARG_DISTANCE, 0, 0}] = distance;
    inputs.surface = [&](int32_t kind, int32_t axis, std::span<const double, 3> at) {
        const auto k = static_cast<size_t>(axis);
        if (kind == OPENFAB_QUERY_DISTANCE) return distance;
        return kind == OPENFAB_QUERY_NORMAL ? (at[k] - nearest[k]) / distance : nearest[k];
    };
    const std::vector<double> got = interp::evaluate_double(jacobian.stage, inputs);
    // Of a / (a + 20), where a is 20 + d.
    return got[2] * std::pow(40 + distance, 2) / 20;
}

constexpr const char* kBox =
    "float3 q = abs(p) - u; return length(max(q, 0)) + min(max(q.x, max(q.y, q.z)), 0);";

TEST(Jacobian, OfFacesWhoseFormulaHasAnEdgeOnTheSurface) {
    // A cube of half side u, asked in its inside: its faces come nearer by as much as u shrinks.
    const std::array p = {1.5, 0.25, -0.5};
    for (const char* declared : {"", "[[ distance ]] "}) {
        const double one = *declared != 0 ? 1 : 0;
        EXPECT_NEAR(change_of_distance(with_distance(declared, kBox), p, -0.5, {2, 0.25, -0.5},
                                       {1, 1, 1, one}),
                    -1, 1e-6)
            << declared;
    }
}

TEST(Jacobian, OfShapesThatAreScaled) {
    // A ball of radius u around 0, three times as large: its surface moves three times as far.
    const std::array p = {1.0, 2.0, -2.0};
    const std::array nearest = {2.0, 4.0, -4.0};
    const std::string ball = "return length(p) - u;";
    EXPECT_NEAR(
        change_of_distance(with_distance("", ball), p, -3, nearest, {1. / 3, 1. / 3, 1. / 3, 0}),
        -3, 1e-6);
    EXPECT_NEAR(change_of_distance(with_distance("[[ distance ]] ", ball), p, -3, nearest,
                                   {1. / 3, 1. / 3, 1. / 3, 3}),
                -3, 1e-6);
    // Three times as long along x alone, asked on the x axis; the declared distance holds no more.
    for (const char* declared : {"", "[[ distance ]] "})
        EXPECT_NEAR(change_of_distance(with_distance(declared, ball), {5, 0, 0}, -1, {6, 0, 0},
                                       {1. / 3, 1, 1, 0}),
                    -3, 1e-3)
            << declared;
}

TEST(Jacobian, OfAShapesFabletOnAnotherGeometry) {
    for (const char* declared : {"", "[[ distance ]] "})
        EXPECT_EQ(change_of_distance(with_distance(declared, "return length(p) - u;"), {1, 0, 0},
                                     -1, {2, 0, 0}, {0, 0, 0, 0}),
                  0)
            << declared;
}

}  // namespace
}  // namespace openfab::testing
