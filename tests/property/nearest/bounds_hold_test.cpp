// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What Engine::bounds says about a cube of voxels holds for each of its voxels: distance, and the
// attributes at nearest points; and what Engine::bound_blocks says of the pieces of blocks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/attributes.h"
#include "simd/isa.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/reference/brute_force.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

struct Looseness {
    double width = 0;  ///< mean width of the distance interval, in diagonals of the cube
    int cubes = 0;
};

bool falls_under_a_case(const BoxBounds& bounds, float distance, float x, float y, int32_t id) {
    for (int32_t k = 0; k < bounds.count; ++k) {
        const NearestCase& c = bounds.cases[k];
        if (distance >= c.distance_lo && x >= c.float_lo[0] - 1e-6f && x <= c.float_hi[0] + 1e-6f &&
            y >= c.float_lo[1] - 1e-6f && y <= c.float_hi[1] + 1e-6f && id >= c.int_lo[0] &&
            id <= c.int_hi[0]) {
            return true;
        }
    }
    return false;
}

/// Checks each block of the cube against the cube's bounds.
void check_cube(const Engine& engine, const AttributeReader& reader, const Vec3i& lowest,
                int32_t size, const Vec3f& pitch, Looseness* looseness) {
    const auto scratch = engine.make_scratch();
    BoxBounds bounds;
    engine.bounds(lowest, size, scratch.get(), &bounds);
    ASSERT_GT(bounds.count, 0);
    float least = bounds.distance_hi;
    for (int32_t k = 0; k < bounds.count; ++k)
        least = std::min(least, bounds.cases[k].distance_lo);
    looseness->width += (bounds.distance_hi - least) / (length(pitch) * static_cast<float>(size));
    ++looseness->cubes;
    AttributeReader::Scratch reader_scratch;
    BlockAnswer answer;
    std::vector<float> x(kBlockVoxels), y(kBlockVoxels);
    std::vector<uint32_t> id(kBlockVoxels);
    float* values[] = {x.data(), y.data()};
    uint32_t* flat[] = {id.data()};
    for (int32_t k = 0; k < size; k += 8) {
        for (int32_t j = 0; j < size; j += 8) {
            for (int32_t i = 0; i < size; i += 8) {
                engine.query({lowest + Vec3i{i, j, k}}, scratch.get(), &answer);
                reader.read(answer, nullptr, {values, nullptr, flat}, &reader_scratch);
                for (size_t v = 0; v < kBlockVoxels; ++v) {
                    const float d = std::sqrt(answer.distance2[v]);
                    ASSERT_LE(d, bounds.distance_hi);
                    ASSERT_TRUE(
                        falls_under_a_case(bounds, d, x[v], y[v], static_cast<int32_t>(id[v])));
                }
            }
        }
    }
}

void check(const TriangleMesh& mesh, const Vec3f& pitch, int32_t per_patch, float loose,
           double widest) {
    const MeshSurface surface(mesh, per_patch, loose);
    const auto frame = testing::make_test_frame(pitch, {});
    const auto engine = make_block_engine(surface, frame);
    const AttributeReader reader(surface, frame);
    const Box3f box = mesh.box();
    Vec3i lowest, count;
    for (int a = 0; a < 3; ++a) {
        lowest[a] = static_cast<int32_t>(std::floor(box.lo[a] / pitch[a])) - 8;
        count[a] = static_cast<int32_t>(box.size()[a] / pitch[a]) + 16;
    }
    for (const int32_t size : {8, 16, 32, 64}) {
        Looseness looseness;
        const int32_t step = std::max(size, 24);
        for (int32_t k = 0; k < count.z; k += step) {
            for (int32_t j = 0; j < count.y; j += step) {
                for (int32_t i = 0; i < count.x; i += step) {
                    check_cube(*engine, reader, lowest + Vec3i{i, j, k}, size, pitch, &looseness);
                    if (::testing::Test::HasFatalFailure()) return;
                }
            }
        }
        // Bounds must be tight as well as sound: a tight interval is about one diagonal wide.
        EXPECT_LT(looseness.width / looseness.cubes, widest) << "cubes of " << size;
    }
}

TEST(BoundsHold, IdentitySurfaces) {
    check(testing::make_torus(48, 24, 2.0, 0.8), {0.08f, 0.08f, 0.08f}, 0, 0, 1.6);
    check(testing::make_ball(10, [](const Vec3d& d) { return 1.5 + 0.3 * d.x * d.y; }),
          {0.042f, 0.085f, 0.027f}, 0, 0, 1.6);
    check(testing::make_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, 1.0f), {0.0625f, 0.0625f, 0.0625f},
          0, 0, 1.6);
}

TEST(BoundsHold, PatchesInLooseBoxes) {
    const TriangleMesh mesh = testing::make_torus(48, 24, 2.0, 0.8);
    check(mesh, {0.08f, 0.08f, 0.08f}, 6, 0.1f, 4);
    check(mesh, {0.08f, 0.08f, 0.08f}, 24, 0.3f, 6);
}

