// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Coverage against point-in-solid by exact winding numbers; parts that touch; any order of slabs.

#include "runtime/voxel/coverage.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cctype>
#include <cmath>
#include <random>

#include "tests/support/surface/grid_over.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using surface::Surface;
using surface::SurfaceOptions;

size_t index(const Vec3i& size, int32_t x, int32_t y, int32_t z) {
    return (static_cast<size_t>(z) * static_cast<size_t>(size.y) + static_cast<size_t>(y)) *
               static_cast<size_t>(size.x) +
           static_cast<size_t>(x);
}

std::vector<uint8_t> voxels(const voxel::Voxeliser& voxeliser, const part::Grid& grid,
                            const std::vector<int32_t>& slabs) {
    std::vector<uint8_t> out(index(grid.size, 0, 0, grid.size.z), 0);
    voxel::SlabMask mask;
    for (const int32_t g : slabs) {
        voxeliser.coverage(g, &mask);
        for (int32_t y = 0; y < mask.height; ++y) {
            for (int32_t x = 0; x < mask.width; ++x) {
                const uint8_t bits = mask.mask[static_cast<size_t>(y * mask.width + x)];
                for (int32_t k = 0; k < 8 && bits != 0; ++k) {
                    if (((bits >> k) & 1) != 0)
                        out[index(grid.size, mask.x0 + x, mask.y0 + y, 8 * g + k)] = 1;
                }
            }
        }
    }
    return out;
}

std::vector<int32_t> all_slabs(const part::Grid& grid) {
    std::vector<int32_t> out;
    for (int32_t g = 0; 8 * g < grid.size.z; ++g)
        out.push_back(g);
    return out;
}

std::vector<uint8_t> voxels(const part::Part& part, const part::Grid& grid, double s = 0.1) {
    SurfaceOptions options;
    options.micro_edge_mm = s;
    auto surface = std::move(*Surface::create(part, options));
    return voxels(voxel::Voxeliser(part, *surface, grid), grid, all_slabs(grid));
}

class Coverage : public ::testing::TestWithParam<testing::Scenario> {};

Affine3d turned_transform() {
    Affine3d turned;
    turned.m = {0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6};
    turned.t = {3, -1, 2};
    return turned;
}

Affine3d mirrored_transform() {
    Affine3d mirrored;
    mirrored.m = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
    return mirrored;
}

