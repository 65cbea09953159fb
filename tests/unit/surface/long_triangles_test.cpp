// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/long_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using part::PartMesh;
using Triangle = std::array<Vec3d, 3>;

std::shared_ptr<const PartMesh> split(const part::Part& part, double s) {
    surface::SurfaceOptions options;
    options.micro_edge_mm = s;
    const auto mesh = surface::mesh_to_dice(part, options);
    EXPECT_TRUE(mesh) << mesh.error().text();
    return *mesh;
}

part::Part hand_part(const mesh::Mesh& mesh, testing::HandMode mode) {
    return make_part(testing::Scenario{"", mesh, mode, 0.05f, 0, false});
}

std::vector<Triangle> triangles(const PartMesh& mesh) {
    std::vector<Triangle> out;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](size_t c) { return mesh.positions[t[c]]; };
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
    const part::Part part = hand_part(testing::card(300, 3, 3), testing::HandMode::kBumps);
    const auto mesh = split(part, s);
    const std::vector<Triangle> before = triangles(*part.mesh), after = triangles(*mesh);
    EXPECT_EQ(open_edges(after), 0u);
    EXPECT_NEAR(total_area(after), total_area(before), 1e-9 * total_area(before));
    for (const Triangle& t : after)
        EXPECT_LE(longest_edge(t), 5);
    // About as many as its area needs; without splitting, nearly a hundred times as many.
    const double needed = 2 * total_area(before) / (s * s);
    EXPECT_GT(diced(before, s), 90 * needed);
    EXPECT_LT(diced(after, s), 4 * needed);
    EXPECT_LT(after.size(), 4000u);
}

/// Slender meshes of several kinds: flat, round, irregular, ones that meet at an edge, at a vertex
/// and everywhere, and an open one.
std::vector<mesh::Mesh> slender_meshes() {
    const auto stretched = [](mesh::Mesh mesh, double x, double y) {
        for (Vec3d& p : mesh.positions)
            p = {p.x * x, p.y * y, p.z};
        return mesh;
    };
    const mesh::Mesh bar = testing::card(100, 3, 2);
    std::vector<mesh::Mesh> all = {bar,
                                   stretched(testing::sphere(1, 9, 6), 40, 2),
                                   testing::joined(bar, bar, {0, 3, 2}),
                                   testing::joined(bar, bar, {100, 3, 2}),
                                   testing::joined(bar, bar, {0, 0, 0}),
                                   stretched(mesh::make_plane(3, 2), 40, 1)};
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        all.push_back(
            stretched(testing::shaken(testing::torus(2, 0.7, 7, 5), seed, 0.3), 20 * seed, 1));
    }
    return all;
}

constexpr double kMicroEdge_mm = 0.05;

/// All triangles displaced, or a random part of them.
std::vector<uint8_t> some_displaced(const PartMesh& mesh, uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<uint8_t> out(mesh.triangles.size(), 1);
    for (uint8_t& displaced : out)
        displaced = seed == 0 || random() % 2 == 0 ? 1 : 0;
    return out;
}

TEST(LongTrianglesTest, NeighboursShareTheirCutPoints) {
    for (const mesh::Mesh& mesh : slender_meshes()) {
        const part::Part part = hand_part(mesh, testing::HandMode::kBumps);
        const std::vector<Triangle> before = triangles(*part.mesh);
        for (uint32_t seed = 0; seed < 8; ++seed) {
            const auto cut = surface::split_long_triangles(*part.mesh, kMicroEdge_mm,
                                                           some_displaced(*part.mesh, seed));
            if (seed == 0) {
                ASSERT_NE(cut, nullptr);
            }
            if (cut == nullptr) continue;
            const std::vector<Triangle> after = triangles(*cut);
            EXPECT_EQ(open_edges(after) == 0, open_edges(before) == 0) << seed;
            EXPECT_NEAR(total_area(after), total_area(before), 1e-9 * total_area(before));
        }
    }
}

TEST(LongTrianglesTest, DicedPiecesLeaveNoCrack) {
    for (const mesh::Mesh& mesh : slender_meshes()) {
        for (const auto mode : {testing::HandMode::kBumps, testing::HandMode::kBack}) {
            part::Part part = hand_part(mesh, mode);
            if (open_edges(triangles(*part.mesh)) != 0) continue;
            surface::SurfaceOptions options;
            options.micro_edge_mm = 8 * kMicroEdge_mm;
            part.mesh = split(part, options.micro_edge_mm);
            const auto made = surface::Surface::create(part, options);
            ASSERT_TRUE(made) << made.error().message;
            EXPECT_EQ(testing::open_edges(testing::triangles_of(**made, surface::kForCoverage)), 0);
        }
    }
}

