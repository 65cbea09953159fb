// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The depth map against columns walked through exact winding numbers.

#include "runtime/support_material/depth_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <random>

#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/support_material/messages.h"
#include "tests/support/says/says.h"
#include "tests/support/surface/grid_over.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using support_material::DepthMap;
using surface::Surface;

/// A part with everything that the depth map needs.
struct Standing {
    part::Part part;
    std::shared_ptr<const Surface> surface;
    std::shared_ptr<solid::Solid> solid;

    Standing(part::Part p, double micro_edge_mm) : part(std::move(p)) {
        surface::SurfaceOptions options;
        options.micro_edge_mm = micro_edge_mm;
        surface = std::move(*Surface::create(part, options));
        solid = solid::make_solid_of(part, surface);
        solid->prepare({}, {});
    }
    std::unique_ptr<solid::Placed> on(const part::Grid& grid) const {
        return solid->place({part, grid, part::make_frame(part, grid)});
    }
    std::vector<uint8_t> inside(const part::Grid& grid) const {
        return reference::inside(
            reference::snap_triangles(part::local_to_voxel(part, grid),
                                      testing::covering_triangles(part, *surface)),
            grid.size);
    }
};

Result<DepthMap> map_of(const std::vector<const Standing*>& parts, const part::Grid& grid,
                        int64_t most_bytes = 1 << 28) {
    std::vector<support_material::SupportedPart> on;
    std::vector<std::unique_ptr<solid::Placed>> placed;
    for (const Standing* part : parts) {
        placed.push_back(part->on(grid));
        on.push_back({placed.back().get(), placed.back()->voxel_box()});
    }
    return DepthMap::create(on, grid, most_bytes);
}

/// The highest covered voxel of each column, 0 where there is none.
std::vector<int32_t> column_tops(const std::vector<uint8_t>& inside, const Vec3i& size) {
    const size_t slice = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    std::vector<int32_t> tops(slice, 0);
    for (size_t v = 0; v < inside.size(); ++v) {
        if (inside[v] != 0) tops[v % slice] = static_cast<int32_t>(v / slice);
    }
    return tops;
}

std::vector<int32_t> all_tops(const DepthMap& map, const Vec3i& size) {
    std::vector<int32_t> tops;
    for (int32_t y = 0; y < size.y; ++y) {
        for (int32_t x = 0; x < size.x; ++x)
            tops.push_back(map.top(x, y));
    }
    return tops;
}

part::Grid grid_over(const Box3d& box, bool on_centers) {
    return testing::grid_over(box, on_centers, {1, 1.3, 0.8});
}

part::Grid grid_over(const Standing& part, bool on_centers) {
    return grid_over(part.surface->exact_box(part.part.local_to_build), on_centers);
}

std::vector<Affine3d> transforms() {
    Affine3d turned, mirrored, leaning;
    turned.m = {0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6};
    turned.t = {3, -1, 2};
    mirrored.m = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
    leaning.m = {1, 0.4, 0.3, 0, 1.2, -0.5, 0.2, 0, -0.9};
    return {Affine3d{}, turned, mirrored, leaning};
}

// The whole point of an exact map: no column has more support than it needs.
void expect_columns(const Standing& part, const part::Grid& grid, const std::string& what) {
    const std::vector<int32_t> expected = column_tops(part.inside(grid), grid.size);
    const Result<DepthMap> map = map_of({&part}, grid);
    ASSERT_TRUE(map) << map.error().text();
    const std::vector<int32_t> tops = all_tops(*map, grid.size);
    int64_t low = 0, high = 0;
    for (size_t i = 0; i < tops.size(); ++i) {
        low += tops[i] < expected[i] ? 1 : 0;
        high += tops[i] > expected[i] ? 1 : 0;
    }
    EXPECT_EQ(low, 0) << what;
    if (part.surface->identity()) {
        EXPECT_EQ(high, 0) << what;
    }
}

/// Only some of the scenarios under a sanitizer.
std::vector<testing::Scenario> scenarios() {
    std::vector<testing::Scenario> all = testing::scenarios();
#ifdef OPENFAB_SANITIZED
    std::vector<testing::Scenario> some;
    for (size_t k = 0; k < all.size(); k += 5)
        some.push_back(all[k]);
    return some;
#else
    return all;
#endif
}

TEST(DepthMap, IsNeverBelowTheColumnsOfADisplacedPart) {
    for (const testing::Scenario& scenario : scenarios()) {
        int number = 0;
        for (const Affine3d& transform : transforms()) {
            const Standing part(make_part(scenario, transform),
                                std::max(scenario.micro_edge_mm, 0.2));
            ++number;
            expect_columns(part, grid_over(part, number % 2 == 0),
                           scenario.name + " " + std::to_string(number));
        }
    }
}

TEST(DepthMap, EqualsTheColumnsOfAnUndisplacedPart) {
    for (const testing::Scenario& scenario : scenarios()) {
        int number = 0;
        for (const Affine3d& transform : transforms()) {
            for (const bool on_centers : {false, true}) {
                testing::PartOptions options;
                options.transform = transform;
                const Standing part(
                    testing::make_part(testing::empty_fablet(), scenario.mesh, options), 0.2);
                expect_columns(part, grid_over(part, on_centers),
                               scenario.name + " " + std::to_string(number++));
            }
        }
    }
}

