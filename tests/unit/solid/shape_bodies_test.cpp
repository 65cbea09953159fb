// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What a shape may ask of another: distances, and bounds of them, with and without micropolygons of it.

#include "runtime/solid/shape/shape_bodies.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/unit/solid/made_shape.h"

namespace openfab::solid {
namespace {

/// A shape that asks the distances to another, about the same middle.
struct Asking {
    std::unique_ptr<Made> body;
    part::ShapeStage stage;
    Bodies solids;

    explicit Asking(std::unique_ptr<Made> of) : body(std::move(of)) {
        openfab_fablet plain{};
        plain.name = "plain";
        mesh::Mesh box = mesh::make_box({20, 20, 20});
        for (Vec3d& p : box.positions)
            p.z -= 10;
        stage.mesh = *part::make_part_mesh(box, plain, {1, 0, 0, 0, 1, 0, 0, 0, 1});
        stage.bodies = {std::make_shared<part::Part>(body->part)};
        solids = {solid_of(*body, 0.25)};
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
        std::vector<float> low(kBoxes), high(kBoxes), quick_low(kBoxes), quick_high(kBoxes);
        bodies.bounds(0, pointers(lo), pointers(hi), kBoxes, false, &tools, low.data(),
                      high.data());
        bodies.bounds(0, pointers(lo), pointers(hi), kBoxes, true, &tools, quick_low.data(),
                      quick_high.data());
        size_t decided = 0;
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
            for (size_t k = 0; k < kPoints; ++k) {
                ASSERT_LE(low[i], exact[k]) << i;
                ASSERT_GE(high[i], exact[k]) << i;
                ASSERT_LE(quick_low[i], exact[k]) << i;
                ASSERT_GE(quick_high[i], exact[k]) << i;
            }
            // At most half as wide again as what a distance at the middle tells.
            EXPECT_LE(high[i] - low[i], 3 * std::sqrt(reach) + 4e-3) << i;
            decided += quick_low[i] >= 0 || quick_high[i] < 0 ? 1 : 0;
        }
        EXPECT_GT(decided, kBoxes / 3);
        // The ring's function is its distance: within what micropolygons leave out.
        std::vector<float> distances(kBoxes);
        bodies.distances(0, pointers(lo), kBoxes, &tools, distances.data());
        for (size_t i = 0; i < kBoxes; ++i)
            EXPECT_NEAR(distances[i], ring({lo[0][i], lo[1][i], lo[2][i]}), 0.02) << i;
    }
}

}  // namespace
}  // namespace openfab::solid
