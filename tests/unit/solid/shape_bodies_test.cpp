// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What a shape may ask of another: distances, and bounds of them, with and without micropolygons of it.

#include "runtime/solid/shape/shape_bodies.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "abi/looks.h"
#include "abi/shape_distance.h"
#include "runtime/solid/shape/shape_calls.h"
#include "tests/unit/solid/made_shape.h"

namespace openfab::solid {
namespace {

/// A shape that asks the distances to another, about the same middle.
struct Asking {
    std::unique_ptr<Made> body;
    part::ShapeStage stage;
    Bodies solids;

    explicit Asking(std::unique_ptr<Made> of, double pitch = 0.25) : body(std::move(of)) {
        openfab_fablet plain{};
        plain.name = "plain";
        mesh::Mesh box = mesh::make_box({20, 20, 20});
        for (Vec3d& p : box.positions)
            p.z -= 10;
        stage.mesh = *part::make_part_mesh(box, plain, {1, 0, 0, 0, 1, 0, 0, 0, 1});
        stage.bodies = {std::make_shared<part::Part>(body->part)};
        solids = {solid_of(*body, pitch)};
    }
};

TEST(ShapeBodies, BoundDistancesOverBoxes) {
    for (const bool is_distance : {false, true}) {
        const Asking asking(make<ring>({14, 14, 6}, is_distance));
        const ShapeBodies bodies(asking.stage, asking.solids, 0.25, OPENFAB_ISA_AVX2);
        EXPECT_EQ(bodies.any_quick(), !is_distance);
        ShapeBodies::Tools tools;
        std::mt19937 random(7);
        std::uniform_real_distribution<float> place(-9, 9), size(0, 1);
        constexpr size_t kBoxes = 300, kPoints = 40;
        std::array<std::vector<float>, 3> lo, hi, points;
        for (size_t i = 0; i < kBoxes; ++i) {
            // Points, small boxes, and boxes of several blocks.
            const float wide = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 0.3f : 6.0f;
            for (size_t a = 0; a < 3; ++a) {
                lo[a].push_back(place(random));
                hi[a].push_back(lo[a].back() + wide * size(random));
            }
        }
        const auto pointers = [](const std::array<std::vector<float>, 3>& of) {
            return std::array<const float*, 3>{of[0].data(), of[1].data(), of[2].data()};
        };
        constexpr std::array kEfforts{Effort::kBox, Effort::kNear, Effort::kGrid, Effort::kExact};
        std::array<std::vector<float>, kEfforts.size()> low, high;
        for (size_t e = 0; e < kEfforts.size(); ++e) {
            low[e].resize(kBoxes);
            high[e].resize(kBoxes);
            bodies.bounds(0, pointers(lo), pointers(hi), kBoxes, kEfforts[e], &tools, low[e].data(),
                          high[e].data());
        }
        std::array<size_t, kEfforts.size()> decided{};
        for (size_t i = 0; i < kBoxes; ++i) {
            double reach = 0;
            for (size_t a = 0; a < 3; ++a) {
                points[a].clear();
                reach += std::pow(0.5 * (hi[a][i] - lo[a][i]), 2);
                for (size_t k = 0; k < kPoints; ++k)
                    points[a].push_back(lo[a][i] + (hi[a][i] - lo[a][i]) * size(random));
            }
            std::vector<float> exact(kPoints);
            bodies.distances(0, pointers(points), kPoints, &tools, exact.data());
            for (size_t e = 0; e < kEfforts.size(); ++e) {
                for (size_t k = 0; k < kPoints; ++k) {
                    ASSERT_LE(low[e][i], exact[k]) << i << " by " << e;
                    ASSERT_GE(high[e][i], exact[k]) << i << " by " << e;
                }
                decided[e] += low[e][i] >= 0 || high[e][i] < 0 ? 1 : 0;
            }
            // At most half as wide again as what a distance at the middle tells. Where signs are those of values, both are
            // possible as long as bounds of the value leave them open. By the grid as what a distance within two cells along
            // each axis tells.
            EXPECT_LE(high[3][i] - low[3][i], (is_distance ? 3 : 6) * std::sqrt(reach) + 4e-3) << i;
            if (reach == 0) {
                EXPECT_LE(high[2][i] - low[2][i], 2 * std::sqrt(0.75) + 4e-3) << i;
            }
        }
        EXPECT_EQ(decided[0], 0u);
        EXPECT_GT(decided[1], kBoxes / 3);
        EXPECT_GT(decided[2], kBoxes / 5);
        // The ring's function is its distance: within what micropolygons leave out.
        std::vector<float> distances(kBoxes);
        bodies.distances(0, pointers(lo), kBoxes, &tools, distances.data());
        for (size_t i = 0; i < kBoxes; ++i)
            EXPECT_NEAR(distances[i], ring({lo[0][i], lo[1][i], lo[2][i]}), 0.02) << i;
    }
}

// A value changes its sign beside coarse micropolygons, where a signed distance jumps from one side to the other.
TEST(ShapeBodies, BoundDistancesByAGridWhereSignsJump) {
    const Asking asking(make<ring>({14, 14, 6}, false), 0.6);
    const ShapeBodies bodies(asking.stage, asking.solids, 0.6, OPENFAB_ISA_AVX2);
    ShapeBodies::Tools tools;
    constexpr size_t kPoints = 40000;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(-6, 6);
    std::array<std::vector<float>, 3> points;
    for (size_t i = 0; i < kPoints; ++i) {
        for (size_t a = 0; a < 3; ++a)
            points[a].push_back(place(random) * (a == 2 ? 0.3f : 1.0f));
    }
    const std::array<const float*, 3> at{points[0].data(), points[1].data(), points[2].data()};
    std::vector<float> low(kPoints), high(kPoints), exact(kPoints);
    bodies.bounds(0, at, at, kPoints, Effort::kGrid, &tools, low.data(), high.data());
    bodies.distances(0, at, kPoints, &tools, exact.data());
    for (size_t i = 0; i < kPoints; ++i) {
        ASSERT_LE(low[i], exact[i]) << i;
        ASSERT_GE(high[i], exact[i]) << i;
    }
}

/// A ball, and a plate that lies between two planes of vertices of a lattice of 0.25.
float plated(const Vec3f& p) {
    const float plate =
        std::max({std::fabs(p.z - 0.12f) - 0.01f, std::fabs(p.x) - 6.5f, std::fabs(p.y) - 6.5f});
    return std::min(length(p) - 3, plate);
}
/// The plate alone, which has no micropolygon.
float plate(const Vec3f& p) {
    return std::max({std::fabs(p.z - 0.12f) - 0.01f, std::fabs(p.x) - 6.5f, std::fabs(p.y) - 6.5f});
}

// Where a body is thinner than a cell it has a sign, but no micropolygon.
TEST(ShapeBodies, BoundDistancesWhereTheBodyIsThin) {
    for (const bool alone : {false, true}) {
        const Asking asking(alone ? make<plate>({14, 14, 14}, false)
                                  : make<plated>({14, 14, 14}, false));
        const ShapeBodies bodies(asking.stage, asking.solids, 0.25, OPENFAB_ISA_AVX2);
        ShapeBodies::Tools tools;
        std::mt19937 random(11);
        std::uniform_real_distribution<float> place(-6.4f, 6.4f), size(0, 0.8f);
        constexpr size_t kBoxes = 1000;
        std::array<std::vector<float>, 3> lo, hi, inside;
        for (size_t i = 0; i < kBoxes; ++i) {
            for (size_t a = 0; a < 3; ++a) {
                const float p = a == 2 ? 0.12f : place(random);
                inside[a].push_back(p);
                lo[a].push_back(p - (i % 4 == 0 ? 0 : size(random)));
                hi[a].push_back(p + (i % 4 == 0 ? 0 : size(random)));
            }
        }
        const auto pointers = [](const std::array<std::vector<float>, 3>& of) {
            return std::array<const float*, 3>{of[0].data(), of[1].data(), of[2].data()};
        };
        std::vector<float> low(kBoxes), high(kBoxes), exact(kBoxes);
        bodies.distances(0, pointers(inside), kBoxes, &tools, exact.data());
        for (const Effort effort : {Effort::kBox, Effort::kNear, Effort::kGrid, Effort::kExact}) {
            bodies.bounds(0, pointers(lo), pointers(hi), kBoxes, effort, &tools, low.data(),
                          high.data());
            for (size_t i = 0; i < kBoxes; ++i) {
                ASSERT_EQ(exact[i] > 0, alone) << i;
                // Not by NaN, which tells nothing.
                ASSERT_FALSE(low[i] > exact[i]) << i << " by " << static_cast<int>(effort);
                ASSERT_FALSE(high[i] < exact[i]) << i << " by " << static_cast<int>(effort);
            }
        }
    }
}

/// What the values' kernel was told of distances.
std::vector<float> told;

/// The larger of x and the distance to an object less 1.
int cut_off(void** args) {
    for (int32_t i = 0; i < count(args[2]); ++i) {
        out(args[2])[i] = std::max(in(args[0])[i], in(args[1])[i] - 1);
        told.push_back(in(args[1])[i]);
    }
    return 0;
}
int cut_off_bounds(void** args) {
    for (int32_t i = 0; i < count(args[4]); ++i) {
        const float x_lo = in(args[0])[i], x_hi = in(args[1])[i];
        const float lo = in(args[2])[i] - 1, hi = in(args[3])[i] - 1;
        const bool known = lo == lo && hi == hi;
        const float nan = std::numeric_limits<float>::quiet_NaN();
        out(args[4])[i] = known ? std::max(x_lo, lo) : nan;
        out(args[5])[i] = known ? std::max(x_hi, hi) : nan;
        out(args[6])[i] = hi < x_lo ? 0.0f : 1.0f;
    }
    return 0;
}
const openfab_arg kCutOffArgs[] = {{OPENFAB_ARG_SHAPE_POINT, OPENFAB_FLOAT, 0, 0},
                                   {abi::kShapeDistance, OPENFAB_FLOAT, 0, 0},
                                   {OPENFAB_ARG_SHAPE_VALUE, OPENFAB_FLOAT, 0, 0}};
const openfab_arg kCutOffBoundArgs[] = {
    {OPENFAB_ARG_SHAPE_POINT_LO, OPENFAB_FLOAT, 0, 0},
    {OPENFAB_ARG_SHAPE_POINT_HI, OPENFAB_FLOAT, 0, 0},
    {abi::kShapeDistanceLo, OPENFAB_FLOAT, 0, 0},
    {abi::kShapeDistanceHi, OPENFAB_FLOAT, 0, 0},
    {OPENFAB_ARG_SHAPE_VALUE_LO, OPENFAB_FLOAT, 0, 0},
    {OPENFAB_ARG_SHAPE_VALUE_HI, OPENFAB_FLOAT, 0, 0},
    {OPENFAB_ARG_SHAPE_VALUE_HI, OPENFAB_FLOAT, abi::kLooksSlot, 0}};

// Where bounds of a distance decide, any distance within them gives a value its bits.
TEST(ShapeBodies, GiveValuesAndSignsOfDensePointsTheirBits) {
    Asking asking(make<ring>({14, 14, 6}, false));
    openfab_shape shape{};
    shape.values = {{cut_off, cut_off, cut_off}, 3, kCutOffArgs, 0};
    shape.bounds = {{cut_off_bounds, cut_off_bounds, cut_off_bounds}, 7, kCutOffBoundArgs, 0};
    openfab_fablet fablet{};
    fablet.name = "cut_off";
    fablet.shape = &shape;
    asking.stage.fablet = &fablet;
    const ShapeBodies bodies(asking.stage, asking.solids, 0.1, OPENFAB_ISA_AVX2);
    const surface::StaticArgs fixed(asking.stage);
    ShapeCalls calls(asking.stage, fixed, bodies, OPENFAB_ISA_AVX2);
    EXPECT_TRUE(calls.asks());
    // More than one piece, and no whole number of groups of lanes.
    constexpr size_t kPoints = 9003;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> place(-3, 3);
    ShapePoints points, hi;
    for (size_t i = 0; i < kPoints; ++i) {
        const Vec3f p{place(random), place(random) + 3, place(random) / 3};
        points.push_back(p);
        hi.push_back(p + Vec3f{0.2f, 0.1f, 0.3f});
    }
    std::vector<float> values, dense, signs, dense_signs, lo[2], up[2];
    ASSERT_TRUE(calls.values(points, &values).ok());
    const std::vector<float> distances = std::exchange(told, {});
    ASSERT_TRUE(calls.dense_values(points, &dense).ok());
    size_t not_asked = 0;
    ASSERT_EQ(told.size(), kPoints);
    for (size_t i = 0; i < kPoints; ++i) {
        ASSERT_EQ(std::bit_cast<uint32_t>(values[i]), std::bit_cast<uint32_t>(dense[i])) << i;
        not_asked += told[i] != distances[i] ? 1 : 0;
    }
    EXPECT_GT(not_asked, kPoints / 4);
    ASSERT_TRUE(calls.signs(points, &signs).ok());
    ASSERT_TRUE(calls.dense_signs(points, &dense_signs).ok());
    for (size_t i = 0; i < kPoints; ++i) {
        ASSERT_EQ(values[i] < 0, signs[i] < 0) << i;
        ASSERT_EQ(values[i] < 0, dense_signs[i] < 0) << i;
    }
    ASSERT_TRUE(calls.bounds(points, hi, &lo[0], &up[0]).ok());
    ASSERT_TRUE(calls.sign_bounds(points, hi, &lo[1], &up[1]).ok());
    for (size_t i = 0; i < kPoints; ++i) {
        ASSERT_EQ(lo[0][i] >= 0, lo[1][i] >= 0) << i;
        ASSERT_EQ(up[0][i] < 0, up[1][i] < 0) << i;
    }
}

}  // namespace
}  // namespace openfab::solid
