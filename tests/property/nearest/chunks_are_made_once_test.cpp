// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks of a large mesh: each triangle is in one, each tree is made once however many threads ask
// for it, is the same whoever makes it, and takes no more memory than was planned.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <thread>

#include "runtime/nearest/chunks.h"
#include "tests/support/mesh_surface.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

#ifdef OPENFAB_SANITIZED
constexpr int kAround = 120;
#else
constexpr int kAround = 400;
#endif

/// A ring, a cloud of triangles that share nothing, a ring beside a far speck, so that nearly all
/// of it is in one place on the curve, a sheet of which all lies in one plane, and a ring with a
/// triangle across.
std::vector<TriangleMesh> meshes() {
    std::vector<TriangleMesh> out;
    out.push_back(testing::make_torus(kAround, kAround / 4, 15, 6));
    out.push_back(testing::make_soup(3, kAround * 50, 20, 0.5f));
    TriangleMesh far = testing::make_torus(kAround, kAround / 4, 0.001, 0.0004);
    const int32_t speck = far.add({1000, 1000, 1000});
    far.triangles.push_back({speck, far.add({1000, 1001, 1000}), far.add({1001, 1000, 1000})});
    out.push_back(far);
    TriangleMesh sheet = testing::make_torus(kAround, kAround / 4, 15, 6);
    for (Vec3f& p : sheet.positions)
        p.z = 1;
    out.push_back(sheet);
    TriangleMesh crossed = testing::make_torus(kAround, kAround / 4, 15, 6);
    crossed.triangles.push_back({crossed.add({-20, 0, 0}), crossed.add({20, 1, 0}), 0});
    out.push_back(crossed);
    return out;
}

std::vector<int32_t> ids_of(const Chunks& chunks) {
    std::vector<int32_t> ids(chunks.count());
    for (size_t c = 0; c < ids.size(); ++c)
        ids[c] = chunks.first_id() + static_cast<int32_t>(c);
    return ids;
}

struct FeatureCount {
    size_t edges = 0, vertices = 0, half_spaces = 0;  ///< values of those
    bool operator==(const FeatureCount&) const = default;
};

FeatureCount count_features(const TreeView& tree, uint32_t at = 0) {
    const Node& node = tree.nodes[at];
    FeatureCount count;
    if (node.is_leaf()) {
        const LeafFeatures& leaf = tree.leaves[at];
        const size_t features = node.count() + size_t{leaf.edges} + leaf.vertices;
        return {leaf.edges, leaf.vertices, features * HalfSpaces::kValues};
    }
    for (uint32_t i = 0; i < node.children(); ++i) {
        const FeatureCount of_child = count_features(tree, node.child() + i);
        count.edges += of_child.edges;
        count.vertices += of_child.vertices;
        count.half_spaces += of_child.half_spaces;
    }
    return count;
}

TEST(Chunks, HoldEachTriangleOnce) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const Chunks chunks(surface);
        ASSERT_GT(chunks.count(), 4u);
        std::vector<int> seen(mesh.triangles.size());
        for (const InputTriangle& t : chunks.triangles())
            ++seen[static_cast<size_t>(t.patch)];
        for (const int32_t id : ids_of(chunks)) {
            EXPECT_LE(chunks.patches(id).size(), 4096u);
            for (const int32_t patch : chunks.patches(id))
                ++seen[static_cast<size_t>(patch)];
        }
        for (const int n : seen)
            ASSERT_EQ(n, 1);
    }
}

TEST(Chunks, HoldNoLargeTriangle) {
    const MeshSurface surface(meshes().back());
    const Chunks chunks(surface);
    ASSERT_EQ(chunks.triangles().size(), 1u);
    EXPECT_EQ(static_cast<size_t>(chunks.triangles()[0].patch), surface.patches().size() - 1);
}

TEST(Chunks, AreNotMadeOfFewTriangles) {
    const MeshSurface surface(testing::make_torus(20, 10, 15, 6));
    const Chunks chunks(surface);
    EXPECT_EQ(chunks.count(), 0u);
    EXPECT_EQ(chunks.triangles().size(), 400u);
    EXPECT_EQ(chunks.bytes_to_come(200), 0u);
}

