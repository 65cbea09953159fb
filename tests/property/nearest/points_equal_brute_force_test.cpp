// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries at arbitrary points give the same bits as plain loops over all triangles, and at voxel
// centers the same as the block query.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/infinity.h"
#include "runtime/nearest/engine.h"
#include "simd/isa.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/places/places.h"
#include "tests/support/reference/brute_force.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

#ifdef OPENFAB_SANITIZED
constexpr int kPackets = 60;
#else
constexpr int kPackets = 400;
#endif

/// Packets around a mesh: a walk of close points, scattered points, points on vertices and edges,
/// and some that are far away or not finite.
std::vector<PointPacket> make_packets(const TriangleMesh& mesh, int count, uint32_t seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    const Box3f box = mesh.box();
    const Vec3f size = box.size();
    std::vector<PointPacket> packets(static_cast<size_t>(count));
    Vec3f at = box.center();
    for (size_t g = 0; g < packets.size(); ++g) {
        packets[g].mask = g % 5 == 4 ? random() & 0xff : 0xff;
        for (size_t l = 0; l < 8; ++l) {
            Vec3f p;
            for (int a = 0; a < 3; ++a)
                p[a] = box.lo[a] + (uniform() * 1.6f - 0.3f) * size[a];
            const auto vertex = [&] { return mesh.positions[random() % mesh.positions.size()]; };
            if (g % 4 < 2) {
                for (int a = 0; a < 3; ++a)
                    at[a] += (uniform() - 0.5f) * 0.03f * size[a];
                if (!box.empty() && random() % 40 == 0) at = p;
                p = at;
            } else if (g % 4 == 2 && l % 2 == 0) {
                p = l % 4 == 0 ? vertex() : (vertex() + vertex()) * 0.5f;
            }
            if (random() % 97 == 0) p = p * 1e6f;
            if (random() % 131 == 0) p[static_cast<int>(l % 3)] = l < 4 ? kInfinity : std::nanf("");
            if (random() % 131 == 0) p[static_cast<int>(l % 3)] = -3e38f;
            for (size_t a = 0; a < 3; ++a)
                packets[g].p[a][l] = p[static_cast<int>(a)];
        }
    }
    return packets;
}

std::vector<PointAnswer> run(const Engine& engine, const std::vector<PointPacket>& packets,
                             float radius) {
    std::vector<PointAnswer> answers(packets.size());
    const auto scratch = engine.make_scratch();
    // In calls of one packet and of many packets.
    const size_t half = packets.size() / 2;
    engine.query_points({packets.data(), half}, radius, scratch.get(), answers.data());
    for (size_t g = half; g < packets.size(); ++g)
        engine.query_points({packets.data() + g, 1}, radius, scratch.get(), answers.data() + g);
    return answers;
}

void expect_equal(const std::vector<PointAnswer>& got, const std::vector<PointAnswer>& want,
                  const char* what) {
    for (size_t g = 0; g < want.size(); ++g) {
        for (size_t l = 0; l < 8; ++l) {
            ASSERT_TRUE(std::memcmp(&got[g].distance2[l], &want[g].distance2[l], 4) == 0 &&
                        got[g].item[l] == want[g].item[l] &&
                        got[g].in_patch.triangle[l] == want[g].in_patch.triangle[l] &&
                        std::memcmp(&got[g].in_patch.bary1[l], &want[g].in_patch.bary1[l], 4) ==
                            0 &&
                        std::memcmp(&got[g].in_patch.bary2[l], &want[g].in_patch.bary2[l], 4) == 0)
                << what << ", packet " << g << " lane " << l << ": " << got[g].distance2[l]
                << " of " << got[g].item[l] << "/" << got[g].in_patch.triangle[l] << " and "
                << want[g].distance2[l] << " of " << want[g].item[l] << "/"
                << want[g].in_patch.triangle[l];
        }
    }
}