/// The corners, rotated to start at the first by position, to compare triangles.
std::array<Place, 3> turned(const Triangle& t) {
    std::array<Place, 3> out{place(t[0]), place(t[1]), place(t[2])};
    std::rotate(out.begin(), std::min_element(out.begin(), out.end()), out.end());
    return out;
}

TEST(LongTrianglesTest, TheOrderOfTrianglesChangesNoBit) {
    const auto pieces = [](const PartMesh& mesh, const std::vector<uint8_t>& displaced) {
        std::multiset<std::array<Place, 3>> all;
        const auto cut = surface::split_long_triangles(mesh, kMicroEdge_mm, displaced);
        for (const Triangle& t : triangles(cut == nullptr ? mesh : *cut))
            all.insert(turned(t));
        return all;
    };
    for (const mesh::Mesh& mesh : slender_meshes()) {
        for (uint32_t seed = 0; seed < 4; ++seed) {
            const part::Part part = hand_part(mesh, testing::HandMode::kBumps);
            PartMesh one;
            one.positions = part.mesh->positions;
            one.triangles = part.mesh->triangles;
            const std::vector<uint8_t> displaced = some_displaced(one, seed);
            const auto want = pieces(one, displaced);
            std::vector<size_t> order(one.triangles.size());
            for (size_t i = 0; i < order.size(); ++i)
                order[i] = i;
            std::shuffle(order.begin(), order.end(), std::mt19937(seed));
            PartMesh other = one;
            std::vector<uint8_t> moved = displaced;
            for (size_t i = 0; i < order.size(); ++i) {
                other.triangles[i] = one.triangles[order[i]];
                moved[i] = displaced[order[i]];
            }
            EXPECT_TRUE(pieces(other, moved) == want) << seed;
        }
    }
}

TEST(LongTrianglesTest, CutCornersHaveTheValuesBetweenTheEnds) {
    // Linear functions of the position stay linear: single precision, over up to a dozen
    // bisections.
    const auto value = [](const Vec3d& p) { return 0.25 * p.x - 0.5 * p.y + p.z + 1; };
    for (const mesh::Mesh& mesh : slender_meshes()) {
        const part::Part part = hand_part(mesh, testing::HandMode::kBumps);
        PartMesh given = *part.mesh;
        const size_t corners = 3 * given.triangles.size();
        given.inputs.resize(2);
        given.nearest_attributes = {};
        given.corner_uv.resize(2 * corners);
        given.inputs[0] = {OPENFAB_FLOAT, 1, std::vector<float>(corners), {}};
        given.inputs[1] = {OPENFAB_INT, 1, {}, {}};
        for (size_t c = 0; c < corners; ++c) {
            const Vec3d& p = given.positions[static_cast<size_t>(given.triangles[c / 3][c % 3])];
            given.inputs[0].corner_values[c] = static_cast<float>(value(p));
            given.corner_uv[2 * c] = static_cast<float>(p.x);
            given.corner_uv[2 * c + 1] = static_cast<float>(p.y);
        }
        for (uint32_t t = 0; t < given.triangles.size(); ++t)
            given.inputs[1].face_values.push_back(t);
        const auto cut =
            surface::split_long_triangles(given, kMicroEdge_mm, some_displaced(given, 0));
        ASSERT_NE(cut, nullptr);
        const std::vector<Triangle> before = triangles(given), after = triangles(*cut);
        ASSERT_EQ(cut->corner_normals.size(), given.corner_normals.empty() ? 0 : 3 * after.size());
        for (size_t t = 0; t < after.size(); ++t) {
            for (size_t c = 0; c < 3; ++c) {
                const Vec3d& p = after[t][c];
                EXPECT_NEAR(cut->inputs[0].corner_values[3 * t + c], value(p), 1e-4);
                EXPECT_NEAR(cut->corner_uv[2 * (3 * t + c)], p.x, 1e-4);
                EXPECT_NEAR(cut->corner_uv[2 * (3 * t + c) + 1], p.y, 1e-4);
            }
            // A piece lies in the triangle whose face value it has, and faces the same way.
            const Triangle& from = before[cut->inputs[1].face_values[t]];
            const Vec3d normal = cross(from[1] - from[0], from[2] - from[0]);
            const Vec3d own = cross(after[t][1] - after[t][0], after[t][2] - after[t][0]);
            EXPECT_GT(dot(own, normal), 0);
            for (const Vec3d& p : after[t])
                EXPECT_NEAR(dot(p - from[0], normal) / length(normal), 0, 1e-9);
        }
    }
}

}  // namespace
}  // namespace openfab