// Vertices on voxel centers and edges through them, and shells that intersect each other and
// themselves, several deep: cases that the two highest crossings do not decide.
TEST(DepthMap, EqualsTheColumnsOfEdgesThroughVoxelCentres) {
    for (uint32_t seed = 1; seed <= 24; ++seed) {
        std::mt19937 random(seed);
        mesh::Mesh mesh = testing::shaken(testing::sphere(1.5, 7, 5), seed, 0.7);
        for (int k = 0; k < 4; ++k) {
            const auto off = [&] { return static_cast<double>(random() % 9) / 8 - 0.5; };
            const Vec3d offset{off(), off(), off()};
            mesh =
                testing::joined(mesh, testing::shaken(testing::cube(1), seed + 100, 0.5), offset);
        }
        // Onto a grid of 1/8 mm, on which the voxels' centers lie; every third turned inside out.
        for (Vec3d& p : mesh.positions) {
            for (int axis = 0; axis < 3; ++axis)
                p[axis] = std::round(p[axis] * 8) / 8;
        }
        if (seed % 3 == 0) {
            for (auto& t : mesh.triangles)
                std::swap(t[1], t[2]);
        }
        const Standing part(testing::make_part(testing::empty_fablet(), mesh), 0.2);
        expect_columns(part, grid_over(part, true), "seed " + std::to_string(seed));
    }
}

TEST(DepthMap, IsTheHighestOfAllParts) {
    testing::PartOptions above;
    above.transform.t = {0.7, 0.4, 2.2};
    const Standing one(testing::make_part(testing::empty_fablet(), testing::sphere(1, 12, 8)), 0.2);
    const Standing two(
        testing::make_part(testing::empty_fablet(), testing::torus(0.9, 0.3, 16, 8), above), 0.2);
    Box3d box = one.surface->exact_box(one.part.local_to_build);
    box.add(two.surface->exact_box(two.part.local_to_build));
    const part::Grid grid = grid_over(box, false);
    const std::vector<int32_t> first = column_tops(one.inside(grid), grid.size);
    std::vector<int32_t> expected = column_tops(two.inside(grid), grid.size);
    for (size_t i = 0; i < expected.size(); ++i)
        expected[i] = std::max(expected[i], first[i]);
    EXPECT_EQ(all_tops(*map_of({&one, &two}, grid), grid.size), expected);
    EXPECT_EQ(all_tops(*map_of({&two, &one}, grid), grid.size), expected);
    EXPECT_EQ(all_tops(*map_of({}, grid), grid.size), std::vector<int32_t>(expected.size(), 0));
}

// Tiles of 1, 2 and 4 bytes a column, of none, and ones that the grid cuts.
TEST(DepthMap, KeepsEveryHeight) {
    const Standing part(testing::make_part(testing::empty_fablet(),
                                           testing::shaken(testing::sphere(2, 9, 7), 3, 0.3)),
                        0.2);
    for (const double fine : {1.0, 30.0, 2000.0, 3e4}) {
        part::Grid grid = grid_over(part, false);
        grid.pitch_mm.x /= 3;
        grid.pitch_mm.z /= fine;
        grid.size.x *= 3;
        grid.size.z = static_cast<int32_t>(grid.size.z * fine);
        const Result<DepthMap> map = map_of({&part}, grid);
        ASSERT_TRUE(map);
        // The plain winding of some columns' tops and of what lies over them.
        const auto triangles =
            reference::snap_triangles(part::local_to_voxel(part.part, grid),
                                      testing::covering_triangles(part.part, *part.surface));
        int32_t highest = 0, checked = 0;
        for (int32_t y = 0; y < grid.size.y; ++y) {
            for (int32_t x = 0; x < grid.size.x; ++x) {
                const int32_t top = map->top(x, y);
                highest = std::max(highest, top);
                if (top == 0 || (x + y) % 5 != 0) continue;
                ++checked;
                EXPECT_GT(reference::winding(triangles, {x, y, top}), 0);
                EXPECT_LE(reference::winding(triangles, {x, y, top + 1}), 0);
            }
        }
        EXPECT_GT(checked, 50);
        EXPECT_GT(highest, 15 * fine);
        int64_t columns = 0;
        for (int32_t y = 0; y < grid.size.y; y += DepthMap::kTile) {
            int32_t row = 0;
            for (int32_t t = 0; t < map->tiles_x(); ++t) {
                const DepthMap::Range range = map->tile_range(t, y);
                EXPECT_LE(range.lo, range.hi);
                row = std::max(row, range.hi);
            }
            EXPECT_EQ(map->highest(y), row);
            columns += int64_t{map->tiles_x()} * DepthMap::kTile * DepthMap::kTile;
        }
        EXPECT_LE(map->bytes(), columns * (fine < 10 ? 1 : fine < 2000 ? 2 : 4) + 1000);
    }
}

TEST(DepthMap, RefusesWhatDoesNotFit) {
    const Standing part(testing::make_part(testing::empty_fablet(), testing::sphere(2, 32, 16)),
                        0.2);
    part::Grid grid = grid_over(part, false);
    grid.pitch_mm.x /= 20;
    grid.size.x *= 20;
    const int64_t bytes = map_of({&part}, grid)->bytes();
    EXPECT_TRUE(map_of({&part}, grid, bytes));
    const Result<DepthMap> refused = map_of({&part}, grid, bytes / 2);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kUserInput);
    EXPECT_THAT(refused.error().text(),
                testing::Says(support_material::messages::kSupportTakesMemory));
}

TEST(DepthMap, IsTheSameForAnyNumberOfThreads) {
    const testing::Scenario scenario = testing::scenarios()[0];
    const Standing part(make_part(scenario, transforms()[3]), 0.2);
    const part::Grid grid = grid_over(part, false);
    std::vector<int32_t> first;
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        arena.execute([&] {
            const std::vector<int32_t> tops = all_tops(*map_of({&part}, grid), grid.size);
            if (first.empty()) first = tops;
            EXPECT_EQ(tops, first);
        });
    }
}

}  // namespace
}  // namespace openfab