TEST(Chunks, BoxesHoldTheirTriangles) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const Chunks chunks(surface);
        const Tree tree = build_tree(chunks.triangles(), chunks.boxes());
        for (const Node& node : tree.nodes) {
            const auto id = static_cast<int32_t>(node.first());
            if (!node.is_leaf() || node.count() != 0) continue;
            for (const int32_t patch : chunks.patches(id)) {
                for (const int32_t v : mesh.triangles[static_cast<size_t>(patch)]) {
                    const Vec3d p = vec_cast<double>(mesh.positions[static_cast<size_t>(v)]);
                    for (int k = 0; k < 3; ++k) {
                        const Vec3d axis = vec_cast<double>(
                            Vec3f{node.axis[k][0], node.axis[k][1], node.axis[k][2]});
                        ASSERT_LE(std::abs(dot(axis, p) - static_cast<double>(node.center[k])),
                                  static_cast<double>(node.half[k]));
                    }
                }
            }
        }
    }
}

TEST(Chunks, AreMadeOnceByAnyNumberOfThreads) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const Chunks chunks(surface), others(surface);
        const std::vector<int32_t> ids = ids_of(chunks);
        constexpr size_t kThreads = 4;
        std::vector<std::vector<const TreeView*>> got(kThreads,
                                                      std::vector<const TreeView*>(ids.size()));
        std::array<uint64_t, kThreads> links{};
        std::vector<std::thread> threads;
        for (size_t t = 0; t < kThreads; ++t) {
            threads.emplace_back([&, t] {
                for (size_t i = 0; i < ids.size(); ++i) {
                    // Two and two from either end, so that they want the same at the same time.
                    const size_t c = t % 2 == 0 ? i : ids.size() - 1 - i;
                    got[t][c] = chunks.get(ids[c]);
                    if (got[t][c]->nodes != nullptr) links[t] += got[t][c]->nodes->link;
                }
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        EXPECT_EQ(chunks.made(), ids.size());
        for (size_t t = 1; t < kThreads; ++t)
            EXPECT_TRUE(got[t] == got[0] && links[t] == links[0]);
        // The same trees where they are made alone, the last first.
        for (size_t c = ids.size(); c-- > 0;) {
            const TreeView &a = *got[0][c], &b = *others.get(ids[c]);
            ASSERT_EQ(a.nodes == nullptr, b.nodes == nullptr);
            if (a.nodes == nullptr) continue;
            const size_t count = others.patches(ids[c]).size();
            ASSERT_EQ(std::memcmp(a.frames, b.frames, count * sizeof(TriangleFrame)), 0);
            ASSERT_EQ(std::memcmp(a.details, b.details, count * sizeof(TriangleDetail)), 0);
            const FeatureCount has = count_features(a);
            ASSERT_EQ(has, count_features(b));
            ASSERT_EQ(std::memcmp(a.edges, b.edges, has.edges * sizeof(EdgeFeature)), 0);
            ASSERT_EQ(std::memcmp(a.vertices, b.vertices, has.vertices * sizeof(VertexFeature)), 0);
            ASSERT_EQ(std::memcmp(a.half_spaces, b.half_spaces, has.half_spaces * sizeof(int16_t)),
                      0);
            ASSERT_EQ(a.nodes[0].link, b.nodes[0].link);
            ASSERT_EQ(std::memcmp(a.cones, b.cones, sizeof(NodeCone)), 0);
        }
        EXPECT_EQ(chunks.bytes_made(), others.bytes_made());
    }
}

TEST(Chunks, OwnEachEdgeAndVertexOnce) {
    const TriangleMesh mesh = meshes()[0];
    const MeshSurface surface(mesh);
    const Chunks chunks(surface);
    size_t edges = 0, vertices = 0;
    for (const int32_t id : ids_of(chunks)) {
        const TreeView& tree = *chunks.get(id);
        edges += count_features(tree).edges;
        vertices += count_features(tree).vertices;
    }
    EXPECT_EQ(edges, mesh.triangles.size() / 2 * 3);
    EXPECT_EQ(vertices, mesh.positions.size());
}

TEST(Chunks, TakeWhatIsPlanned) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const Chunks chunks(surface);
        const size_t vertices = mesh.positions.size();
        const size_t planned = chunks.bytes_to_come(vertices);
        const std::vector<int32_t> ids = ids_of(chunks);
        for (size_t c = 0; c < ids.size() / 2; ++c)
            chunks.get(ids[c]);
        const size_t left = chunks.bytes_to_come(vertices);
        EXPECT_GT(left, planned / 4);
        EXPECT_LT(left, planned * 3 / 4);
        for (const int32_t id : ids)
            chunks.get(id);
        EXPECT_EQ(chunks.bytes_to_come(vertices), 0u);
        EXPECT_LE(chunks.bytes_made(), planned);
        EXPECT_GT(chunks.bytes_made(), planned / 2);
    }
}

}  // namespace
}  // namespace openfab::nearest
