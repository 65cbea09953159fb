// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/attributes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_surface.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

struct Arrays {
    std::vector<std::vector<float>> values, gradients;
    std::vector<uint32_t> flat;
    std::vector<float*> value_pointers, gradient_pointers;
    std::vector<uint32_t*> flat_pointers;

    AttributeTargets targets() {
        values.assign(2, std::vector<float>(kBlockVoxels, -7.0f));
        gradients.assign(6, std::vector<float>(kBlockVoxels, -7.0f));
        flat.assign(kBlockVoxels, 77);
        value_pointers.clear();
        gradient_pointers.clear();
        for (auto& v : values)
            value_pointers.push_back(v.data());
        for (auto& g : gradients)
            gradient_pointers.push_back(g.data());
        flat_pointers = {flat.data()};
        return {value_pointers.data(), gradient_pointers.data(), flat_pointers.data()};
    }
};

/// A mesh and everything needed to read its attributes.
struct AttributeScene {
    MeshSurface surface;
    std::array<float, OPENFAB_FRAME_COUNT> frame;
    std::unique_ptr<Engine> engine;
    AttributeReader reader;

    explicit AttributeScene(const TriangleMesh& mesh, int32_t per_patch = 0,
                            const Vec3f& pitch = {0.1f, 0.1f, 0.1f}, const Vec3f& origin = {})
        : surface(mesh, per_patch),
          frame(testing::make_test_frame(pitch, origin)),
          engine(make_block_engine(surface, frame)),
          reader(surface, frame) {}

    BlockAnswer query(const BlockQuery& q) const {
        const auto scratch = engine->make_scratch();
        BlockAnswer answer;
        engine->query(q, scratch.get(), &answer);
        return answer;
    }
    void read(const BlockAnswer& answer, const uint8_t* demand, Arrays* out) const {
        AttributeReader::Scratch scratch;
        reader.read(answer, demand, out->targets(), &scratch);
    }
};

/// A ball of 1 mm radius.
TriangleMesh ball_mesh() {
    return testing::make_ball(4, [](const Vec3d&) { return 1.0; });
}

/// The surface's attributes are (x, y) / 10 at each vertex, so on any triangle they are (x, y) / 10
/// of the nearest point.
TEST(Attributes, AreThoseOfTheNearestPointAndItsPlane) {
    // One big slanted triangle, n = (1, 1, 1) / sqrt 3, seen from the origin side.
    TriangleMesh mesh;
    for (const Vec3f& p : {Vec3f{9, 0, 0}, Vec3f{0, 9, 0}, Vec3f{0, 0, 9}})
        mesh.add(p);
    mesh.triangles.push_back({0, 1, 2});
    const Vec3f pitch{0.1f, 0.2f, 0.05f};
    for (const int32_t per_patch : {0, 1}) {
        const AttributeScene scene(mesh, per_patch, pitch, {2, 2, 2});
        Arrays out;
        scene.read(scene.query({{0, 0, 0}}), nullptr, &out);
        for (int v = 0; v < kBlockVoxels; ++v) {
            const Vec3f p{2 + (static_cast<float>(v >> 3 & 7) + 0.5f) * pitch.x,
                          2 + (static_cast<float>(v >> 6) + 0.5f) * pitch.y,
                          2 + (static_cast<float>(v & 7) + 0.5f) * pitch.z};
            const float off = (p.x + p.y + p.z - 9) / 3;
            const auto at = static_cast<size_t>(v);
            ASSERT_NEAR(out.values[0][at], (p.x - off) / 10, 1e-5f);
            ASSERT_NEAR(out.values[1][at], (p.y - off) / 10, 1e-5f);
            ASSERT_EQ(out.flat[at], 0u);
            // d(x - off)/dx = 2/3, over y and z -1/3; times a tenth of the pitch.
            for (int component = 0; component < 2; ++component) {
                for (int axis = 0; axis < 3; ++axis) {
                    const float slope = component == axis ? 2.0f / 3 : -1.0f / 3;
                    ASSERT_NEAR(out.gradients[static_cast<size_t>(component * 3 + axis)][at],
                                slope * pitch[axis] / 10, 1e-6f);
                }
            }
        }
    }
}