TEST_P(Coverage, EqualsTheWindingNumberOfEveryVoxel) {
    SurfaceOptions options;
    options.micro_edge_mm = std::max(GetParam().micro_edge_mm, 0.2);
    int number = 0;
    for (const Affine3d& transform : {Affine3d{}, turned_transform(), mirrored_transform()}) {
        const part::Part part = make_part(GetParam(), transform);
        auto surface = std::move(*Surface::create(part, options));
        const part::Grid grid = testing::grid_over(surface->exact_box(part.local_to_build),
                                                   number++ % 2 == 0, {1, 1.7, 1});
        const voxel::Voxeliser voxeliser(part, *surface, grid);
        const auto expected = reference::inside(
            reference::snap_triangles(part::local_to_voxel(part, grid),
                                      testing::covering_triangles(part, *surface)),
            grid.size);
        std::vector<int32_t> slabs = all_slabs(grid);
        ASSERT_EQ(voxels(voxeliser, grid, slabs), expected) << "transform " << number;
        // In any order, and twice.
        std::reverse(slabs.begin(), slabs.end());
        EXPECT_EQ(voxels(voxeliser, grid, slabs), expected);
        std::shuffle(slabs.begin(), slabs.end(), std::mt19937(number));
        EXPECT_EQ(voxels(voxeliser, grid, slabs), expected);
        // No crossings kept between slabs, and all slabs at once on many threads.
        const voxel::Voxeliser forgetful(part, *surface, grid, 0);
        EXPECT_EQ(voxels(forgetful, grid, slabs), expected);
        const voxel::Voxeliser shared(part, *surface, grid);
        std::vector<voxel::SlabMask> masks(slabs.size());
        tbb::parallel_for(size_t{0}, 3 * slabs.size(), [&](size_t i) {
            const size_t g = i % slabs.size();
            voxel::SlabMask mask;
            shared.coverage(slabs[g], &mask);
            if (i < slabs.size()) masks[g] = std::move(mask);
        });
        for (size_t g = 0; g < slabs.size(); ++g) {
            voxel::SlabMask mask;
            voxeliser.coverage(slabs[g], &mask);
            EXPECT_EQ(masks[g].x0, mask.x0);
            EXPECT_EQ(masks[g].y0, mask.y0);
            EXPECT_EQ(masks[g].width, mask.width);
            EXPECT_EQ(masks[g].mask, mask.mask);
        }
        // Nothing outside the reported box.
        const Box3i box = voxeliser.voxel_box();
        for (int32_t z = 0; z < grid.size.z; ++z) {
            for (int32_t y = 0; y < grid.size.y; ++y) {
                for (int32_t x = 0; x < grid.size.x; ++x) {
                    if (expected[index(grid.size, x, y, z)] == 0) continue;
                    ASSERT_TRUE(x >= box.lo.x && x < box.hi.x && y >= box.lo.y && y < box.hi.y &&
                                z >= box.lo.z && z < box.hi.z);
                }
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Coverage, ::testing::ValuesIn(testing::scenarios()),
                         [](const auto& info) {
                             std::string name = info.param.name;
                             for (char& c : name)
                                 c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                             return name;
                         });

/// A random tetrahedral cut of a box: parts that share their inner faces exactly.
std::vector<mesh::Mesh> cut_box(uint32_t seed) {
    std::mt19937 random(seed);
    const auto number = [&] { return static_cast<double>(random() % 1001) / 1000; };
    std::vector<Vec3d> p;
    for (int32_t i = 0; i < 8; ++i) {
        p.push_back({i & 1 ? 3.0 + number() : number(), i & 2 ? 3.0 + number() : number(),
                     i & 4 ? 3.0 + number() : number()});
    }
    // Half of the cuts run through voxel centers exactly.
    if (seed % 2 == 0) {
        for (Vec3d& v : p)
            v = {std::round(v.x * 4) / 4 + 0.125, std::round(v.y * 4) / 4 + 0.125,
                 std::round(v.z * 4) / 4 + 0.125};
    }
    // The center and the 12 triangles of the outside make 12 tetrahedra.
    p.push_back({2 + 0.25 * std::floor(number() * 3), 2, 2});
    const std::vector<std::array<int32_t, 3>> outside{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                      {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                      {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    std::vector<mesh::Mesh> out;
    for (const auto& t : outside) {
        mesh::Mesh mesh;
        mesh.name = "cut";
        mesh.positions = p;
        mesh.triangles = {t, {t[0], 8, t[1]}, {t[1], 8, t[2]}, {t[2], 8, t[0]}};
        for (auto& triangle : mesh.triangles)
            std::swap(triangle[1], triangle[2]);
        if (testing::signed_volume(mesh) < 0) {
            for (auto& triangle : mesh.triangles)
                std::swap(triangle[1], triangle[2]);
        }
        out.push_back(mesh);
    }
    return out;
}

TEST(TouchingParts, ShareNoVoxelAndLeaveNoGap) {
    for (uint32_t seed = 1; seed <= 12; ++seed) {
        const std::vector<mesh::Mesh> cuts = cut_box(seed);
        const part::Grid grid{{0, 0, 0}, {0.25, 0.25, 0.25}, {18, 18, 18}};
        std::vector<int> owners(index(grid.size, 0, 0, grid.size.z), 0);
        mesh::Mesh whole = cuts[0];
        whole.triangles.clear();
        for (const mesh::Mesh& cut : cuts) {
            whole.triangles.push_back(cut.triangles[0]);
            // Parts are stored relative to their own centers, so vertices are multiples of 2^-6 mm,
            // which are exact.
            mesh::Mesh mesh = cut;
            for (Vec3d& v : mesh.positions) {
                for (int axis = 0; axis < 3; ++axis)
                    v[axis] = std::round(v[axis] * 64) / 64;
            }
            const auto v = voxels(testing::make_part(testing::empty_fablet(), mesh), grid);
            for (size_t i = 0; i < v.size(); ++i)
                owners[i] += v[i];
        }
        for (Vec3d& v : whole.positions) {
            for (int axis = 0; axis < 3; ++axis)
                v[axis] = std::round(v[axis] * 64) / 64;
        }
        const auto uncut = voxels(testing::make_part(testing::empty_fablet(), whole), grid);
        int64_t solid = 0;
        for (size_t i = 0; i < uncut.size(); ++i) {
            ASSERT_EQ(owners[i], uncut[i]) << "seed " << seed << " voxel " << i;
            solid += uncut[i];
        }
        EXPECT_GT(solid, 1000);
    }
}

}  // namespace
}  // namespace openfab
