// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Streamlines in volumes of fields that are linear, and so the same between texels: circles, hyperbolas, straight
// lines.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"
#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

constexpr int32_t kSide = 9;
constexpr double kHalf = 9;  ///< mm from the middle to the sides: texels of 2 mm
constexpr int32_t kClamp = 0, kBlack = 3, kFinest = 3;

/// A cube about the origin whose texels hold a field at their centres.
class FieldVolume : public PointEnvironment {
  public:
    FieldVolume(const std::function<Vec(Vec)>& field, int32_t wrap)
        : info_{3, 1, wrap, kFinest, 1, wrap, 0, 0} {
        const auto place = [](int32_t k) { return (k + 0.5) * 2 - kHalf; };
        for (int32_t z = 0; z < kSide; ++z) {
            for (int32_t y = 0; y < kSide; ++y) {
                for (int32_t x = 0; x < kSide; ++x) {
                    for (const double part : field({place(x), place(y), place(z)}))
                        texels_.push_back(static_cast<float>(part));
                }
            }
        }
        for (const double number : {-kHalf, -kHalf, -kHalf, 2 * kHalf, 2 * kHalf, 2 * kHalf})
            info_.push_back(std::bit_cast<int32_t>(static_cast<float>(number)));
        info_.insert(info_.end(), {0, kSide, kSide, kSide, 0});
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {texels_, info_}; }

  private:
    std::vector<float> texels_;
    std::vector<int32_t> info_;
};

/// An expression of p, t and the volume `field`.
class Of {
  public:
    explicit Of(const std::string& expression) {
        const std::string text =
            "import streams;\nfablet T { @uniform { float3 p; float t; Material m; ImageTexture3D "
            "field; }\n"
            "float f() { return " +
            expression +
            "; }\n@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }\n";
        source::SourceManager sources;
        diag::Sink sink;
        const auto module = frontend::compile_to_ir(sources, sources.add("test.fl", text), sink);
        EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources);
        if (module) stage_ = module->fablets[0].volume;
    }
    double operator()(FieldVolume& field, const Vec& p, double t = 0) const {
        if (!stage_) return std::numeric_limits<double>::quiet_NaN();
        for (size_t axis = 0; axis < 3; ++axis)
            field.values[axis] = static_cast<float>(p[axis]);
        field.values[3] = static_cast<float>(t);
        return static_cast<double>(std::bit_cast<float>(interp::evaluate(*stage_, field)[0]));
    }

  private:
    std::optional<ir::Stage> stage_;
};

Vec around_z(Vec p) {
    return {-p[1], p[0], 0};
}
Vec saddle(Vec p) {
    return {p[0], -p[1], 0};
}
/// Towards +x, 1e-9 strong.
Vec straight(Vec) {
    return {1e-9, 0, 0};
}

TEST(Streams, GoAroundInCircles) {
    FieldVolume field(around_z, kClamp);
    const Of x("stream_trace(field, p, 0.1, t).at.x"), y("stream_trace(field, p, 0.1, t).at.y");
    const Of back("stream_trace(field, p, -0.1, t).at.y");
    const Of length("stream_trace(field, p, 0.1, t).length");
    for (const double turn : {0.3, 1.7, 3.0, 6.28}) {
        // Of the angle 1e-3 / 6 a step.
        EXPECT_NEAR(x(field, {2, 0, 1}, 2 * turn), 2 * std::cos(turn), 1e-3 * (1 + turn)) << turn;
        EXPECT_NEAR(y(field, {2, 0, 1}, 2 * turn), 2 * std::sin(turn), 1e-3 * (1 + turn)) << turn;
        EXPECT_NEAR(back(field, {2, 0, 1}, 2 * turn), -2 * std::sin(turn), 1e-3 * (1 + turn));
        EXPECT_NEAR(length(field, {2, 0, 1}, 2 * turn), 2 * turn, 1e-5);
    }
    const Of radius("length(stream_trace(field, p, 0.1, t).at.xy)");
    EXPECT_NEAR(radius(field, {2, 0, 1}, 2 * 6.2831853), 2, 2 * 5.5e-5);
}