void check(const surface::Surface& surface, const TriangleMesh& mesh, uint32_t seed,
           const BlockEngineOptions& options = {}) {
    const auto frame = testing::make_test_frame({0.1f, 0.1f, 0.1f}, {});
    const std::vector<PointPacket> packets = make_packets(mesh, kPackets, seed);
    const auto brute = reference::make_brute_force_engine(surface, frame);
    for (const float radius : {kInfinity, length(mesh.box().size()) * 0.05f}) {
        const auto want = run(*brute, packets, radius);
        for (const simd::Isa set : {simd::Isa::kAvx512, simd::Isa::kAvx2Fma, simd::Isa::kSse41}) {
            BlockEngineOptions with_set = options;
            with_set.widest = set;
            const auto engine = make_block_engine(surface, frame, with_set);
            expect_equal(run(*engine, packets, radius), want, testing::name_of(set));
        }
    }
}

TEST(PointsEqualBruteForce, RandomSoups) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = testing::make_soup(seed, 150, 2.0f, seed % 2 == 0 ? 0.3f : 2.0f);
        check(MeshSurface(mesh), mesh, seed);
    }
}

TEST(PointsEqualBruteForce, CellsOfAGrid) {
    const std::vector<Vec3i> cells = {{0, 0, 0}, {1, 0, 0},  {1, 1, 0}, {0, 0, 1},
                                      {2, 2, 0}, {-2, 0, 0}, {-3, 1, 1}};
    const TriangleMesh mesh = testing::make_cells(cells, 1.0f);
    check(MeshSurface(mesh), mesh, 3);
}

TEST(PointsEqualBruteForce, FarFromTheOrigin) {
    TriangleMesh mesh = testing::make_ball(8, [](const Vec3d&) { return 0.6; });
    for (Vec3f& p : mesh.positions)
        p = p + Vec3f{150, -90, 40};
    check(MeshSurface(mesh), mesh, 5);
}

TEST(PointsEqualBruteForce, PatchesDicedOnDemandUnderASmallCache) {
    const TriangleMesh mesh = testing::make_torus(40, 20, 1.2, 0.5);
    for (const size_t cache_bytes : {size_t{0}, size_t{1} << 30}) {
        BlockEngineOptions options;
        options.cache_bytes = cache_bytes;
        check(MeshSurface(mesh, 50, 0.4f), mesh, 11, options);
        check(MeshSurface(mesh, 450, 0.4f), mesh, 11, options);
    }
}

TEST(PointsEqualBruteForce, ScannedMeshes) {
    for (const std::string name : {"spot", "goathead", "scorpion"}) {
        const TriangleMesh mesh = testing::read_obj(
            (testing::source_dir() / "tests/data/meshes/").string() + name + ".obj", 5.0);
        ASSERT_FALSE(mesh.triangles.empty()) << name;
        SCOPED_TRACE(name);
        const MeshSurface surface(mesh);
        const auto frame = testing::make_test_frame({0.1f, 0.1f, 0.1f}, {});
        const std::vector<PointPacket> packets = make_packets(mesh, kPackets / 10, 17);
        const auto want =
            run(*reference::make_brute_force_engine(surface, frame), packets, kInfinity);
        expect_equal(run(*make_block_engine(surface, frame), packets, kInfinity), want, "engine");
    }
}

