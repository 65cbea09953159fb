// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Current and heat through parts and cells against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "mechanics/cell/homogenise.h"
#include "mechanics/messages.h"
#include "mechanics/part/conduct.h"
#include "tests/support/says/says.h"

namespace openfab::mechanics {
namespace {

/// Solid elements, or void where the conductivity is below 0.
Voxels box(std::array<int32_t, 3> size, double pitch,
           const std::function<double(const Vec3&)>& of) {
    Voxels v;
    v.size = size;
    v.pitch_mm = {pitch, pitch, pitch};
    v.materials = {"stuff"};
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t x = 0; x < size[0]; ++x) {
                const double k = of({(x + 0.5) * pitch, (y + 0.5) * pitch, (z + 0.5) * pitch});
                const float solid = k < 0 ? 0.F : 1.F;
                v.solid.push_back(solid);
                v.lambda.push_back(0);
                v.mu.push_back(solid);
                v.strength.push_back(0);
                v.density.push_back(solid);
                v.conductivity.push_back(static_cast<float>(std::max(0.0, k)));
                v.code.push_back(k < 0 ? 0 : 1);
            }
    return v;
}

Result<LoadCase> case_of(const std::string& text) {
    return parse_load_case("{\"cases\": {\"one\": " + text + "}}", "test", "");
}

struct Conducts {
    ConductProblem problem;
    ConductSolution solution;
};
Conducts conducted(Voxels v, const std::string& text, std::span<const ObjectVoxels> objects = {}) {
    Conducts out;
    const Result<LoadCase> c = case_of(text);
    EXPECT_TRUE(c) << c.error().text();
    if (!c) return out;
    Result<ConductProblem> p = set_up_conduct(std::move(v), *c, objects);
    EXPECT_TRUE(p) << p.error().text();
    if (!p) return out;
    out.problem = std::move(*p);
    SolveOptions options;
    options.tolerance = 1e-9;
    out.solution = solve_conduct(&out.problem, c->held.size(), options);
    EXPECT_TRUE(out.solution.report.converged);
    return out;
}
std::string refused(const std::string& text) {
    const Result<LoadCase> c = case_of(text);
    return c ? std::string() : c.error().text();
}

constexpr const char* kAcross =
    R"({"held": [{"side": "-x", "volt": 1}, {"side": "+x", "volt": 6}]})";

// Current, and heat alike.
TEST(MechanicsConduct, WithoutAPathNothingFlows) {
    const auto said = [](Voxels v, const std::string& text) {
        const Result<LoadCase> c = case_of(text);
        EXPECT_TRUE(c);
        Result<ConductProblem> p = set_up_conduct(std::move(v), *c, {});
        return p ? std::pair(std::string(), p->notes)
                 : std::pair(p.error().text(), std::vector<std::string>());
    };
    // A gap of void or of an insulator, and halves that share an edge alone.
    for (const double gap : {-1.0, 1e-12})
        EXPECT_THAT(said(box({12, 4, 4}, 1,
                             [gap](const Vec3& p) { return std::abs(p[0] - 6) < 1 ? gap : 50; }),
                         kAcross)
                        .first,
                    testing::Says(messages::kNoPath, "one"));
    EXPECT_THAT(said(box({12, 4, 4}, 1,
                         [](const Vec3& p) { return (p[0] < 6) == (p[1] < 2) ? 50.0 : -1.0; }),
                     R"({"held": [{"side": "-x", "celsius": 1}, {"side": "+x", "celsius": 6}]})")
                    .first,
                testing::Says(messages::kNoPath, "one"));
    // Of three holds one is apart; what is joined to it alone carries nothing.
    const auto [error, notes] = said(
        box({12, 12, 4}, 1, [](const Vec3& p) { return std::abs(p[1] - 8) < 1 ? -1.0 : 50.0; }),
        R"({"held": [{"side": "-x", "box_mm": [[-1, 0, 0], [1, 7, 4]], "volt": 0},
                          {"side": "+x", "box_mm": [[11, 0, 0], [13, 7, 4]], "volt": 5},
                          {"side": "+y", "volt": 2}]})");
    EXPECT_EQ(error, "");
    EXPECT_THAT(notes, ::testing::ElementsAre(testing::Says(messages::kHoldApart),
                                              testing::Says(messages::kCarriesNothing, "144")));
}

/// By what flows in at the hold of 6 V, of 1 and 6.
double resistance_of(const Conducts& c) {
    return 5 / std::abs(c.solution.flow_in[1]);
}

