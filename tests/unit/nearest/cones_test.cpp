// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/cones.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/nearest/in_tree.h"

namespace openfab::nearest {
namespace {

using openfab::testing::TriangleMesh;
using testing::to_vec;
using testing::tree_of;

/// Calls visit(node) for each node with triangle `index` below it.
template <typename Visit>
bool visit_around(const Tree& tree, size_t node, uint32_t index, const Visit& visit) {
    const Node& n = tree.nodes[node];
    bool found = n.is_leaf() && index >= n.first() && index < n.first() + n.count();
    if (!n.is_leaf()) {
        for (uint32_t i = n.child(); i < n.child() + n.children() && !found; ++i)
            found = visit_around(tree, i, index, visit);
    }
    if (found) visit(node);
    return found;
}

/// Checks that if a point is nearest to a triangle, the direction to it lies in the cones of all
/// nodes above it. Returns the number of nodes whose cone is known.
int check_cones(const TriangleMesh& mesh, float away, uint32_t seed) {
    const Tree tree = tree_of(mesh);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> some(-away, away);
    int told = 0;
    for (int i = 0; i < 400; ++i) {
        const Vec3f from = mesh.positions[random() % mesh.positions.size()];
        const Vec3f p = from + Vec3f{some(random), some(random), some(random)};
        const testing::NearestTriangle nearest = testing::nearest_triangle(tree, p);
        visit_around(tree, 0, nearest.index, [&](size_t n) {
            told += tree.cones[n].sine < 1 ? 1 : 0;
            const Vec3f way = p - nearest.point;
            const float across = length(cross(way, to_vec(tree.nodes[n].axis[2])));
            EXPECT_LE(across, tree.cones[n].sine * length(way) + 1e-4f * away);
        });
    }
    return told;
}

TEST(Cones, HoldTheWayToTheNearestPoint) {
    EXPECT_GT(check_cones(openfab::testing::make_torus(60, 30, 0.6, 0.25), 0.3f, 1), 400);
    const auto bumpy = openfab::testing::make_ball(14, [](const Vec3d& d) {
        return 1 + 0.04 * std::sin(9 * d.x) * std::cos(11 * d.y + 3 * d.z);
    });
    EXPECT_GT(check_cones(bumpy, 0.4f, 2), 400);
    check_cones(openfab::testing::make_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, 0.5f), 0.5f, 3);
    check_cones(openfab::testing::make_soup(4, 150, 1.0f, 0.4f), 0.5f, 4);
}

TEST(Cones, AreLinesOverASheet) {
    constexpr int kCells = 12;
    TriangleMesh sheet;
    for (int y = 0; y <= kCells; ++y) {
        for (int x = 0; x <= kCells; ++x)
            sheet.add({0.1f * static_cast<float>(x), 0.1f * static_cast<float>(y), 0.3f});
    }
    for (int y = 0; y < kCells; ++y) {
        for (int x = 0; x < kCells; ++x) {
            const int32_t v = y * (kCells + 1) + x, above = v + kCells + 1;
            sheet.triangles.push_back({v, v + 1, above});
            sheet.triangles.push_back({v + 1, above + 1, above});
        }
    }
    const Tree tree = tree_of(sheet);
    int lines = 0;
    for (size_t n = 0; n < tree.nodes.size(); ++n) {
        const Node& node = tree.nodes[n];
        if (!node.is_leaf()) continue;
        bool at_border = false;
        for (uint32_t t = node.first(); t < node.first() + node.count(); ++t) {
            for (const float* v : {tree.frames[t].v0, tree.details[t].v1, tree.details[t].v2}) {
                for (int a = 0; a < 2; ++a)
                    at_border |= v[a] < 0.05f || v[a] > 0.1f * kCells - 0.05f;
            }
        }
        // At the border some own an edge with a single face, beside which the surface is nearest,
        // too.
        if (!at_border) {
            EXPECT_LT(tree.cones[n].sine, 0.01f);
            ++lines;
        }
    }
    EXPECT_GT(lines, kCells * kCells / 4);
    EXPECT_EQ(tree.cones[0].sine, 1.0f);
}

}  // namespace
}  // namespace openfab::nearest