TEST(Streams, KeepTheProductOfASaddle) {
    FieldVolume field(saddle, kClamp);
    const Of product("stream_trace(field, p, 0.05, t).at.x * stream_trace(field, p, 0.05, t).at.y");
    EXPECT_NEAR(product(field, {0.5, 5, 0}, 7), 2.5, 2e-3);
    EXPECT_NEAR(product(field, {-2, 3, 0}, 4), -6, 2e-3);
}

TEST(Streams, EndWhereTheFieldDoes) {
    FieldVolume field(straight, kBlack);
    const Of length("stream_length(field, p, 0.1, 100)");
    const Of forth("stream_trace(field, p, 0.25, 100).length");
    const Of ended("stream_trace(field, p, 0.25, t).ended ? 1 : 0");
    // The volume fades to 0 over a texel at its sides; a step may begin half of one before.
    EXPECT_NEAR(length(field, {3, 1, 2}), 20, 0.25);
    EXPECT_NEAR(forth(field, {3, 1, 2}), 7, 0.3);
    EXPECT_EQ(ended(field, {3, 1, 2}, 100), 1);
    EXPECT_EQ(ended(field, {3, 1, 2}, 2), 0);
    EXPECT_EQ(forth(field, {30, 1, 2}), 0);
    // Steps that are 0 end, too.
    EXPECT_LT(Of("stream_trace(field, p, 0, 100).length")(field, {3, 1, 2}), 1);
    FieldVolume none([](Vec) { return Vec{0, 0, 0}; }, kClamp);
    EXPECT_EQ(length(none, {3, 1, 2}), 0);
}

TEST(Streams, AreCutOffAtAPlane) {
    FieldVolume field(around_z, kClamp);
    const std::string call = "stream_to_plane(field, p, 0, float3(0, 1, 0), -0.1, 50)";
    const Of length(call + ".length"), x(call + ".at.x"), ended(call + ".ended ? 1 : 0");
    // Back from a place at an angle to the axis of x.
    for (const double turn : {0.4, 1.0, 2.5}) {
        const Vec p = {3 * std::cos(turn), 3 * std::sin(turn), 1};
        EXPECT_NEAR(length(field, p), 3 * turn, 2e-3);
        EXPECT_NEAR(x(field, p), 3, 2e-3);
        EXPECT_EQ(ended(field, p), 0);
    }
    EXPECT_EQ(
        Of("stream_to_plane(field, p, float3(0, 8, 0), float3(0, 1, 0), 0.1, 50).ended ? 1 : 0")(
            field, {3, 0, 0}),
        1);
}

/// The nearest of all lines' dense points, which are circles about z.
TEST(Streams, TellTheNearestOfManyLines) {
    FieldVolume field(around_z, kClamp);
    const std::string call =
        "stream_nearest(field, p, float3(0.5, 0, 0), float3(1, 0, 0), float3(0, 0, 1.5), 0.1, 60)";
    const Of distance(call + ".distance"), along(call + ".along"), i(call + ".number.x"),
        j(call + ".number.y");
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-5, 5);
    int compared = 0;
    for (int k = 0; k < 60; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        const double radius = std::hypot(p[0], p[1]);
        double turn = std::atan2(p[1], p[0]);
        if (turn < 0) turn += 6.283185307;
        // Beyond half a turn lines cross the plane again, on the other side.
        if (radius < 1.2 || turn < 0.05 || turn > 3.09) continue;
        const double ring = std::round(radius - 0.5) + 0.5, level = 1.5 * std::round(p[2] / 1.5);
        // Not half way between two.
        if (std::abs(std::abs(radius - ring) - 0.5) < 0.02) continue;
        if (std::abs(std::abs(p[2] - level) - 0.75) < 0.02) continue;
        EXPECT_NEAR(distance(field, p), std::hypot(radius - ring, p[2] - level), 4e-3);
        EXPECT_NEAR(along(field, p), ring * turn, 0.02);
        EXPECT_EQ(i(field, p), ring - 0.5);
        EXPECT_EQ(j(field, p), std::round(p[2] / 1.5));
        ++compared;
    }
    EXPECT_GT(compared, 15);
    FieldVolume none([](Vec) { return Vec{0, 0, 0}; }, kClamp);
    EXPECT_EQ(distance(none, {3, 1, 2}), 60);
}

}  // namespace
}  // namespace openfab::testing