// A gap that ends within elements leaves them a share, over which nothing jumps.
TEST(MechanicsConduct, GapsLessThanAnElementWideAreNotJumped) {
    const auto bar = [](int32_t begin, const std::vector<float>& shares) {
        Voxels v = box({20, 4, 4}, 0.5, [](const Vec3&) { return 2.0; });
        for (size_t e = 0; e < v.solid.size(); ++e) {
            const auto x = static_cast<int32_t>(e % 20);
            if (x < begin || x >= begin + static_cast<int32_t>(shares.size())) continue;
            const float share = shares[static_cast<size_t>(x - begin)];
            v.solid[e] = share;
            v.conductivity[e] *= share;
            v.mu[e] *= share;
        }
        return v;
    };
    const Result<LoadCase> across = case_of(kAcross);
    ASSERT_TRUE(across);
    for (const std::vector<float>& shares :
         {std::vector<float>{0.3F}, {0.4F, 0.4F}, {0.1F, 0.F}, {0.4F, 0.F, 0.3F}}) {
        const Result<ConductProblem> p = set_up_conduct(bar(9, shares), *across, {});
        ASSERT_FALSE(p) << shares.size();
        EXPECT_THAT(p.error().message, testing::Says(messages::kNoPath, "one"));
    }
    // One that is fuller is taken for a wall, and a skin that is less than half full adds its share.
    const double through = 1 / resistance_of(conducted(bar(9, {0.6F}), kAcross));
    EXPECT_LT(through, 1 / resistance_of(conducted(bar(9, {1.F}), kAcross)));
    Voxels skin = box({20, 4, 4}, 0.5, [](const Vec3&) { return 2.0; });
    for (size_t e = 0; e < skin.solid.size(); ++e) {
        if (e / 20 % 4 != 3) continue;
        skin.solid[e] = 0.3F;
        skin.conductivity[e] *= 0.3F;
    }
    const double whole =
        resistance_of(conducted(box({20, 4, 4}, 0.5, [](const Vec3&) { return 2.0; }), kAcross));
    EXPECT_NEAR(resistance_of(conducted(std::move(skin), kAcross)) / whole, 4 / 3.3,
                0.01);  // the skin is not held
}

TEST(MechanicsConduct, ABarIsItsLengthOverItsSection) {
    // 20 x 2 x 1.5 mm of 40 S/m: 20 mm / (40e-3 S/mm 3 mm2) ohm.
    const Conducts r = conducted(box({40, 4, 3}, 0.5, [](const Vec3&) { return 40.0; }), kAcross);
    const double ohm = 20 / (40e-3 * 3);
    EXPECT_NEAR(r.solution.flow_in[1] * ohm / 5, 1, 1e-6);
    EXPECT_NEAR(r.solution.flow_in[0] * ohm / 5, -1, 1e-6);
    EXPECT_NEAR(r.solution.power_W * ohm / 25, 1, 1e-6);
    for (const float d : r.solution.density)
        EXPECT_NEAR(d * ohm * 3 / 5, 1, 1e-5);
    EXPECT_NEAR(r.solution.level.row(0, 2, 1)[10], 1 + 5.0 / 4, 1e-6);
}

TEST(MechanicsConduct, SeriesAndParallel) {
    const auto two = [](size_t axis) {
        return box({8, 8, 8}, 1, [axis](const Vec3& p) { return p[axis] < 2 ? 500.0 : 0.05; });
    };
    // In series, along x: 2 mm of one and 6 mm of the other; in parallel beside each other.
    const double series = (2 / 0.5 + 6 / 0.05e-3) / 64;
    EXPECT_NEAR(conducted(two(0), kAcross).solution.flow_in[1] * series / 5, 1, 1e-5);
    const double parallel = (0.5 * 16 + 0.05e-3 * 48) / 8;
    EXPECT_NEAR(conducted(two(1), kAcross).solution.flow_in[1] / parallel / 5, 1, 1e-5);
}

