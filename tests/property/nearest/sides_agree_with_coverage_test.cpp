// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries classify voxel centers as inside or outside like the voxeliser: for nested shells,
// self-intersecting displacements, thin walls, and centers on the surface. The voxeliser's vertices
// are snapped, so a center as close to the surface as that may differ, unless the vertices are
// where they are snapped to.

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/winding.h"
#include "runtime/nearest/voxel_center.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/surface/grid_over.h"
#include "tests/support/surface/worlds.h"

namespace openfab::nearest {
namespace {

struct Sides {
    int64_t inside = 0, outside = 0, differ = 0;
    int64_t on_surface = 0;  ///< centers whose distance is 0
    double farthest = 0;     ///< distance of a center whose sides differ, in voxels
};

/// Compares all voxels of the grid.
Sides compare(const part::Part& part, const surface::Surface& surface, const part::Grid& grid) {
    const auto frame = part::make_frame(part, grid);
    const auto engine = make_block_engine(surface, frame);
    const auto scratch = engine->make_scratch();
    const Winding winding(surface);
    Winding::Memory memory;
    const voxel::Voxeliser voxeliser(part, surface, grid);
    const Vec3i base = part::part_base_voxel(part, grid);
    const double pitch = std::min({grid.pitch_mm.x, grid.pitch_mm.y, grid.pitch_mm.z});
    Sides sides;
    voxel::SlabMask mask;
    for (int32_t slab = 0; 8 * slab < grid.size.z; ++slab) {
        voxeliser.coverage(slab, &mask);
        for (int32_t y = 0; y < grid.size.y; ++y) {
            for (int32_t x = 0; x < grid.size.x; ++x) {
                PointPacket points;
                points.mask = 0;
                for (int32_t l = 0; l < 8 && 8 * slab + l < grid.size.z; ++l) {
                    const Vec3f p = voxel_center(frame, Vec3i{x, y, 8 * slab + l} - base);
                    for (int a = 0; a < 3; ++a)
                        points.p[a][l] = p[a];
                    points.mask |= 1u << l;
                }
                PointAnswer answer;
                engine->query_points({&points, 1}, std::numeric_limits<float>::infinity(),
                                     scratch.get(), &answer);
                const uint32_t inside = winding.inside(points, answer, {}, &memory);
                const int32_t mx = x - mask.x0, my = y - mask.y0;
                const bool in_mask = mx >= 0 && my >= 0 && mx < mask.width && my < mask.height;
                const uint32_t solid =
                    in_mask ? mask.mask[static_cast<size_t>(my * mask.width + mx)] : 0;
                for (int32_t l = 0; l < 8; ++l) {
                    if ((points.mask >> l & 1u) == 0) continue;
                    const bool differ = ((inside ^ solid) >> l & 1u) != 0;
                    const double d = std::sqrt(static_cast<double>(answer.distance2[l]));
                    ++((solid >> l & 1u) != 0 ? sides.inside : sides.outside);
                    sides.on_surface += d == 0 ? 1 : 0;
                    if (!differ) continue;
                    ++sides.differ;
                    sides.farthest = std::max(sides.farthest, d / pitch);
                }
            }
        }
    }
    return sides;
}

std::unique_ptr<surface::Surface> make_surface(const part::Part& part, double micro_edge_mm) {
    surface::SurfaceOptions options;
    options.micro_edge_mm = std::max(micro_edge_mm, 0.2);
    return std::move(*surface::Surface::create(part, options));
}

class SidesAgree : public ::testing::TestWithParam<testing::Scenario> {};

TEST_P(SidesAgree, ExceptWithinTheSnapping) {
    for (const bool on_centers : {false, true}) {
        const part::Part part = make_part(GetParam());
        const auto surface = make_surface(part, GetParam().micro_edge_mm);
        const part::Grid grid =
            testing::grid_over(surface->exact_box(part.local_to_build), on_centers, {1, 1.7, 1});
        const Sides sides = compare(part, *surface, grid);
        EXPECT_GT(sides.inside + sides.outside, 1000);
        // Vertices move by 1/512 of a voxel along each axis.
        EXPECT_LE(sides.farthest, 1.7 / 256) << sides.differ << " differ";
        // Few are that close, unless faces lie on centers.
        if (!on_centers) {
            EXPECT_LE(sides.differ, (sides.inside + sides.outside) / 500);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, SidesAgree, ::testing::ValuesIn(testing::scenarios()),
                         [](const auto& info) {
                             std::string name = info.param.name;
                             for (char& c : name)
                                 c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                             return name;
                         });

/// Boxes whose faces, edges and corners lie on voxel centers: snapping moves nothing, so no voxel
/// may differ, least of all those on the surface.
TEST(SidesAgreeOnTheSurface, AtEveryVoxel) {
    using testing::cube;
    using testing::inside_out;
    using testing::joined;
    const mesh::Mesh thin = testing::card(3, 2, 0.125);
    for (const mesh::Mesh& mesh :
         {cube(2), thin, joined(cube(3), inside_out(cube(1)), {1, 1, 1}),
          joined(cube(3), cube(1), {1, 1, 1}), joined(cube(2), cube(2), {1, 1, 1}),
          joined(cube(1), cube(1), {1, 1, 0}), joined(cube(1), cube(1), {1, 0, 0})}) {
        // Nothing is displaced by an amplitude of 0.
        const part::Part part =
            testing::make_part(testing::Scenario{"boxes", mesh, testing::HandMode::kBack, 0, 0.2});
        const auto surface = make_surface(part, 0.2);
        const part::Grid grid =
            testing::grid_over(surface->exact_box(part.local_to_build), true, {1, 1, 1});
        const Sides sides = compare(part, *surface, grid);
        EXPECT_EQ(sides.differ, 0);
        EXPECT_GT(sides.on_surface, 300);
        EXPECT_GT(sides.inside, 300);
    }
}

}  // namespace
}  // namespace openfab::nearest
