// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/leaf_features.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "tests/unit/nearest/in_tree.h"

namespace openfab::nearest {
namespace {

using openfab::testing::TriangleMesh;
using testing::to_vec;

/// Returns how far the point is outside of the half-space that it is farthest outside of, mm.
float most_beyond(const Tree& tree, const LeafFeatures& leaf, size_t features, size_t feature,
                  const Vec3f& p) {
    const int16_t* values =
        tree.half_spaces.values.data() + leaf.first_half_space * HalfSpaces::kValues + feature;
    const Vec3f from_origin = p - to_vec(leaf.origin);
    float most = 0;
    for (int side = 0; side < kHalfSpaces; ++side) {
        float beyond = 0;
        for (int c = 0; c < 3; ++c, values += features)
            beyond += static_cast<float>(*values) / HalfSpaces::kUnit * from_origin[c];
        beyond += static_cast<float>(*values) * leaf.step;
        values += features;
        most = std::max(most, beyond);
    }
    return most;
}

/// The nearest point of a feature; none where that is a feature at its border.
std::optional<Vec3f> nearest_of(const Tree& tree, const Node& node, const LeafFeatures& leaf,
                                size_t feature, const Vec3f& p) {
    constexpr float kBorder = 1e-4f;
    if (feature < node.count()) {
        const size_t t = node.first() + feature;
        const Hit hit = closest_point(tree.frames[t], tree.details[t], p);
        if (std::min({hit.bary1, hit.bary2, 1 - hit.bary1 - hit.bary2}) < kBorder) return {};
        const Vec3f v0 = to_vec(tree.frames[t].v0);
        return v0 + (to_vec(tree.details[t].v1) - v0) * hit.bary1 +
               (to_vec(tree.details[t].v2) - v0) * hit.bary2;
    }
    feature -= node.count();
    if (feature < leaf.edges) {
        const EdgeFeature& e = tree.edges[leaf.first_edge + feature];
        const float tau = dot(p - to_vec(e.a), to_vec(e.ab)) * e.inv_length2;
        if (std::min(tau, 1 - tau) < kBorder) return {};
        return to_vec(e.a) + to_vec(e.ab) * tau;
    }
    return to_vec(tree.vertices[leaf.first_vertex + feature - leaf.edges].v);
}

/// Checks that no point is outside a half-space of its nearest feature. Returns the fraction of all
/// features that have the point outside one of their half-spaces.
double check_half_spaces(const TriangleMesh& mesh, float away, uint32_t seed) {
    const Tree tree = testing::tree_of(mesh);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> some(-away, away);
    size_t tried = 0, beyond = 0, nearest_ones = 0;
    constexpr size_t kPoints = 200;
    for (size_t i = 0; i < kPoints; ++i) {
        const Vec3f p = mesh.positions[random() % mesh.positions.size()] +
                        Vec3f{some(random), some(random), some(random)};
        const float distance = length(p - testing::nearest_triangle(tree, p).point);
        for (size_t n = 0; n < tree.nodes.size(); ++n) {
            const Node& node = tree.nodes[n];
            if (!node.is_leaf()) continue;
            const LeafFeatures& leaf = tree.leaves[n];
            const size_t features = node.count() + size_t{leaf.edges} + leaf.vertices;
            for (size_t f = 0; f < features; ++f) {
                const float most = most_beyond(tree, leaf, features, f, p);
                ++tried;
                beyond += most > 1e-3f ? 1 : 0;
                const std::optional<Vec3f> x = nearest_of(tree, node, leaf, f, p);
                if (!x || length(p - *x) > distance + 1e-6f) continue;
                ++nearest_ones;
                // Equally near in float: a lateral offset of this size makes no difference.
                const float aside = std::sqrt(4e-6f * (distance + distance * distance));
                EXPECT_LE(most, aside * std::max(1.0f, aside * leaf.inv_reach))
                    << "feature " << f << " of node " << n;
            }
        }
    }
    EXPECT_GE(nearest_ones, kPoints * 9 / 10);
    return static_cast<double>(beyond) / static_cast<double>(tried);
}

TEST(LeafFeatures, HalfSpacesHoldNothingThatIsNearest) {
    EXPECT_GT(check_half_spaces(openfab::testing::make_torus(40, 20, 0.6, 0.25), 0.3f, 1), 0.9);
    const auto bumpy = openfab::testing::make_ball(12, [](const Vec3d& d) {
        return 1 + 0.04 * std::sin(9 * d.x) * std::cos(11 * d.y + 3 * d.z);
    });
    EXPECT_GT(check_half_spaces(bumpy, 0.4f, 2), 0.9);
    check_half_spaces(openfab::testing::make_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, 0.5f), 0.5f,
                      3);
    check_half_spaces(openfab::testing::make_soup(4, 100, 1.0f, 0.4f), 0.5f, 4);
    // Far away, where everything spans few units.
    check_half_spaces(openfab::testing::make_torus(40, 20, 0.6, 0.25), 30.0f, 5);
}

TEST(LeafFeatures, OfTinyEdgesTellNothingWrong) {
    TriangleMesh mesh;
    // Squares of lengths are too small for a float, or nearly.
    for (const float tiny : {1e-30f, 4e-23f, 1e-21f, 1e-18f}) {
        const int32_t v = mesh.add({tiny, 0, 0});
        mesh.triangles.push_back({v, mesh.add({0, tiny, 0}), mesh.add({0, 0, tiny})});
        mesh.triangles.push_back({v, v + 1, mesh.add({0.5f, 1, tiny})});
    }
    check_half_spaces(mesh, 0.5f, 6);
}

TEST(LeafFeatures, AreEachInOneLeaf) {
    const Tree tree = testing::tree_of(openfab::testing::make_torus(40, 20, 0.6, 0.25));
    size_t edges = 0, vertices = 0, features = 0;
    for (size_t n = 0; n < tree.nodes.size(); ++n) {
        const LeafFeatures& leaf = tree.leaves[n];
        if (!tree.nodes[n].is_leaf()) continue;
        // In the order of nodes, without gaps.
        EXPECT_EQ(leaf.first_half_space, features);
        features += tree.nodes[n].count() + size_t{leaf.edges} + leaf.vertices;
        edges += leaf.edges;
        vertices += leaf.vertices;
    }
    EXPECT_EQ(edges, tree.edges.size());
    EXPECT_EQ(vertices, tree.vertices.size());
    EXPECT_EQ(tree.edges.size(), tree.frames.size() / 2 * 3);
    EXPECT_EQ(tree.vertices.size(), tree.frames.size() / 2);
    EXPECT_GE(tree.half_spaces.values.size(), features * HalfSpaces::kValues + 16);
}

}  // namespace
}  // namespace openfab::nearest