TEST(MechanicsConduct, HeatThroughATubeIsALogarithm) {
    // A quarter of a tube, held inside and outside by objects that fill its hole and its surroundings.
    const double inner = 4, outer = 12, pitch = 0.25, length = 1;
    const auto n = static_cast<int32_t>(outer / pitch) + 2;
    const auto radius = [](const Vec3& p) { return std::hypot(p[0], p[1]); };
    const Voxels tube = box({n, n, 4}, pitch, [&](const Vec3& p) {
        return radius(p) < inner || radius(p) > outer ? -1.0 : 0.2;
    });
    std::vector<ObjectVoxels> objects{{"hole", tube.size, {}, {}}, {"around", tube.size, {}, {}}};
    for (int32_t z = 0; z < 4; ++z)
        for (int32_t y = 0; y < n; ++y)
            for (int32_t x = 0; x < n; ++x) {
                const double r = radius({(x + 0.5) * pitch, (y + 0.5) * pitch, 0});
                objects[0].inside.push_back(r < inner ? 1 : 0);
                objects[1].inside.push_back(r > outer ? 1 : 0);
            }
    const Conducts r = conducted(tube, R"({"held": [{"object": "hole", "celsius": 80},
                                                    {"object": "around", "celsius": 20}]})",
                                 objects);
    const double watts = 0.2e-3 * 60 * 2 * std::numbers::pi * length / std::log(outer / inner) / 4;
    EXPECT_NEAR(r.solution.flow_in[0] / watts, 1, 0.02);
    EXPECT_NEAR(r.solution.flow_in[1] / watts, -1, 0.02);
}

TEST(MechanicsConduct, WattsWarmABlockAsItsResistanceSays) {
    const Conducts r = conducted(box({5, 4, 10}, 1, [](const Vec3&) { return 0.2; }),
                                 R"({"held": [{"side": "-z", "celsius": 20}],
                                     "loads": [{"side": "+z", "watt": 0.3}]})");
    // 10 mm / (0.2e-3 W/(mm K) 20 mm2) K/W.
    EXPECT_NEAR(r.solution.level.row(0, 2, 10)[2], 20 + 0.3 * 10 / (0.2e-3 * 20), 1e-3);
    EXPECT_NEAR(r.solution.flow_in[0], -0.3, 1e-7);
}

TEST(MechanicsConduct, WhatCannotFlowIsSaid) {
    EXPECT_THAT(refused(R"({"held": [{"side": "-x", "volt": 1}]})"),
                testing::Says(messages::kNothingFlows));
    EXPECT_NE(refused(R"({"held": [{"side": "-x", "volt": 1}, {"side": "+x"}]})").find("no `volt`"),
              std::string::npos);
    EXPECT_THAT(
        refused(R"({"held": [{"side": "-x", "volt": 1}], "loads": [{"side": "+x", "watt": 1}]})"),
        testing::Says(messages::kKindsMixed, "volt", "watt"));
    EXPECT_THAT(
        refused(
            R"({"held": [{"side": "-x", "volt": 1}], "loads": [{"side": "+x", "force_N": [0, 0, 1]}]})"),
        testing::Says(messages::kKindsMixed));
    const auto fails = [](Voxels v, const char* text) {
        const Result<LoadCase> c = case_of(text);
        EXPECT_TRUE(c);
        const Result<ConductProblem> p = set_up_conduct(std::move(v), *c, {});
        return p ? std::string() : p.error().text();
    };
    // An insulator at one end; a flow into a piece that nothing holds.
    EXPECT_THAT(
        fails(box({8, 2, 2}, 1, [](const Vec3& p) { return p[0] > 4 ? 1e-12 : 1.0; }), kAcross),
        testing::Says(messages::kHeldInsulates));
    EXPECT_THAT(
        fails(box({8, 2, 2}, 1, [](const Vec3& p) { return p[0] > 3 && p[0] < 5 ? 1e-12 : 1.0; }),
              R"({"held": [{"side": "-x", "volt": 0}], "loads": [{"side": "+x", "ampere": 1}]})"),
        testing::Says(messages::kFlowNotJoined));
}

