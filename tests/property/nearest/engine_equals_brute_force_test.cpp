// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The block engine gives the same bits as plain loops over all triangles: distance, patch,
// triangle, barycentrics.

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "base/infinity.h"
#include "runtime/nearest/engine.h"
#include "simd/isa.h"
#include "tests/support/long_run.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/places/places.h"
#include "tests/support/reference/brute_force.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

struct Asked {
    Vec3f pitch{0.1f, 0.1f, 0.1f};
    Vec3f origin{};
    Vec3i lowest, blocks;  ///< in voxels, and how many blocks along each axis
    float radius = kInfinity;
    bool random_demand = false;
    bool prepared = false;  ///< blocks are prepared together
    bool turned = false;    ///< the voxel axes are not those of the part
};

/// Up to `most` blocks per axis, spread over the mesh's box and a little beyond.
Asked cover(const TriangleMesh& mesh, const Vec3f& pitch, int most) {
    Asked s;
    s.pitch = pitch;
    const Box3f box = mesh.box();
    for (int a = 0; a < 3; ++a) {
        s.lowest[a] = static_cast<int32_t>(std::floor(box.lo[a] / pitch[a])) - 9;
        s.blocks[a] = std::min(most, static_cast<int32_t>(box.size()[a] / (8 * pitch[a])) + 3);
    }
    return s;
}

std::vector<BlockQuery> make_queries(const Asked& s, std::vector<std::array<uint8_t, 64>>* demand) {
    std::vector<BlockQuery> queries;
    std::mt19937 random(7);
    const int32_t count = s.blocks.x * s.blocks.y * s.blocks.z;
    demand->resize(static_cast<size_t>(count));
    for (auto& bytes : *demand) {
        for (auto& b : bytes)
            b = static_cast<uint8_t>((random() & random()) >> 7);
        if (random() % 4 == 0) std::fill(bytes.begin(), bytes.begin() + 32, 0);
    }
    for (int32_t k = 0; k < s.blocks.z; ++k) {
        for (int32_t j = 0; j < s.blocks.y; ++j) {
            for (int32_t i = 0; i < s.blocks.x; ++i) {
                BlockQuery q;
                q.block = s.lowest + Vec3i{8 * i, 8 * j, 8 * k};
                q.radius_mm = s.radius;
                if (s.random_demand) q.active = (*demand)[queries.size()].data();
                queries.push_back(q);
            }
        }
    }
    return queries;
}

/// First difference as text, or empty.
std::string compare(const BlockAnswer& a, const BlockAnswer& b, const BlockQuery& q) {
    for (int v = 0; v < kBlockVoxels; ++v) {
        if (std::memcmp(&a.distance2[v], &b.distance2[v], 4) == 0 && a.item[v] == b.item[v] &&
            a.in_patch.triangle[v] == b.in_patch.triangle[v] &&
            std::memcmp(&a.in_patch.bary1[v], &b.in_patch.bary1[v], 4) == 0 &&
            std::memcmp(&a.in_patch.bary2[v], &b.in_patch.bary2[v], 4) == 0) {
            continue;
        }
        std::ostringstream text;
        text.precision(9);
        text << "block " << q.block.x << " " << q.block.y << " " << q.block.z << " voxel " << v
             << ": " << a.distance2[v] << " of " << a.item[v] << "/" << a.in_patch.triangle[v]
             << " (" << a.in_patch.bary1[v] << ", " << a.in_patch.bary2[v] << ") and "
             << b.distance2[v] << " of " << b.item[v] << "/" << b.in_patch.triangle[v] << " ("
             << b.in_patch.bary1[v] << ", " << b.in_patch.bary2[v] << ")";
        return text.str();
    }
    return {};
}

std::vector<BlockAnswer> run(const Engine& engine, const std::vector<BlockQuery>& queries,
                             bool prepared = false) {
    std::vector<BlockAnswer> answers(queries.size());
    const auto scratch = engine.make_scratch();
    if (prepared) {
        std::vector<Vec3i> blocks;
        for (const BlockQuery& q : queries)
            blocks.push_back(q.block);
        engine.prepare(blocks, scratch.get());
    }
    for (size_t i = 0; i < queries.size(); ++i)
        engine.query(queries[i], scratch.get(), &answers[i]);
    return answers;
}

