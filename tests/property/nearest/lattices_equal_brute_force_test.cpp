// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Trees over diced lattices, however many micropolygons a base triangle has: units of small
// patches, patches with a tree of their own, and patches in pieces give the answers of brute force,
// ties included.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "base/infinity.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/tree/patch_units.h"
#include "runtime/nearest/tree/treelets.h"
#include "tests/support/reference/brute_force.h"
#include "tests/support/surface/grid_over.h"
#include "tests/support/surface/worlds.h"

namespace openfab::nearest {
namespace {

struct Case {
    const char* name;
    mesh::Mesh mesh;
    testing::HandMode mode;
    float amplitude_mm;
    double micro_edge_mm;
    double pitch_mm;
    size_t least_units;  ///< units of more than one patch
};

size_t shared_trees(const surface::Surface& surface) {
    LazyTreelets treelets(surface);
    PatchUnits units(surface, &treelets.boxes());
    size_t shared = 0;
    for (const InputPatch& box : treelets.boxes())
        shared += !treelets.has(box.patch) && units.patches(box.patch).size() > 1 ? 1 : 0;
    return shared;
}

/// Compares some blocks, with a cache for all trees and with none, where each is made again.
void check(const Case& of) {
    SCOPED_TRACE(of.name);
    const part::Part part =
        testing::make_part(testing::Scenario{of.name, of.mesh, of.mode, of.amplitude_mm, 0.5});
    surface::SurfaceOptions options;
    options.micro_edge_mm = of.micro_edge_mm;
    const auto surface = std::move(*surface::Surface::create(part, options));
    EXPECT_GE(shared_trees(*surface), of.least_units);
    const part::Grid grid = testing::grid_over(surface->exact_box(part.local_to_build), true,
                                               {of.pitch_mm, 2 * of.pitch_mm, of.pitch_mm / 2});
    const auto frame = part::make_frame(part, grid);
    const auto roomy = make_block_engine(*surface, frame);
    const auto without = make_block_engine(*surface, frame, {.cache_bytes = 0});
    const auto twin = reference::make_brute_force_engine(*surface, frame);
    const auto scratch = roomy->make_scratch(), scratch_without = without->make_scratch(),
               twin_scratch = twin->make_scratch();
    const Vec3i base = part::part_base_voxel(part, grid);
    BlockAnswer got, want;
    const auto compare = [&] {
        EXPECT_EQ(std::memcmp(got.distance2, want.distance2, sizeof got.distance2), 0);
        EXPECT_EQ(std::memcmp(got.item, want.item, sizeof got.item), 0);
        EXPECT_EQ(std::memcmp(got.in_patch.triangle, want.in_patch.triangle,
                              sizeof got.in_patch.triangle),
                  0);
        EXPECT_EQ(std::memcmp(got.in_patch.bary1, want.in_patch.bary1, sizeof got.in_patch.bary1),
                  0);
        EXPECT_EQ(std::memcmp(got.in_patch.bary2, want.in_patch.bary2, sizeof got.in_patch.bary2),
                  0);
    };
    std::array<uint8_t, 64> lower_half;
    lower_half.fill(0x0f);
    int32_t number = 0;
    for (int32_t z = 0; z < grid.size.z; z += 8) {
        for (int32_t y = 0; y < grid.size.y; y += 8) {
            for (int32_t x = 0; x < grid.size.x; x += 8) {
                if (++number % 5 != 0) continue;
                BlockQuery query{Vec3i{x, y, z} - base};
                query.radius_mm = number % 2 == 0 ? kInfinity : number % 3 == 0 ? 0.25f : 1.0f;
                if (number % 4 < 2) query.active = lower_half.data();
                twin->query(query, twin_scratch.get(), &want);
                roomy->query(query, scratch.get(), &got);
                compare();
                without->query(query, scratch_without.get(), &got);
                compare();
                if (::testing::Test::HasFailure()) return;
            }
        }
    }
    EXPECT_GE(number, 6);
}

using testing::HandMode;

TEST(Lattices, OfFewMicropolygonsShareATree) {
    check({"two cells", testing::torus(4, 1.5, 24, 12), HandMode::kBumps, 0.3f, 0.6, 0.6, 2});
    check({"one cell", testing::torus(4, 1.5, 24, 12), HandMode::kBumps, 0.3f, 9, 0.6, 2});
}

TEST(Lattices, OfManyMicropolygonsAreCut) {
    check({"ball", testing::sphere(1.4, 5, 3), HandMode::kBumps, 0.2f, 0.07, 0.18, 0});
}

TEST(Lattices, InPiecesHaveTipsOfFewTriangles) {
    check({"card", testing::card(6, 4, 1), HandMode::kBack, 0.2f, 0.1, 0.15, 0});
}

// Blocks as high as the card is thick: their corners are near the back, and no voxel's reach is.
TEST(Lattices, BeyondTheReachAreNotDiced) {
    const part::Part part = testing::make_part(
        testing::Scenario{"card", testing::card(9, 8, 1.3), HandMode::kBack, 0.2f, 0.5});
    surface::SurfaceOptions options;
    options.micro_edge_mm = 0.16;
    const auto surface = std::move(*surface::Surface::create(part, options));
    const part::Grid grid =
        testing::grid_over(surface->exact_box(part.local_to_build), true, {0.17f, 0.34f, 0.14f});
    const auto frame = part::make_frame(part, grid);
    const auto cache = make_patch_cache(64 << 20);
    const auto engine = make_block_engine(*surface, frame, {.cache = cache});
    const auto twin = reference::make_brute_force_engine(*surface, frame);
    const auto scratch = engine->make_scratch(), twin_scratch = twin->make_scratch();
    const Vec3i base = part::part_base_voxel(part, grid);
    // The voxels within 0.4 mm of the front, and those below them in the block that are not asked.
    std::array<uint8_t, 64> top;
    top.fill(0xe0);
    BlockAnswer got, want;
    int32_t found = 0;
    for (int32_t y = 8; y + 16 < grid.size.y; y += 8) {
        for (int32_t x = 8; x + 16 < grid.size.x; x += 8) {
            BlockQuery query{Vec3i{x, y, grid.size.z - 8} - base, top.data(), 0.4f};
            engine->query(query, scratch.get(), &got);
            twin->query(query, twin_scratch.get(), &want);
            EXPECT_EQ(std::memcmp(got.distance2, want.distance2, sizeof got.distance2), 0);
            EXPECT_EQ(std::memcmp(got.item, want.item, sizeof got.item), 0);
            found += static_cast<int32_t>(
                std::ranges::count_if(got.item, [](int32_t p) { return p >= 0; }));
        }
    }
    EXPECT_GT(found, 500);
    // The first block has no surface point to start from.
    EXPECT_LT(built_bytes(*cache), 400'000);
}

TEST(Lattices, OfBoxesMeetInStrips) {
    check({"box", testing::card(2.6, 2.4, 1.2), HandMode::kBumps, 0.2f, 0.1, 0.18, 0});
}

}  // namespace
}  // namespace openfab::nearest