/// An irregular demand.
std::array<uint8_t, 64> every_so_often() {
    std::array<uint8_t, 64> demand{};
    for (size_t i = 0; i < 64; ++i)
        demand[i] = static_cast<uint8_t>(i * 37);
    return demand;
}

TEST(Attributes, NothingWhereNothingIsAskedOrInReach) {
    const AttributeScene ball(ball_mesh());
    const auto demand = every_so_often();
    BlockQuery query{{4, 4, 0}};
    query.active = demand.data();
    query.radius_mm = 0.2f;
    const BlockAnswer answer = ball.query(query);
    Arrays out;
    ball.read(answer, demand.data(), &out);
    int hits = 0;
    for (size_t v = 0; v < kBlockVoxels; ++v) {
        const bool asked = (demand[v >> 3] >> (v & 7) & 1) != 0;
        const bool hit = answer.item[v] >= 0;
        ASSERT_TRUE(asked || !hit);
        hits += hit ? 1 : 0;
        if (hit) {
            ASSERT_EQ(out.flat[v], static_cast<uint32_t>(answer.item[v]));
        } else {
            ASSERT_EQ(out.values[0][v], 0.0f);
            ASSERT_EQ(out.gradients[5][v], 0.0f);
            ASSERT_EQ(out.flat[v], 0u);
        }
    }
    EXPECT_GT(hits, 10);
}

TEST(Attributes, OfFewerVoxelsThanWereQueriedAreTheSameThereAndNothingElsewhere) {
    const AttributeScene ball(ball_mesh());
    const auto demand = every_so_often();
    const BlockAnswer answer = ball.query({{4, 4, 0}});
    Arrays all, some;
    ball.read(answer, nullptr, &all);
    ball.read(answer, demand.data(), &some);
    int left_out = 0;
    for (size_t v = 0; v < kBlockVoxels; ++v) {
        const bool asked = (demand[v >> 3] >> (v & 7) & 1) != 0;
        left_out += asked ? 0 : 1;
        ASSERT_EQ(all.flat[v], static_cast<uint32_t>(answer.item[v]));
        ASSERT_EQ(some.flat[v], asked ? all.flat[v] : 0u);
        for (size_t c = 0; c < 2; ++c)
            ASSERT_EQ(some.values[c][v], asked ? all.values[c][v] : 0.0f);
        for (size_t g = 0; g < 6; ++g)
            ASSERT_EQ(some.gradients[g][v], asked ? all.gradients[g][v] : 0.0f);
    }
    EXPECT_GT(left_out, 100);
}

TEST(Attributes, OfASurfaceThatIsStoppedAreNothing) {
    AttributeScene ball(ball_mesh(), 12);
    const BlockAnswer answer = ball.query({{4, 4, 0}});
    ball.surface.stop();
    Arrays out;
    ball.read(answer, nullptr, &out);
    for (size_t v = 0; v < kBlockVoxels; ++v) {
        ASSERT_GE(answer.item[v], 0);
        ASSERT_EQ(out.values[0][v], 0.0f);
        ASSERT_EQ(out.gradients[0][v], 0.0f);
        ASSERT_EQ(out.flat[v], 0u);
    }
}

TEST(Attributes, ATriangleWithoutAreaHasNoGradient) {
    TriangleMesh mesh;
    for (const Vec3f& p : {Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{2, 0, 0}})
        mesh.add(p);
    mesh.triangles.push_back({0, 1, 2});
    const AttributeScene scene(mesh);
    Arrays out;
    scene.read(scene.query({{0, 0, 0}}), nullptr, &out);
    for (size_t v = 0; v < kBlockVoxels; ++v) {
        for (const auto& g : out.gradients)
            ASSERT_EQ(g[v], 0.0f);
        ASSERT_NEAR(out.values[0][v], (static_cast<float>(v >> 3 & 7) + 0.5f) * 0.01f, 1e-6f);
    }
}

}  // namespace
}  // namespace openfab::nearest