void expect_equal(const std::vector<BlockAnswer>& got, const std::vector<BlockAnswer>& want,
                  const std::vector<BlockQuery>& queries, const char* what) {
    for (size_t i = 0; i < queries.size(); ++i) {
        const std::string difference = compare(got[i], want[i], queries[i]);
        ASSERT_EQ(difference, "") << what;
    }
}

// Brute force is slow: all blocks are compared in long runs, a third of them otherwise. Under a
// sanitizer most meshes get only the unbounded query, and only one scanned mesh is used.
#ifdef OPENFAB_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void check(const surface::Surface& surface, const Asked& setup,
           const std::vector<size_t>& cache_bytes = {BlockEngineOptions{}.cache_bytes},
           size_t most_pinned = nearest::kMaxPinnedBytes) {
    auto frame = testing::make_test_frame(setup.pitch, setup.origin);
    if (setup.turned) {
        constexpr float kTurn[3][3] = {{2, -1, 2}, {2, 2, -1}, {-1, 2, 2}};
        for (size_t a = 0; a < 3; ++a) {
            for (size_t c = 0; c < 3; ++c)
                frame[3 * a + c] = setup.pitch[static_cast<int>(a)] * kTurn[a][c] / 3;
        }
    }
    std::vector<std::array<uint8_t, 64>> demand;
    std::vector<BlockQuery> queries = make_queries(setup, &demand);
    if (kSanitized || !testing::long_run()) {
        for (size_t k = 0; 3 * k < queries.size(); ++k)
            queries[k] = queries[3 * k];
        queries.resize((queries.size() + 2) / 3);
    }
    const auto want = run(*reference::make_brute_force_engine(surface, frame), queries);
    for (const size_t bytes : cache_bytes) {
        for (const simd::Isa set : {simd::Isa::kAvx512, simd::Isa::kAvx2Fma, simd::Isa::kSse41}) {
            const auto cache = nearest::make_patch_cache(bytes);
            nearest::set_max_pinned(cache.get(), most_pinned);
            const auto engine = make_block_engine(surface, frame, {.cache = cache, .widest = set});
            expect_equal(run(*engine, queries, setup.prepared), want, queries,
                         testing::name_of(set));
        }
    }
}

void check_all_ways(const TriangleMesh& mesh, Asked setup) {
    const MeshSurface surface(mesh);
    check(surface, setup);
    if (kSanitized) return;
    for (const float radius : {setup.pitch.x * 3, setup.pitch.x * 20}) {
        setup.radius = radius;
        check(surface, setup);
    }
    setup.random_demand = true;
    check(surface, setup);
    setup.radius = kInfinity;
    setup.prepared = true;
    check(surface, setup);
}

TEST(EngineEqualsBruteForce, RandomSoups) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = testing::make_soup(seed, 150, 2.0f, seed % 2 == 0 ? 0.3f : 2.0f);
        check_all_ways(mesh, cover(mesh, {0.1f, 0.1f, 0.1f}, 4));
    }
}

TEST(EngineEqualsBruteForce, TurnedParts) {
    const TriangleMesh mesh = testing::make_ball(14, [](const Vec3d& d) {
        return 1 + 0.1 * std::sin(5 * d.x) * std::cos(6 * d.y + 2 * d.z);
    });
    Asked setup = cover(mesh, {0.042f, 0.085f, 0.027f}, 4);
    setup.lowest = {-16, -16, -16};
    setup.turned = true;
    check_all_ways(mesh, setup);
}

TEST(EngineEqualsBruteForce, GridAlignedWithVoxelsOnSymmetryPlanes) {
    // An L, a staircase and two cells that touch along an edge; with pitch 1/8 and cells of 1 mm,
    // voxel centers shifted by half a voxel lie on faces, edges, vertices and on the planes between
    // them.
    const std::vector<Vec3i> cells = {{0, 0, 0}, {1, 0, 0},  {1, 1, 0}, {0, 0, 1},
                                      {2, 2, 0}, {-2, 0, 0}, {-3, 1, 1}};
    const TriangleMesh mesh = testing::make_cells(cells, 1.0f);
    for (const float shift : {0.0f, -0.0625f}) {
        Asked setup = cover(mesh, {0.125f, 0.125f, 0.125f}, 9);
        setup.origin = {shift, shift, shift};
        check_all_ways(mesh, setup);
    }
}

TEST(EngineEqualsBruteForce, SphereToItsCentre) {
    const TriangleMesh mesh = testing::make_ball(12, [](const Vec3d&) { return 2.0; });
    check_all_ways(mesh, cover(mesh, {0.11f, 0.11f, 0.11f}, 4));
}

