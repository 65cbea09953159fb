// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/long_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using scene::PartMesh;
using Triangle = std::array<Vec3d, 3>;

std::shared_ptr<const PartMesh> split(const scene::Part& part, double s) {
    surface::SurfaceOptions options;
    options.micro_edge_mm = s;
    const auto mesh = surface::mesh_to_dice(part, options);
    EXPECT_TRUE(mesh) << mesh.error().text();
    return *mesh;
}

scene::Part hand_part(const scene::Mesh& mesh, testing::HandMode mode) {
    return make_part(testing::Scenario{"", mesh, mode, 0.05f, 0, false});
}

std::vector<Triangle> triangles(const PartMesh& mesh) {
    std::vector<Triangle> out;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](size_t c) { return mesh.positions[static_cast<size_t>(t[c])]; };
        out.push_back({at(0), at(1), at(2)});
    }
    return out;
}

double area(const Triangle& t) {
    return length(cross(t[1] - t[0], t[2] - t[0])) / 2;
}

double longest_edge(const Triangle& t) {
    return std::max({length(t[1] - t[0]), length(t[2] - t[1]), length(t[0] - t[2])});
}

using Place = std::array<double, 3>;
Place place(const Vec3d& p) {
    return {p.x, p.y, p.z};
}

/// Directed edges without an opposite.
size_t open_edges(const std::vector<Triangle>& all) {
    std::multiset<std::array<Place, 2>> edges;
    for (const Triangle& t : all) {
        for (size_t e = 0; e < 3; ++e)
            edges.insert({place(t[e]), place(t[(e + 1) % 3])});
    }
    size_t open = 0;
    for (const auto& e : edges)
        open += edges.count({e[1], e[0]}) != edges.count(e) ? 1 : 0;
    return open;
}

/// Micro-triangles of a lattice with the factor of its longest edge along both axes.
double diced(const std::vector<Triangle>& all, double s) {
    double sum = 0;
    for (const Triangle& t : all) {
        const double n = std::max(1.0, std::ceil(longest_edge(t) / s));
        sum += n * n;
    }
    return sum;
}

double total_area(const std::vector<Triangle>& all) {
    double sum = 0;
    for (const Triangle& t : all)
        sum += area(t);
    return sum;
}

TEST(LongTrianglesTest, ABarIsCutAcross) {
    const double s = 0.046;
    const scene::Part part = hand_part(testing::card(300, 3, 3), testing::HandMode::kBumps);
    const auto mesh = split(part, s);
    const std::vector<Triangle> before = triangles(*part.mesh), after = triangles(*mesh);
    EXPECT_EQ(open_edges(after), 0u);
    EXPECT_NEAR(total_area(after), total_area(before), 1e-9 * total_area(before));
    for (const Triangle& t : after)
        EXPECT_LE(longest_edge(t), 5);
    // As many as its area needs, in squares of two, and some; before, nearly a hundred times as
    // many.
    const double needed = 2 * total_area(before) / (s * s);
    EXPECT_GT(diced(before, s), 90 * needed);
    EXPECT_LT(diced(after, s), 4 * needed);
    EXPECT_LT(after.size(), 4000u);
}

}  // namespace
}  // namespace openfab
