// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Attributes with seams: at every voxel they are those of the triangle that wins, though each
// triangle has a uv and an int of its own and the nearest point mostly lies on an edge or a vertex
// of several.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/attributes.h"
#include "tests/support/reference/brute_force.h"
#include "tests/support/surface/grid_over.h"
#include "tests/support/surface/worlds.h"

namespace openfab::nearest {
namespace {

/// u lies between t and t + 0.5 on triangle t, and its int is t.
mesh::Mesh with_seams_everywhere(mesh::Mesh mesh) {
    for (mesh::MeshAttribute& a : mesh.attributes) {
        if (a.name == "uv") {
            a.values.clear();
            a.corners.clear();
            for (size_t t = 0; t < mesh.triangles.size(); ++t) {
                const auto first = static_cast<int32_t>(a.values.size() / 2);
                const float u = static_cast<float>(t);
                a.values.insert(a.values.end(),
                                {u + 0.125f, 0.25f, u + 0.375f, 0.75f, u + 0.25f, -1.0f});
                a.corners.push_back({first, first + 1, first + 2});
            }
        }
        if (a.name == "face") {
            for (size_t t = 0; t < a.faces.size(); ++t)
                a.faces[t] = static_cast<int32_t>(t);
        }
    }
    return mesh;
}

struct Counts {
    int64_t voxels = 0, on_edges = 0, triangles = 0;
};

/// All blocks over the part.
Counts check(const part::Part& part, const surface::Surface& surface) {
    const part::Grid grid =
        testing::grid_over(surface.exact_box(part.local_to_build), true, {1, 1, 1});
    const auto frame = part::make_frame(part, grid);
    const auto engine = make_block_engine(surface, frame);
    const auto twin = reference::make_brute_force_engine(surface, frame);
    const auto scratch = engine->make_scratch(), twin_scratch = twin->make_scratch();
    const AttributeReader reader(surface, frame);
    AttributeReader::Scratch reader_scratch;
    const Vec3i base = part::part_base_voxel(part, grid);
    BlockAnswer got, want;
    std::vector<float> u(kBlockVoxels), v(kBlockVoxels);
    std::vector<uint32_t> face(kBlockVoxels);
    float* values[] = {u.data(), v.data()};
    uint32_t* flat[] = {face.data()};
    Counts counts;
    std::vector<bool> seen(part.mesh->triangles.size(), false);
    for (int32_t z = 0; z < grid.size.z; z += 8) {
        for (int32_t y = 0; y < grid.size.y; y += 8) {
            for (int32_t x = 0; x < grid.size.x; x += 8) {
                const BlockQuery query{Vec3i{x, y, z} - base};
                engine->query(query, scratch.get(), &got);
                twin->query(query, twin_scratch.get(), &want);
                reader.read(got, nullptr, {values, nullptr, flat}, &reader_scratch);
                for (size_t i = 0; i < kBlockVoxels; ++i) {
                    const auto mesh = surface.micro(want.item[i]);
                    const auto& corners = mesh->triangles[want.in_patch.triangle[i]];
                    const auto attribute = [&](size_t corner, size_t component) {
                        return mesh->vertex_attributes[2 * static_cast<size_t>(corners[corner]) +
                                                       component];
                    };
                    for (size_t c = 0; c < 2; ++c) {
                        const float a = attribute(0, c);
                        const float at = (a + want.in_patch.bary1[i] * (attribute(1, c) - a)) +
                                         want.in_patch.bary2[i] * (attribute(2, c) - a);
                        EXPECT_EQ(values[c][i], at);
                    }
                    const int32_t t = surface.patches()[want.item[i]].triangle;
                    if (t < 0) continue;  // a strip between two triangles
                    EXPECT_EQ(std::floor(u[i]), static_cast<float>(t));
                    EXPECT_EQ(face[i], static_cast<uint32_t>(t));
                    seen[t] = true;
                    ++counts.voxels;
                    const float rest = 1 - want.in_patch.bary1[i] - want.in_patch.bary2[i];
                    counts.on_edges +=
                        want.in_patch.bary1[i] == 0 || want.in_patch.bary2[i] == 0 || rest == 0 ? 1
                                                                                                : 0;
                    if (::testing::Test::HasFailure()) return counts;
                }
            }
        }
    }
    counts.triangles = std::count(seen.begin(), seen.end(), true);
    return counts;
}

/// Nothing is displaced by an amplitude of 0, and the fablet knows it.
Counts check(const mesh::Mesh& mesh, testing::HandMode mode, float amplitude_mm) {
    const part::Part part = testing::make_part(
        testing::Scenario{"seams", with_seams_everywhere(mesh), mode, amplitude_mm, 0.5});
    surface::SurfaceOptions options;
    options.micro_edge_mm = 0.5;
    const auto surface = std::move(*surface::Surface::create(part, options));
    return check(part, *surface);
}

TEST(AttributesAreTheWinners, OnIdentitySurfaces) {
    // Faces of two triangles, on whose diagonals, edges and corners centers are nearest.
    const Counts cube = check(testing::cube(2), testing::HandMode::kBack, 0);
    EXPECT_GT(cube.on_edges, cube.voxels / 50);
    const Counts torus = check(testing::torus(2, 0.7, 13, 7), testing::HandMode::kBack, 0);
    EXPECT_GT(torus.on_edges, torus.voxels / 50);
    const Counts shaken =
        check(testing::shaken(testing::torus(2, 0.7, 9, 6), 3, 0.1), testing::HandMode::kBack, 0);
    EXPECT_GT(shaken.triangles, 50);
}

TEST(AttributesAreTheWinners, OnDisplacedSurfaces) {
    // The back is the triangle with face 1 alone.
    check(testing::cube(2), testing::HandMode::kBack, 0.2f);
    const Counts bumps = check(testing::torus(2, 0.7, 13, 7), testing::HandMode::kBumps, 0.2f);
    EXPECT_GT(bumps.triangles, 100);
    EXPECT_GT(bumps.on_edges, bumps.voxels / 50);
}

}  // namespace
}  // namespace openfab::nearest
