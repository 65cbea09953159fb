// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// A mesh large enough to use several threads in every part of the set-up gives the same results on
// one: the mesh read, coverage, and answers of queries.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>

#include "mesh/load/load_mesh.h"
#include "runtime/nearest/engine.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/meshes/meshes.h"

namespace openfab {
namespace {

/// A ring as a binary STL, with separate corners, so that loading welds them.
std::string ring_stl(int nu, int nv) {
    const testing::TriangleMesh mesh = testing::make_torus(nu, nv, 15, 6);
    std::string out(80, ' ');
    const auto put = [&](const void* data, size_t bytes) {
        out.append(static_cast<const char*>(data), bytes);
    };
    const auto count = static_cast<uint32_t>(mesh.triangles.size());
    put(&count, 4);
    for (const auto& t : mesh.triangles) {
        const float normal[3] = {};
        put(normal, sizeof normal);
        for (const int32_t v : t)
            put(&mesh.positions[v], 12);
        const uint16_t attribute = 0;
        put(&attribute, 2);
    }
    return out;
}

struct Ready {
    mesh::Mesh mesh;
    std::vector<std::vector<uint8_t>> coverage;
    std::vector<nearest::BlockAnswer> answers;
};

Ready set_up(const std::string& stl, size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Ready out;
    mesh::MeshOptions options;
    options.name = "ring";
    auto loaded = mesh::parse_mesh(stl, "ring.stl", options);
    EXPECT_TRUE(loaded) << loaded.error().text();
    out.mesh = std::move(loaded->mesh);
    const part::Part part = testing::make_part(testing::empty_fablet(), out.mesh);
    const part::Grid grid = testing::grid_around(part, {0.4, 0.4, 0.4});
    const auto surface = std::move(*surface::Surface::create(part, {}));
    const voxel::Voxeliser voxels(part, *surface, grid);
    voxel::SlabMask mask;
    for (int32_t slab = 0; 8 * slab < grid.size.z; ++slab) {
        voxels.coverage(slab, &mask);
        out.coverage.push_back(mask.mask);
    }
    const auto engine = nearest::make_block_engine(*surface, part::make_frame(part, grid));
    const auto scratch = engine->make_scratch();
    const Vec3i base = part::part_base_voxel(part, grid);
    for (int32_t x = 0; x < grid.size.x; x += 16) {
        for (int32_t y = 0; y < grid.size.y; y += 16)
            engine->query({Vec3i{x, y, grid.size.z / 2} - base}, scratch.get(),
                          &out.answers.emplace_back());
    }
    return out;
}

TEST(AnyThreadCount, SetsUpALargeMeshTheSame) {
#ifdef OPENFAB_SANITIZED
    const std::string stl = ring_stl(300, 100);
#else
    const std::string stl = ring_stl(700, 250);
#endif
    const Ready one = set_up(stl, 1);
    EXPECT_EQ(one.mesh.positions.size() * 2, one.mesh.triangles.size());
    EXPECT_GT(one.answers.size(), 30u);
    for (const size_t threads : {2, 7}) {
        const Ready many = set_up(stl, threads);
        EXPECT_EQ(many.mesh.positions, one.mesh.positions);
        EXPECT_EQ(many.mesh.triangles, one.mesh.triangles);
        EXPECT_EQ(many.coverage, one.coverage);
        ASSERT_EQ(many.answers.size(), one.answers.size());
        for (size_t i = 0; i < one.answers.size(); ++i)
            EXPECT_EQ(std::memcmp(&many.answers[i], &one.answers[i], sizeof one.answers[i]), 0);
    }
}

}  // namespace
}  // namespace openfab
