// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Derivatives of fractions by the keys of curves, against differences of curves whose keys are moved.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compiler/diag/render.h"
#include "compiler/driver/derivatives.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate_double.h"
#include "runtime/part/curve.h"
#include "tests/support/derivatives/double_inputs.h"

namespace openfab::testing {
namespace {

using Interpolation = world::Curve::Interpolation;

/// The share of `one` is that of a curve at x, that of `other` 1 less it.
constexpr const char* kGraded =
    "fablet Graded { @uniform { float x = 0; Spline s; ColorRamp r; Material one, other; }\n"
    "@Volume() { MaterialComposition mc; float share = s.At(x) + dot(r.At(x), float3(0.2, 0.1, "
    "0.3)); mc.Set(one, share); mc.Set(other, 8 - share); return mc; } }";
constexpr double kAmount = 8;

class Graded {
  public:
    explicit Graded(const std::vector<std::string>& asked) {
        source::SourceManager sources;
        diag::Sink sink;
        auto module = frontend::compile_to_ir(sources, sources.add("test.fl", kGraded), sink);
        EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources);
        plain_ = module->fablets[0];
        moving_ = plain_;
        fine_ = driver::differentiate(asked, &moving_, &directions_, &sink);
        said_ = diag::render_text(sink, sources);
    }

    bool fine() const { return fine_; }
    const std::string& said() const { return said_; }
    const std::vector<int32_t>& directions() const { return directions_; }

    /// Puts curves in their places, as a print does.
    void bind(const world::Curve& spline, const world::Curve& ramp) {
        for (const ir::Uniform& u : moving_.uniforms) {
            const world::Curve& curve = u.name[0] == 's' ? spline : ramp;
            const int32_t channels = u.name[0] == 's' ? 1 : 3;
            if (u.kind == OPENFAB_UNIFORM_CURVE)
                put(u.first_index, part::curve_table(curve, channels));
            if (u.kind != OPENFAB_UNIFORM_CURVE_CHANGE) continue;
            const auto key = static_cast<size_t>(std::stoi(u.name.substr(2)));
            for (int32_t c = 0; c < channels; ++c) {
                const std::vector<float> change = part::curve_change(curve, channels, key, c);
                put(u.first_index + c * static_cast<int32_t>(change.size()), change);
            }
        }
    }
    double share(double x) {
        inputs_.uniform(0) = x;
        return interp::evaluate_double(plain_.volume, inputs_)[0] / kAmount;
    }
    /// The change of the share in a direction.
    double change(double x, size_t direction) {
        inputs_.uniform(0) = x;
        return interp::evaluate_double(moving_.volume, inputs_)[2 + 2 * direction];
    }

  private:
    void put(int32_t first, const std::vector<float>& values) {
        for (const float value : values)
            inputs_.uniform(first++) = double{value};
    }

    ir::Fablet plain_, moving_;
    bool fine_ = false;
    std::string said_;
    std::vector<int32_t> directions_;
    DoubleInputs inputs_;
};

const world::Curve kSpline = {{{0, 0.5}, {1, 0.25}, {3, 3}, {4.5, 2}, {7, 1}, {8, 1.5}},
                              Interpolation::kCubic};
const world::Curve kRamp = {{{0, 1, 0, 0.5}, {2, 0, 0.5, 0.5}, {9, 0.3, 0.9, 0}}, {}};

TEST(CurveChanges, AreThoseOfCurvesWhoseKeysAreMoved) {
    Graded graded({"s[0]", "s[1]", "s[2]", "s[3]", "s[4]", "s[5]", "r[1]", "r[2]"});
    ASSERT_TRUE(graded.fine()) << graded.said();
    ASSERT_EQ(graded.directions().size(), 6U + 2 * 3);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.5, 9.5);
    for (const auto how : {Interpolation::kStep, Interpolation::kLinear, Interpolation::kCubic}) {
        world::Curve spline = kSpline;
        spline.interpolation = how;
        for (size_t k = 0; k < graded.directions().size(); ++k) {
            // Each a key and a channel.
            const bool of_ramp = k >= 6;
            const size_t key = of_ramp ? 1 + (k - 6) / 3 : k, channel = of_ramp ? (k - 6) % 3 : 0;
            double most = 0;
            for (int n = 0; n < 60; ++n) {
                const double x = place(random);
                // Tables are of floats, and cubics bend: neither is seen at this width.
                constexpr double kStep = 1.0 / 512;
                double shares[2];
                for (const int side : {0, 1}) {
                    world::Curve curves[] = {spline, kRamp};
                    curves[of_ramp ? 1 : 0].keys[key][1 + channel] += (2 * side - 1) * kStep;
                    graded.bind(curves[0], curves[1]);
                    shares[side] = graded.share(x);
                }
                graded.bind(spline, kRamp);
                const double expected = (shares[1] - shares[0]) / (2 * kStep);
                EXPECT_NEAR(graded.change(x, k), expected, 4e-5)
                    << "direction " << k << ", interpolation " << static_cast<int>(how) << ", x "
                    << x;
                most = std::max(most, std::fabs(expected));
            }
            EXPECT_GT(most, 0.01) << "direction " << k;
        }
    }
}

TEST(CurveChanges, OfAConstantCurveAreHats) {
    // All values lie at both bounds of the curve's values.
    Graded graded({"s[1]"});
    ASSERT_TRUE(graded.fine()) << graded.said();
    graded.bind({{{0, 1}, {2, 1}, {6, 1}}, Interpolation::kLinear}, kRamp);
    EXPECT_NEAR(graded.change(1, 0), 0.5 / kAmount, 1e-6);
    EXPECT_NEAR(graded.change(2, 0), 1 / kAmount, 1e-6);
    EXPECT_NEAR(graded.change(5, 0), 0.25 / kAmount, 1e-6);
    EXPECT_EQ(graded.change(7, 0), 0);
}

TEST(CurveChanges, ACurveWithoutAKeyIsRefused) {
    const Graded graded({"s"});
    EXPECT_FALSE(graded.fine());
    EXPECT_NE(graded.said().find("`s[0]` is the value of its first"), std::string::npos)
        << graded.said();
}

}  // namespace
}  // namespace openfab::testing