TEST(EngineEqualsBruteForce, TorusAtUnequalPitch) {
    const TriangleMesh mesh = testing::make_torus(40, 20, 0.6, 0.25);
    check_all_ways(mesh, cover(mesh, {0.042f, 0.085f, 0.027f}, 4));
}

TEST(EngineEqualsBruteForce, SubBlocksOfEveryShape) {
    const TriangleMesh mesh = testing::make_torus(24, 12, 0.6, 0.25);
    const Vec3f pitches[] = {
        {0.4f, 0.05f, 0.06f}, {0.05f, 0.4f, 0.05f}, {0.06f, 0.05f, 0.9f}, {0.1f, 0.1f, 0.04f}};
    for (const Vec3f& pitch : pitches) {
        const MeshSurface surface(mesh);
        Asked setup = cover(mesh, pitch, 3);
        check(surface, setup);
        setup.radius = 0.2f;
        check(surface, setup);
    }
}

TEST(EngineEqualsBruteForce, TrianglesFarLargerThanBlocks) {
    // Rounding errors grow with the triangles; voxels stay close to the surface, the edges' planes
    // and the vertices.
    for (const int n : {1, 2, 3}) {
        const TriangleMesh mesh = testing::make_ball(n, [](const Vec3d&) { return 45.0; });
        const MeshSurface surface(mesh);
        std::mt19937 random(static_cast<uint32_t>(n));
        for (int i = 0; i < 40; ++i) {
            const auto& t = mesh.triangles[random() % mesh.triangles.size()];
            const Vec3f a = mesh.positions[t[0]];
            const Vec3f b = mesh.positions[t[1]];
            const Vec3f p = i % 4 == 0 ? a : a + (b - a) * (static_cast<float>(i) / 40);
            Asked setup;
            setup.pitch = {0.05f, 0.05f, 0.05f};
            for (int k = 0; k < 3; ++k)
                setup.lowest[k] = static_cast<int32_t>(p[k] / setup.pitch[k]) - 8;
            setup.blocks = {2, 2, 2};
            check(surface, setup);
        }
    }
}

TEST(EngineEqualsBruteForce, TrianglesFarSmallerThanBlocks) {
    // Their features outnumber the voxels, so quarters of sub-blocks are searched on their own.
    const TriangleMesh torus = testing::make_torus(80, 40, 0.6, 0.25);
    for (const Vec3f& pitch : {Vec3f{0.1f, 0.1f, 0.1f}, Vec3f{0.12f, 0.05f, 0.2f}}) {
        check_all_ways(torus, cover(torus, pitch, 2));
        if (kSanitized) return;
    }
    // Ties everywhere: fine cells, voxel centers on their planes of symmetry.
    std::vector<Vec3i> cells;
    std::mt19937 random(3);
    for (int i = 0; i < 120; ++i)
        cells.push_back({static_cast<int32_t>(random() % 8), static_cast<int32_t>(random() % 8),
                         static_cast<int32_t>(random() % 8)});
    const TriangleMesh fine = testing::make_cells(cells, 0.25f);
    for (const float shift : {0.0f, -0.125f}) {
        Asked setup = cover(fine, {0.25f, 0.25f, 0.25f}, 2);
        setup.origin = {shift, shift, shift};
        check_all_ways(fine, setup);
    }
}

/// A flat open sheet of fine triangles, `cells` squares of `side` mm each way.
TriangleMesh make_sheet(int cells, float side) {
    TriangleMesh sheet;
    for (int y = 0; y <= cells; ++y) {
        for (int x = 0; x <= cells; ++x)
            sheet.add({static_cast<float>(x) * side, static_cast<float>(y) * side, 0});
    }
    for (int y = 0; y < cells; ++y) {
        for (int x = 0; x < cells; ++x) {
            const int32_t v = y * (cells + 1) + x, above = v + cells + 1;
            sheet.triangles.push_back({v, v + 1, above});
            sheet.triangles.push_back({v + 1, above + 1, above});
        }
    }
    return sheet;
}