TEST(BoundsHold, RandomSoups) {
    for (uint32_t seed = 1; seed <= 3; ++seed) {
        check(testing::make_soup(seed, 60, 1.0f, 0.6f), {0.06f, 0.06f, 0.06f}, 0, 0, 1.6);
    }
}

/// Mean width of the intervals, in diagonals of a piece.
double check_pieces(const Engine& engine, const std::vector<Vec3i>& blocks, const Vec3f& pitch) {
    const auto scratch = engine.make_scratch();
    std::vector<BlockBounds> bounds(blocks.size());
    engine.bound_blocks(blocks, scratch.get(), bounds.data());
    const BlockPieces& pieces = engine.pieces();
    const float diagonal = length(Vec3f{pitch.x * static_cast<float>(pieces.size.x),
                                        pitch.y * static_cast<float>(pieces.size.y),
                                        pitch.z * static_cast<float>(pieces.size.z)});
    BlockAnswer answer;
    double width = 0;
    for (size_t b = 0; b < blocks.size(); ++b) {
        engine.query({blocks[b]}, scratch.get(), &answer);
        std::vector<int> times(kBlockVoxels, 0);
        for (size_t p = 0; p < pieces.lowest.size(); ++p) {
            const float low = bounds[b].low[p], high = bounds[b].high[p];
            width += static_cast<double>((high - low) / diagonal);
            const Vec3i from = pieces.lowest[p], to = from + pieces.size;
            for (int32_t y = from.y; y < to.y; ++y) {
                for (int32_t x = from.x; x < to.x; ++x) {
                    for (int32_t z = from.z; z < to.z; ++z) {
                        const auto v = static_cast<size_t>((y * 8 + x) * 8 + z);
                        ++times[v];
                        EXPECT_GE(std::sqrt(answer.distance2[v]), low);
                        EXPECT_LE(std::sqrt(answer.distance2[v]), high);
                    }
                }
            }
        }
        EXPECT_EQ(std::ranges::count(times, 1), kBlockVoxels);
        if (::testing::Test::HasFailure()) break;
    }
    return width / static_cast<double>(32 * blocks.size());
}

TEST(BoundsHold, PiecesOfBlocks) {
    for (const TriangleMesh& mesh :
         {testing::make_torus(48, 24, 2.0, 0.8), testing::make_soup(5, 100, 2.0f, 0.5f),
          testing::make_ball(12, [](const Vec3d& d) { return 1.5 + 0.3 * d.x * d.y; })}) {
        const MeshSurface surface(mesh);
        for (const Vec3f& pitch : {Vec3f{0.06f, 0.06f, 0.06f}, Vec3f{0.042f, 0.085f, 0.027f},
                                   Vec3f{0.03f, 0.03f, 0.2f}}) {
            auto frame = testing::make_test_frame(pitch, {});
            constexpr float kTurn[3][3] = {{2, -1, 2}, {2, 2, -1}, {-1, 2, 2}};
            for (size_t a = 0; a < 3; ++a) {
                for (size_t c = 0; c < 3; ++c)
                    frame[3 * a + c] = pitch[static_cast<int>(a)] * kTurn[a][c] / 3;
            }
            // In random order, so that corners evict each other from the cache.
            std::mt19937 random(11);
            std::vector<Vec3i> blocks;
            for (int i = 0; i < 400; ++i) {
                Vec3i block;
                for (int a = 0; a < 3; ++a) {
                    const auto reach = static_cast<int32_t>(3 / pitch[a]);
                    block[a] =
                        static_cast<int32_t>(random() % static_cast<uint32_t>(2 * reach)) / 8 * 8 -
                        reach + 3;
                }
                blocks.push_back(block);
            }
            for (const simd::Isa set :
                 {simd::Isa::kAvx512, simd::Isa::kAvx2Fma, simd::Isa::kSse41}) {
                const auto engine = make_block_engine(surface, frame, {.widest = set});
                // A piece perpendicular to the direction to the surface has an interval of no
                // width.
                EXPECT_LT(check_pieces(*engine, blocks, pitch), 2.0) << testing::name_of(set);
                if (HasFailure()) return;
            }
            blocks.resize(3);
            EXPECT_LT(
                check_pieces(*reference::make_brute_force_engine(surface, frame), blocks, pitch),
                1.0);
        }
    }
}

TEST(BoundsHold, PiecesWhereThereIsNoSurface) {
    const MeshSurface surface(TriangleMesh{});
    const auto engine =
        make_block_engine(surface, testing::make_test_frame({0.1f, 0.1f, 0.1f}, {}));
    BlockBounds bounds;
    const Vec3i block{0, 0, 0};
    engine->bound_blocks({&block, 1}, engine->make_scratch().get(), &bounds);
    for (size_t p = 0; p < 32; ++p) {
        EXPECT_TRUE(std::isinf(bounds.low[p]));
        EXPECT_TRUE(std::isinf(bounds.high[p]));
    }
}

}  // namespace
}  // namespace openfab::nearest
