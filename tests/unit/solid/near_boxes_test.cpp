// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Bounds of 32 boxes by cubes of a lattice, and which cubes of a block are near, against each box and each cube alone; all
// instruction sets.

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
    std::vector<TakeCubes> sets{near_kernels_sse41().take};
    if (near_kernels().take != sets[0]) sets.push_back(near_kernels().take);
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

/// Of one cube of a block alone.
float cube_distance2(const NearBlock& block, const Box3f& whole, const Vec3i& at, bool most) {
    float sum = 0;
    for (int a = 0; a < 3; ++a) {
        const float* sides = &block.sides[static_cast<size_t>(a)][at[a]];
        const float d = most ? std::max(whole.hi[a] - sides[0], sides[1] - whole.lo[a])
                             : std::max({sides[0] - whole.hi[a], whole.lo[a] - sides[1], 0.0f});
        sum += d * d;
    }
    return sum;
}

TEST(NearBoxes, CubesOfABlockAreThoseThatAreNeeded) {
    std::vector<AddCubes> sets{near_kernels_sse41().add};
    if (near_kernels().add != sets[0]) sets.push_back(near_kernels().add);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> real(0, 1);
    int left_out = 0, lowered = 0;
    for (int round = 0; round < 300; ++round) {
        std::array<std::vector<float>, 3> sides;
        NearBlock block;
        Box3f whole;
        for (int a = 0; a < 3; ++a) {
            auto& of = sides[static_cast<size_t>(a)];
            for (int i = 0; i < 5; ++i)
                of.push_back(0.3f * static_cast<float>(i) + 0.1f * real(random));
            block.first[static_cast<size_t>(a)] = 4 * (a + round);
            block.sides[static_cast<size_t>(a)] = of.data();
            whole.lo[a] = 3 * real(random) - 1;
            whole.hi[a] = whole.lo[a] + 0.3f * real(random);
        }
        block.possible = (uint64_t{random()} << 32 | random());
        block.certain = block.possible & (uint64_t{random()} << 32 | random());
        if (round % 7 == 0) block.certain = 0;
        const float before = round % 3 == 0 ? kInfinity : 4 * real(random);
        float nearest2 = before;
        for (int bit = 0; bit < 64; ++bit) {
            if ((block.certain >> bit & 1) != 0)
                nearest2 = std::min(
                    nearest2, cube_distance2(block, whole, {bit % 4, bit / 4 % 4, bit / 16}, true));
        }
        lowered += nearest2 < before ? 1 : 0;
        std::vector<std::pair<int, float>> expected;
        for (int bit = 0; bit < 64; ++bit) {
            const float low2 =
                cube_distance2(block, whole, {bit % 4, bit / 4 % 4, bit / 16}, false);
            if ((block.possible >> bit & 1) != 0 && low2 <= nearest2)
                expected.emplace_back(bit, low2);
            else
                ++left_out;
        }
        for (const AddCubes add : sets) {
            std::array<NearCube, kMostBlockCubes> cubes{};
            float found2 = before;
            const size_t count = add(block, whole, &found2, cubes.data());
            EXPECT_EQ(found2, nearest2);
            ASSERT_EQ(count, expected.size());
            for (size_t i = 0; i < count; ++i) {
                const int bit = expected[i].first;
                EXPECT_EQ(cubes[i].low2, expected[i].second);
                EXPECT_EQ(cubes[i].at[0], block.first[0] + bit % 4);
                EXPECT_EQ(cubes[i].at[1], block.first[1] + bit / 4 % 4);
                EXPECT_EQ(cubes[i].at[2], block.first[2] + bit / 16);
                EXPECT_EQ(cubes[i].certain, (block.certain >> bit & 1) != 0);
            }
        }
    }
    EXPECT_GT(left_out, 1000);
    EXPECT_GT(lowered, 100);
}

}  // namespace
}  // namespace openfab::solid