TEST(EngineEqualsBruteForce, NeighboursThatTieByRoundingAlone) {
    // Voxel centers a little beside the lines over a sheet's vertices: there the vertex is as near
    // as the face below in float, although the nearest point is not at it.
    constexpr float kSide = 0.02f;
    const MeshSurface surface(make_sheet(80, kSide));
    for (const Vec3f& shift :
         {Vec3f{1e-4f, 1e-4f, 0}, Vec3f{-1e-4f, 0, 0}, Vec3f{-7e-5f, 1e-4f, 0}}) {
        Asked setup;
        setup.pitch = {10 * kSide, 10 * kSide, 10 * kSide};
        setup.origin = shift;
        setup.lowest = {0, 0, -8};
        setup.blocks = {1, 1, 2};
        // Less than half a block's diagonal, so that these are blocks near the surface.
        setup.radius = 50 * kSide;
        check(surface, setup);
    }
}

TEST(EngineEqualsBruteForce, BesideTheBorderOfASheet) {
    // Packets all in the plane of the sheet, inside and outside of it, and others far from it.
    constexpr float kSide = 0.02f;
    const TriangleMesh sheet = make_sheet(80, kSide);
    for (const int32_t per_patch : {0, 200}) {
        const MeshSurface surface(sheet, per_patch);
        Asked setup;
        setup.pitch = {10 * kSide, 10 * kSide, 45 * kSide};
        setup.origin = {0, 0, -22.5f * kSide};
        setup.lowest = {-4, -4, -4};
        setup.blocks = {2, 2, 1};
        setup.radius = 50 * kSide;
        check(surface, setup);
    }
}

TEST(EngineEqualsBruteForce, ThinPlate) {
    std::vector<Vec3i> cells;
    for (int y = 0; y < 12; ++y) {
        for (int x = 0; x < 12; ++x)
            cells.push_back({x, y, 0});
    }
    TriangleMesh mesh = testing::make_cells(cells, 0.25f);
    for (Vec3f& p : mesh.positions)
        p.z *= 0.2f;
    check_all_ways(mesh, cover(mesh, {0.042f, 0.085f, 0.027f}, 5));
}

TEST(EngineEqualsBruteForce, FarFromTheOrigin) {
    TriangleMesh mesh = testing::make_ball(8, [](const Vec3d&) { return 0.6; });
    for (Vec3f& p : mesh.positions)
        p = p + Vec3f{150, -90, 40};
    check_all_ways(mesh, cover(mesh, {0.042f, 0.085f, 0.027f}, 5));
}

TEST(EngineEqualsBruteForce, ScannedMeshes) {
    for (const std::string name : {"spot", "goathead", "scorpion"}) {
        if (kSanitized && name != "spot") continue;
        const TriangleMesh mesh = testing::read_obj(
            (testing::source_dir() / "tests/data/meshes/").string() + name + ".obj", 5.0);
        ASSERT_FALSE(mesh.triangles.empty()) << name;
        SCOPED_TRACE(name);
        const MeshSurface surface(mesh);
        Asked setup = cover(mesh, {0.17f, 0.17f, 0.06f}, 2);
        setup.lowest = {-8, -8, -8};
        check(surface, setup);
        setup.radius = 0.5f;
        check(surface, setup);
    }
}

TEST(EngineEqualsBruteForce, PatchesDicedOnDemandUnderASmallCache) {
    const TriangleMesh mesh = testing::make_torus(40, 20, 1.2, 0.5);
    for (const float loose : {0.0f, 0.4f}) {
        const MeshSurface surface(mesh, 50, loose);
        const std::vector<size_t> cache_bytes{0, 30000, size_t{1} << 30};
        Asked setup = cover(mesh, {0.1f, 0.1f, 0.1f}, 4);
        check(surface, setup, cache_bytes);
        setup.radius = 0.3f;
        setup.random_demand = true;
        check(surface, setup, cache_bytes);
        // Triangles far smaller than blocks.
        check(surface, cover(mesh, {0.3f, 0.3f, 0.3f}, 2), cache_bytes);
    }
}

TEST(EngineEqualsBruteForce, PatchesThatMayNotAllBeHeldAtOnce) {
    const TriangleMesh mesh = testing::make_torus(40, 20, 1.2, 0.5);
    const MeshSurface surface(mesh, 50, 0.4f);
    // One patch, and a few.
    for (const size_t most_pinned : {size_t{1}, size_t{60000}}) {
        Asked setup = cover(mesh, {0.1f, 0.1f, 0.1f}, 4);
        check(surface, setup, {size_t{1} << 30}, most_pinned);
        setup.radius = 0.3f;
        setup.random_demand = true;
        check(surface, setup, {30000}, most_pinned);
    }
}

