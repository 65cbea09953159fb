// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Treelets of a large mesh: each triangle is in one; each tree is built once, however many threads
// need it, is the same whichever thread builds it, and takes no more memory than planned.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <thread>

#include "runtime/nearest/tree/treelets.h"
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

/// A ring, a cloud of triangles that share nothing, a ring beside a distant speck, so that nearly
/// all of it has one Morton code, a planar sheet, and a ring with a triangle across.
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

std::vector<int32_t> ids_of(const LazyTreelets& treelets) {
    std::vector<int32_t> ids(treelets.count());
    for (size_t c = 0; c < ids.size(); ++c)
        ids[c] = treelets.first_id() + static_cast<int32_t>(c);
    return ids;
}

struct FeatureCount {
    size_t edges = 0, vertices = 0, half_spaces = 0;  ///< values of half-spaces
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

TEST(LazyTreelets, HoldEachTriangleOnce) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const LazyTreelets treelets(surface);
        ASSERT_GT(treelets.count(), 4u);
        std::vector<int> seen(mesh.triangles.size());
        for (const InputTriangle& t : treelets.triangles())
            ++seen[t.patch];
        for (const int32_t id : ids_of(treelets)) {
            EXPECT_LE(treelets.patches(id).size(), 4096u);
            for (const int32_t patch : treelets.patches(id))
                ++seen[patch];
        }
        for (const int n : seen)
            ASSERT_EQ(n, 1);
    }
}

TEST(LazyTreelets, HoldNoLargeTriangle) {
    const MeshSurface surface(meshes().back());
    const LazyTreelets treelets(surface);
    ASSERT_EQ(treelets.triangles().size(), 1u);
    EXPECT_EQ(static_cast<size_t>(treelets.triangles()[0].patch), surface.patches().size() - 1);
}

TEST(LazyTreelets, AreNotMadeOfFewTriangles) {
    const MeshSurface surface(testing::make_torus(20, 10, 15, 6));
    const LazyTreelets treelets(surface);
    EXPECT_EQ(treelets.count(), 0u);
    EXPECT_EQ(treelets.triangles().size(), 400u);
    EXPECT_EQ(treelets.estimated_bytes(200), 0u);
}

TEST(LazyTreelets, BoxesHoldTheirTriangles) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const LazyTreelets treelets(surface);
        const Tree tree = build_tree(treelets.triangles(), treelets.boxes());
        for (const Node& node : tree.nodes) {
            const auto id = static_cast<int32_t>(node.first());
            if (!node.is_leaf() || node.count() != 0) continue;
            for (const int32_t patch : treelets.patches(id)) {
                for (const int32_t v : mesh.triangles[patch]) {
                    const Vec3d p = vec_cast<double>(mesh.positions[v]);
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

TEST(LazyTreelets, AreMadeOnceByAnyNumberOfThreads) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const LazyTreelets treelets(surface), others(surface);
        const std::vector<int32_t> ids = ids_of(treelets);
        constexpr size_t kThreads = 4;
        std::vector<std::vector<const TreeView*>> got(kThreads,
                                                      std::vector<const TreeView*>(ids.size()));
        std::array<uint64_t, kThreads> links{};
        std::vector<std::thread> threads;
        for (size_t t = 0; t < kThreads; ++t) {
            threads.emplace_back([&, t] {
                for (size_t i = 0; i < ids.size(); ++i) {
                    // Pairs of threads from either end, so that they need the same tree at the same
                    // time.
                    const size_t c = t % 2 == 0 ? i : ids.size() - 1 - i;
                    got[t][c] = treelets.get(ids[c]);
                    if (got[t][c]->nodes != nullptr) links[t] += got[t][c]->nodes->link;
                }
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        EXPECT_EQ(treelets.made(), ids.size());
        for (size_t t = 1; t < kThreads; ++t)
            EXPECT_TRUE(got[t] == got[0] && links[t] == links[0]);
        // The same trees when built by one thread, the last one first.
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
        EXPECT_EQ(treelets.bytes_made(), others.bytes_made());
    }
}

TEST(LazyTreelets, OwnEachEdgeAndVertexOnce) {
    const TriangleMesh mesh = meshes()[0];
    const MeshSurface surface(mesh);
    const LazyTreelets treelets(surface);
    size_t edges = 0, vertices = 0;
    for (const int32_t id : ids_of(treelets)) {
        const TreeView& tree = *treelets.get(id);
        edges += count_features(tree).edges;
        vertices += count_features(tree).vertices;
    }
    EXPECT_EQ(edges, mesh.triangles.size() / 2 * 3);
    EXPECT_EQ(vertices, mesh.positions.size());
}

TEST(LazyTreelets, TakeWhatIsPlanned) {
    for (const TriangleMesh& mesh : meshes()) {
        const MeshSurface surface(mesh);
        const LazyTreelets treelets(surface);
        const size_t vertices = mesh.positions.size();
        const size_t planned = treelets.estimated_bytes(vertices);
        const std::vector<int32_t> ids = ids_of(treelets);
        for (size_t c = 0; c < ids.size() / 2; ++c)
            treelets.get(ids[c]);
        const size_t left = treelets.estimated_bytes(vertices);
        EXPECT_GT(left, planned / 4);
        EXPECT_LT(left, planned * 3 / 4);
        for (const int32_t id : ids)
            treelets.get(id);
        EXPECT_EQ(treelets.estimated_bytes(vertices), 0u);
        EXPECT_LE(treelets.bytes_made(), planned);
        EXPECT_GT(treelets.bytes_made(), planned / 2);
    }
}

}  // namespace
}  // namespace openfab::nearest