TEST(MechanicsConduct, SpheresAreMaxwells) {
    // A cubic array of spheres, 2 % of the cell; images change it by the share to the power 10/3.
    const double share = 0.02;
    for (const double ratio : {10.0, 1000.0, 0.1}) {
        std::array<double, 2> error{};
        for (const int32_t n : {24, 48}) {
            const Grid g = Grid::make({n, n, n}, {1, 1, 1}, true);
            const double radius = n * std::cbrt(share * 3 / (4 * std::numbers::pi));
            constexpr int kParts = 4;
            ElementValues v;
            for (int32_t z = 0; z < n; ++z)
                for (int32_t y = 0; y < n; ++y)
                    for (int32_t x = 0; x < n; ++x) {
                        double f = 0;
                        for (int p = 0; p < kParts * kParts * kParts; ++p) {
                            const double dx = x + (p % kParts + 0.5) / kParts - n / 2.0,
                                         dy = y + (p / kParts % kParts + 0.5) / kParts - n / 2.0,
                                         dz = z + (p / kParts / kParts + 0.5) / kParts - n / 2.0;
                            f += dx * dx + dy * dy + dz * dz < radius * radius
                                     ? 1.0 / (kParts * kParts * kParts)
                                     : 0;
                        }
                        // Hashin and Shtrikman's lower bound of the element's mixture.
                        const double least = std::min(1.0, ratio);
                        const double k =
                            1 / (f / (ratio + 2 * least) + (1 - f) / (1 + 2 * least)) - 2 * least;
                        v.first.push_back(static_cast<float>(k));
                    }
            v.normalise();
            const Homogenised<3> h = homogenise_conductivity(g, v, {});
            ASSERT_TRUE(h.converged());
            const double beta = (ratio - 1) / (ratio + 2);
            const double maxwell = (1 + 2 * share * beta) / (1 - share * beta);
            error[n == 48] = (h.tensor[0][0] - 1) / (maxwell - 1) - 1;
            // Mixed elements at its edge make it an error of first order, the larger the contrast.
            EXPECT_LT(std::abs(error[n == 48]), (ratio > 100 ? 4.6 : 3.5) / n) << ratio << " " << n;
        }
        EXPECT_LT(std::abs(error[1]), 0.6 * std::abs(error[0])) << ratio;
    }
}

// What does nothing is told, as of forces, and what cannot be is refused.
TEST(MechanicsConduct, HoldsAndLoadsThatMeetAreTold) {
    const auto bar = [] { return box({12, 4, 4}, 1, [](const Vec3&) { return 50.0; }); };
    const auto set_up = [&](const std::string& text) {
        const Result<LoadCase> c = case_of(text);
        EXPECT_TRUE(c) << c.error().text();
        return set_up_conduct(bar(), *c, {});
    };
    const Result<ConductProblem> idle =
        set_up(R"({"held": [{"side": "-x", "volt": 0}], "loads": [{"side": "-x", "ampere": 1}]})");
    ASSERT_TRUE(idle) << idle.error().text();
    ASSERT_EQ(idle->notes.size(), 1U);
    EXPECT_THAT(idle->notes[0], testing::Says(messages::kLoadOnHeld));
    const Result<ConductProblem> free =
        set_up(R"({"held": [{"side": "-x", "volt": 0}], "loads": [{"side": "+x", "ampere": 1}]})");
    ASSERT_TRUE(free) << free.error().text();
    EXPECT_TRUE(free->notes.empty());
    // Two sides of a bar have an edge in common, but no face.
    const Result<ConductProblem> edge =
        set_up(R"({"held": [{"side": "-x", "volt": 0}, {"side": "-y", "volt": 1}]})");
    ASSERT_FALSE(edge);
    EXPECT_THAT(edge.error().text(), testing::Says(messages::kTwoHoldsTouch, "one", "0", "1"));
    const Result<ConductProblem> same =
        set_up(R"({"held": [{"side": "-x", "volt": 0}, {"side": "-x", "volt": 1}]})");
    ASSERT_FALSE(same);
    EXPECT_THAT(same.error().text(), testing::Says(messages::kTwoHoldsOfFlow, "one", "0", "1"));
    EXPECT_THAT(
        refused(R"({"held": [{"side": "-x", "celsius": -274}, {"side": "+x", "celsius": 0}]})"),
        testing::Says(messages::kBelowAbsoluteZero));
    EXPECT_EQ(
        refused(R"({"held": [{"side": "-x", "celsius": -273.15}, {"side": "+x", "celsius": 0}]})"),
        "");
}

TEST(MechanicsConduct, AMistypedObjectIsNamedWithItsPlace) {
    const Result<LoadCase> c = parse_load_case(
        "{\"objects\": {\"mark\": {}, \"bar\": {}},\n\"cases\": {\"one\": {\"held\": [\n"
        "{\"object\": \"marc\", \"volt\": 1}]}}}",
        "w.fab.json", "");
    ASSERT_FALSE(c);
    EXPECT_THAT(c.error().text(), testing::Says(messages::kNoSuchObject, "marc"));
    EXPECT_EQ(c.error().location.line, 3);
    EXPECT_THAT(c.error().help, ::testing::HasSubstr("`mark`"));
}

}  // namespace
}  // namespace openfab::mechanics