TEST(EngineEqualsBruteForce, PatchesCutIntoPieces) {
    const TriangleMesh mesh = testing::make_torus(40, 20, 1.2, 0.5);
    // Four pieces each, the last three.
    const MeshSurface surface(mesh, 450, 0.4f);
    Asked setup = cover(mesh, {0.1f, 0.1f, 0.1f}, 4);
    check(surface, setup, {0, 100000, size_t{1} << 30});
    // A piece at once, and a few.
    for (const size_t most_pinned : {size_t{1}, size_t{60000}})
        check(surface, setup, {100000}, most_pinned);
    setup.radius = 0.3f;
    setup.random_demand = true;
    check(surface, setup, {100000}, 60000);
    // Triangles far smaller than blocks.
    check(surface, cover(mesh, {0.3f, 0.3f, 0.3f}, 2), {100000});
}

TEST(EngineEqualsBruteForce, OneScratchForSeveralEnginesAndRadii) {
    const TriangleMesh mesh = testing::make_torus(48, 24, 1.2, 0.5);
    const MeshSurface surface(mesh);
    const auto index = make_block_index(surface);
    std::vector<std::unique_ptr<Engine>> engines;
    for (const float shift : {0.0f, 0.31f}) {
        engines.push_back(make_block_engine(
            index, testing::make_test_frame({0.1f, 0.1f, 0.1f}, {shift, -shift, shift})));
    }
    Asked setup = cover(mesh, {0.1f, 0.1f, 0.1f}, 5);
    std::vector<std::array<uint8_t, 64>> demand;
    std::vector<BlockQuery> queries = make_queries(setup, &demand);
    // The small radius first: what it missed must not affect the large one.
    const auto scratch = engines[0]->make_scratch();
    for (BlockQuery& q : queries) {
        for (const float radius : {0.15f, 0.6f, kInfinity}) {
            q.radius_mm = radius;
            for (const auto& engine : engines) {
                BlockAnswer got, want;
                engine->query(q, scratch.get(), &got);
                engine->query(q, engine->make_scratch().get(), &want);
                ASSERT_EQ(compare(got, want, q), "") << radius;
            }
        }
    }
}

TEST(EngineEqualsBruteForce, AnyOrderAndAnyNumberOfThreads) {
    const TriangleMesh mesh = testing::make_torus(48, 24, 1.2, 0.5);
    const MeshSurface whole(mesh), diced(mesh, 40, 0.2f);
    for (const surface::Surface* surface : {static_cast<const surface::Surface*>(&whole),
                                            static_cast<const surface::Surface*>(&diced)}) {
        const Asked setup = cover(mesh, {0.1f, 0.1f, 0.1f}, 5);
        const auto frame = testing::make_test_frame(setup.pitch, setup.origin);
        std::vector<std::array<uint8_t, 64>> demand;
        const std::vector<BlockQuery> queries = make_queries(setup, &demand);
        BlockEngineOptions options;
        options.cache_bytes = 50000;
        const auto engine = make_block_engine(*surface, frame, options);
        const auto want = run(*engine, queries);
        // The 8 orders of ascending and descending x, y, z.
        for (int order = 1; order < 8; ++order) {
            std::vector<BlockAnswer> got(queries.size());
            const auto scratch = engine->make_scratch();
            const Vec3i n = setup.blocks;
            for (int32_t k = 0; k < n.z; ++k) {
                for (int32_t j = 0; j < n.y; ++j) {
                    for (int32_t i = 0; i < n.x; ++i) {
                        const int32_t x = (order & 1) != 0 ? n.x - 1 - i : i;
                        const int32_t y = (order & 2) != 0 ? n.y - 1 - j : j;
                        const int32_t z = (order & 4) != 0 ? n.z - 1 - k : k;
                        const auto at = static_cast<size_t>((z * n.y + y) * n.x + x);
                        engine->query(queries[at], scratch.get(), &got[at]);
                    }
                }
            }
            expect_equal(got, want, queries, "order");
        }
        std::vector<BlockAnswer> got(queries.size());
        std::vector<std::thread> threads;
        for (size_t t = 0; t < 2; ++t) {
            threads.emplace_back([&, t] {
                const auto scratch = engine->make_scratch();
                for (size_t i = t; i < queries.size(); i += 2)
                    engine->query(queries[i], scratch.get(), &got[i]);
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        expect_equal(got, want, queries, "threads");
    }
}

}  // namespace
}  // namespace openfab::nearest
