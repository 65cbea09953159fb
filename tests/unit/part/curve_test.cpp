// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Curves: what their tables hold, and what a fablet's lookup finds in them.
#include "runtime/part/curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "abi/curve_table.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"
#include "runtime/part/messages.h"

namespace openfab::part {
namespace {

using Interpolation = world::Curve::Interpolation;

/// Uniforms: x, then the table.
class Values : public interp::Environment {
  public:
    std::vector<float> values;
    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        return kind == OPENFAB_ARG_UNIFORM
                   ? std::bit_cast<uint32_t>(values.at(static_cast<size_t>(a)))
                   : 0;
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
};

/// A fablet's lookup in a curve, by the interpreter.
class Lookup {
  public:
    Lookup(const std::string& type, const std::string& expression, const world::Curve& curve)
        : table_(curve_table(curve, type == "Spline" ? 1 : 3)) {
        const std::string text =
            "fablet T { @uniform { float x; " + type + " c; Material m; }\nfloat of(" + type +
            " given, float t) { return " + expression +
            "; }\n@Volume() { MaterialComposition mc; mc.Set(m, of(c, x)); return mc; } }";
        source::SourceManager sources;
        diag::Sink sink;
        const auto module = frontend::compile_to_ir(sources, sources.add("test.fl", text), sink);
        EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources);
        if (module) stage_ = module->fablets[0].volume;
    }
    double operator()(double x) const {
        if (!stage_) return std::numeric_limits<double>::quiet_NaN();
        Values point;
        point.values = {static_cast<float>(x)};
        point.values.insert(point.values.end(), table_.begin(), table_.end());
        return static_cast<double>(std::bit_cast<float>(interp::evaluate(*stage_, point)[0]));
    }

  private:
    std::vector<float> table_;
    std::optional<ir::Stage> stage_;
};

const world::Curve kBumps = {{{0, 0.5}, {1, 0.25}, {3, 3}, {4.5, 3}, {7, 1}, {8, 1.5}},
                             Interpolation::kCubic};

TEST(Curves, CubicsAreThoseOfScipysPchipInterpolator) {
    const Lookup found("Spline", "given.At(t)", kBumps);
    const double exact[][2] = {{0, 0.5},           {0.3, 0.33575}, {0.9, 0.25025}, {1.7, 1.0248125},
                               {2.6, 2.714},       {3.7, 3},       {5, 2.792},     {6.5, 1.208},
                               {7.4, 1.092342857}, {8, 1.5}};
    for (const auto& [x, y] : exact)
        EXPECT_NEAR(found(x), y, 1e-6) << x;
}

TEST(Curves, LinesStepsAndEnds) {
    world::Curve curve = kBumps;
    curve.interpolation = Interpolation::kLinear;
    const Lookup line("Spline", "given.At(t)", curve);
    EXPECT_NEAR(line(0.5), 0.375, 1e-7);
    EXPECT_NEAR(line(2), 1.625, 1e-6);
    EXPECT_EQ(line(4), 3);
    curve.interpolation = Interpolation::kStep;
    const Lookup step("Spline", "given.At(t)", curve);
    EXPECT_EQ(step(0.999), 0.5);
    EXPECT_EQ(step(1), 0.25);
    EXPECT_EQ(step(7.999), 1);
    EXPECT_EQ(step(8), 1.5);
    for (const Lookup* one : {&line, &step}) {
        EXPECT_EQ((*one)(-1e30), 0.5);
        EXPECT_EQ((*one)(1e30), 1.5);
        EXPECT_EQ((*one)(std::numeric_limits<double>::quiet_NaN()), 0.5);
    }
    // One key, and as many as there may be.
    EXPECT_EQ(Lookup("Spline", "given.At(t)", {{{3, 0.75}}, {}})(-4), 0.75);
    world::Curve full{{}, Interpolation::kLinear};
    for (int k = 0; k < abi::kCurveKeys; ++k)
        full.keys.push_back({k * 0.5, k * k * 0.25});
    EXPECT_NEAR(Lookup("Spline", "given.At(t)", full)(7.25), 52.625, 1e-4);
}

TEST(Curves, CubicsStayBetweenTheirKeysAndPassThroughThem) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int round = 0; round < 40; ++round) {
        world::Curve curve;
        double x = -10 * unit(random);
        const int keys = 2 + round % (abi::kCurveKeys - 1);
        for (int k = 0; k < keys; ++k) {
            curve.keys.push_back({x, round % 3 == 0 ? k * unit(random) : 4 * unit(random)});
            x += 0.01 + 3 * unit(random) * unit(random);
        }
        const Lookup found("Spline", "given.At(t)", curve);
        for (size_t k = 0; k + 1 < curve.keys.size(); ++k) {
            const auto &a = curve.keys[k], &b = curve.keys[k + 1];
            EXPECT_NEAR(found(static_cast<double>(static_cast<float>(a[0]))), a[1], 1e-6);
            double before = found(a[0]);
            for (int i = 1; i <= 20; ++i) {
                const double y = found(a[0] + (b[0] - a[0]) * i / 20);
                // In float.
                EXPECT_GE((y - before) * (b[1] - a[1]), -4e-6);
                EXPECT_GE(y, std::min(a[1], b[1]) - 4e-6);
                EXPECT_LE(y, std::max(a[1], b[1]) + 4e-6);
                before = y;
            }
        }
    }
}