TEST(PointsEqualBruteForce, BoundsHoldTheDistance) {
    constexpr float kOff = 0.02f;
    for (const TriangleMesh& mesh :
         {testing::make_soup(2, 150, 2.0f, 0.3f), testing::make_torus(40, 20, 1.2, 0.5)}) {
        const MeshSurface surface(mesh);
        const auto frame = testing::make_test_frame({0.1f, 0.1f, 0.1f}, {});
        std::vector<PointPacket> packets = make_packets(mesh, kPackets, 23);
        for (PointPacket& g : packets) {
            g.mask = 0xff;
            for (auto& coordinate : g.p) {
                for (float& x : coordinate)
                    x = std::abs(x) < 100 ? x : 0;
            }
        }
        const auto brute = reference::make_brute_force_engine(surface, frame);
        const auto want = run(*brute, packets, kInfinity);
        for (const simd::Isa set : {simd::Isa::kAvx512, simd::Isa::kAvx2Fma, simd::Isa::kSse41}) {
            const auto engine = make_block_engine(surface, frame, {.widest = set});
            // Without hints, and with the points found before as hints, except in one lane.
            std::vector<PointPacket> near;
            for (const bool seeded : {false, true}) {
                SCOPED_TRACE(seeded ? "seeded" : "alone");
                std::vector<PointBounds> bounds(packets.size());
                engine->bound_points(packets, near, kOff, engine->make_scratch().get(),
                                     bounds.data());
                size_t tight = 0, compared = 0;
                for (size_t g = 0; g < packets.size(); ++g) {
                    PointPacket found;
                    std::copy_n(&bounds[g].point[0][0], 24, &found.p[0][0]);
                    const PointAnswer at = run(*brute, {found}, kInfinity).front();
                    for (size_t l = 0; l < 8; ++l) {
                        const float distance = std::sqrt(want[g].distance2[l]);
                        const float low = bounds[g].low[l], high = bounds[g].high[l];
                        ASSERT_LE(low, distance) << "packet " << g << " lane " << l;
                        ASSERT_GE(high, distance) << "packet " << g << " lane " << l;
                        float way2 = 0;
                        for (size_t a = 0; a < 3; ++a) {
                            const float way = packets[g].p[a][l] - found.p[a][l];
                            way2 += way * way;
                        }
                        ASSERT_NEAR(std::sqrt(way2), high, 1e-4f);
                        ASSERT_LT(at.distance2[l], 1e-8f) << "not a point of the surface";
                        // Packets after a walk start near its results; after scattered points
                        // nothing is known about the surface, and bounds may be loose.
                        if (seeded ? l != 3 : g % 4 == 1) {
                            ++compared;
                            tight += high - low < 2 * kOff ? 1 : 0;
                        }
                    }
                    for (auto& coordinate : found.p)
                        coordinate[3] = kInfinity;
                    if (!seeded) near.push_back(found);
                }
                EXPECT_GT(tight * 4, compared * 3) << tight << " of " << compared;
            }
        }
    }
}

TEST(PointsEqualBruteForce, VoxelCentresGiveTheBlockAnswer) {
    const TriangleMesh mesh = testing::make_torus(48, 24, 0.6, 0.25);
    const MeshSurface surface(mesh);
    const auto frame = testing::make_test_frame({0.0625f, 0.03125f, 0.125f}, {});
    const auto engine = make_block_engine(surface, frame);
    const auto scratch = engine->make_scratch();
    BlockAnswer block;
    engine->query({{-8, 4, -4}}, scratch.get(), &block);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
            PointPacket packet;
            for (int z = 0; z < 8; ++z) {
                packet.p[0][z] = (static_cast<float>(x - 8) + 0.5f) * 0.0625f;
                packet.p[1][z] = (static_cast<float>(y + 4) + 0.5f) * 0.03125f;
                packet.p[2][z] = (static_cast<float>(z - 4) + 0.5f) * 0.125f;
            }
            PointAnswer answer;
            engine->query_points({&packet, 1}, kInfinity, scratch.get(), &answer);
            for (int z = 0; z < 8; ++z) {
                const int v = (y * 8 + x) * 8 + z;
                ASSERT_EQ(answer.distance2[z], block.distance2[v]);
                ASSERT_EQ(answer.item[z], block.item[v]);
                ASSERT_EQ(answer.in_patch.bary1[z], block.in_patch.bary1[v]);
            }
        }
    }
}

}  // namespace
}  // namespace openfab::nearest
