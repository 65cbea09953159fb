// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Bounds of 32 boxes by cubes of a lattice, against each box and each cube alone; all instruction sets.

#include "runtime/solid/shape/near_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "base/infinity.h"
#include "simd/isa.h"

namespace openfab::solid {
namespace {

struct Scene {
    std::array<std::vector<float>, 3> sides;
    std::vector<NearCube> cubes;  ///< the close ones first
    size_t close = 0;
    NearBoxes boxes{};
    NearLattice lattice{};
    std::vector<NearRow> table;

    float gap2(size_t a, int32_t cube, float lo, float hi) const {
        const auto i = static_cast<size_t>(cube);
        const float d = std::max({sides[a][i] - hi, lo - sides[a][i + 1], 0.0f});
        return d * d;
    }
    float most2(size_t a, int32_t cube, float lo, float hi) const {
        const auto i = static_cast<size_t>(cube);
        const float d = std::max(hi - sides[a][i], sides[a][i + 1] - lo);
        return d * d;
    }
};

Scene random_scene(std::mt19937* random) {
    Scene scene;
    std::uniform_real_distribution<float> real(0, 1);
    std::uniform_int_distribution<int32_t> place(2, 13);
    for (size_t a = 0; a < 3; ++a) {
        for (int i = 0; i <= 16; ++i)
            scene.sides[a].push_back(0.3f * static_cast<float>(i) + 0.1f * real(*random));
    }
    for (size_t b = 0; b < kMostNearBoxes; ++b) {
        for (size_t a = 0; a < 3; ++a) {
            scene.boxes.lo[a][b] = 2 + 0.5f * real(*random);
            scene.boxes.hi[a][b] = scene.boxes.lo[a][b] + 0.2f * real(*random);
        }
        scene.boxes.low2[b] = 9;
        scene.boxes.high2[b] = kInfinity;
    }
    for (int k = 0; k < 60; ++k) {
        NearCube cube{{place(*random), place(*random), place(*random)}, 0, real(*random) < 0.5f};
        for (size_t a = 0; a < 3; ++a)
            cube.low2 += scene.gap2(a, cube.at[a], 2, 2.7f);
        scene.cubes.push_back(cube);
    }
    scene.close =
        static_cast<size_t>(std::partition(scene.cubes.begin(), scene.cubes.end(),
                                           [](const NearCube& cube) { return cube.low2 < 0.5f; }) -
                            scene.cubes.begin());
    scene.lattice.first = {2, 2, 2};
    scene.lattice.end = {14, 14, 14};
    for (size_t a = 0; a < 3; ++a)
        scene.lattice.sides[a] = scene.sides[a].data();
    scene.table.resize(2 * 36);
    return scene;
}

TEST(NearBoxes, AreThoseOfEachBoxAndEachCube) {
    std::vector<TakeCubes> sets{take_cubes_sse41};
    if (take_cubes() != take_cubes_sse41) sets.push_back(take_cubes());
    std::mt19937 random(39);
    for (int round = 0; round < 50; ++round) {
        const Scene scene = random_scene(&random);
        for (const TakeCubes take : sets) {
            Scene got = scene;
            got.lattice.table = got.table.data();
            for (size_t b = 0; b < kMostNearBoxes; b += kNearLanes)
                take(got.lattice, got.cubes, got.close, b, &got.boxes);
            for (size_t b = 0; b < kMostNearBoxes; ++b) {
                float low2 = 9, high2 = kInfinity;
                for (const NearCube& cube : scene.cubes) {
                    float near = 0, far = 0;
                    for (size_t a = 0; a < 3; ++a) {
                        near +=
                            scene.gap2(a, cube.at[a], scene.boxes.lo[a][b], scene.boxes.hi[a][b]);
                        far +=
                            scene.most2(a, cube.at[a], scene.boxes.lo[a][b], scene.boxes.hi[a][b]);
                    }
                    low2 = std::min(low2, near);
                    if (cube.certain) high2 = std::min(high2, far);
                }
                EXPECT_EQ(got.boxes.low2[b], low2) << round << " " << b;
                EXPECT_EQ(got.boxes.high2[b], high2) << round << " " << b;
            }
        }
    }
}

}  // namespace
}  // namespace openfab::solid