TEST(Curves, RampsAreLinearByThemselvesAndHaveThreeChannels) {
    const world::Curve ramp{{{0, 1, 0, 0.5}, {2, 0, 0.5, 0.5}}, {}};
    EXPECT_NEAR(Lookup("ColorRamp", "given.At(t).r", ramp)(0.5), 0.75, 1e-6);
    EXPECT_NEAR(Lookup("ColorRamp", "given.At(t).g", ramp)(0.5), 0.125, 1e-6);
    EXPECT_EQ(Lookup("ColorRamp", "given.At(t).b", ramp)(0.5), 0.5);
}

TEST(Curves, HaveDerivatives) {
    const world::Curve curve{{{0, 0}, {1, 2}, {3, 3}}, Interpolation::kLinear};
    const std::string body =
        "slope(given, t); }\nfloat value(float x, Spline c) { return c.At(x); }\n"
        "float slope(Spline c, float x) { return gradient(value, x, c)";
    const Lookup found("Spline", body, curve);
    EXPECT_EQ(found(0.5), 2);
    EXPECT_EQ(found(2), 0.5);
    EXPECT_EQ(found(4), 0);
}

TEST(Curves, FaultsAreNamed) {
    EXPECT_EQ(curve_fault(kBumps, 1), "");
    EXPECT_EQ(curve_fault(kBumps, 3),
              fmt::format(messages::kCurveNumbers, 2, 0, 4, messages::kCurveKeyColor));
    EXPECT_EQ(curve_fault({{{0}}, {}}, 1),
              fmt::format(messages::kCurveNumbers, 1, 0, 2, messages::kCurveKeyValue));
    EXPECT_EQ(curve_fault({{}, {}}, 1), fmt::format(messages::kCurveKeys, 0, 16));
    EXPECT_EQ(curve_fault({std::vector<std::vector<double>>(17, {0, 0}), {}}, 1),
              fmt::format(messages::kCurveKeys, 17, 16));
    EXPECT_EQ(curve_fault({{{0, 1}, {2, 1}, {2, 3}}, {}}, 1),
              fmt::format(messages::kCurveOrder, 2, 2.0, 2.0));
    for (const double outside : {1e10, std::nan("")})
        EXPECT_EQ(curve_fault({{{0, outside}}, {}}, 1),
                  fmt::format(messages::kCurveBeyond, outside, 0));
}

}  // namespace
}  // namespace openfab::part
