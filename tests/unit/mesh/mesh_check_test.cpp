// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_check.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <bit>
#include <cmath>
#include <ctime>
#include <random>

#include "mesh/check/mesh_intersections.h"
#include "mesh/check/triangle_tree.h"
#include "mesh/model/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

Mesh box(const Vec3d& lo, double side, bool outward = true) {
    Mesh mesh = testing::cube(side);
    mesh.attributes.clear();
    for (Vec3d& p : mesh.positions)
        p = p + lo;
    for (auto& t : mesh.triangles) {
        if (!outward) std::swap(t[1], t[2]);
    }
    return mesh;
}

Mesh joined(const std::vector<Mesh>& meshes) {
    Mesh out;
    for (const Mesh& mesh : meshes) {
        const auto first = static_cast<int32_t>(out.positions.size());
        out.positions.insert(out.positions.end(), mesh.positions.begin(), mesh.positions.end());
        for (const auto& t : mesh.triangles)
            out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return out;
}

MeshSource source_of(Mesh mesh) {
    MeshSource out;
    out.mesh = std::move(mesh);
    out.mesh.name = "part";
    out.origin.file = "m";
    return out;
}

TEST(MeshCheck, TurnsAMeshThatIsInsideOutAsAWhole) {
    MeshSource hollow = source_of(joined({box({0, 0, 0}, 10, false), box({2, 2, 2}, 5, true)}));
    ASSERT_TRUE(prepare_mesh(&hollow));
    EXPECT_NEAR(testing::signed_volume(hollow.mesh), 1000 - 125, 1e-9);
    EXPECT_EQ(hollow.checks.shells, 2);
    EXPECT_EQ(hollow.checks.turned, 2);
    EXPECT_EQ(hollow.checks.cavities, 1);
    EXPECT_EQ(hollow.checks.nested, 0);
    EXPECT_EQ(hollow.warnings, (std::vector<std::string>{fmt::format(messages::kShellsInsideOut,
                                                                     "m", "part", "2 shells")}));
}

/// Positions that collide in a table whose hash is known, and in order, take the square of their number: this many 5 s or
/// more of the processor, and a fiftieth of a second where a secret decides.
TEST(MeshCheck, NobodyKnowsWhatCollides) {
    constexpr uint64_t kFactor = 0x9e3779b97f4a7c15u, kEnd = 0x123456789abcdef0u;
    uint64_t inverse = kFactor;  // of the factor, by Newton's method
    for (int i = 0; i < 6; ++i)
        inverse *= 2 - kFactor * inverse;
    const auto folded = [](uint64_t h) { return h ^ (h >> 32); };
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any(1, 2);
    Mesh mesh;
    constexpr size_t kPoints = 60'000;
    while (mesh.positions.size() < kPoints) {
        const double x = any(random);
        const uint64_t after = folded(std::bit_cast<uint64_t>(x) * kFactor);
        const auto y = std::bit_cast<double>(after ^ (folded(kEnd) * inverse));
        if (std::abs(y) > 0.01 && std::abs(y) < 100) mesh.positions.push_back({x, y, 1});
    }
    for (int32_t v = 0; v + 2 < static_cast<int32_t>(kPoints); v += 3)
        mesh.triangles.push_back({v, v + 1, v + 2});
    MeshSource source = source_of(std::move(mesh));
    const std::clock_t before = std::clock();
    EXPECT_FALSE(prepare_mesh(&source));  // it is not closed
    EXPECT_LT(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC, 2);
}

TEST(MeshCheck, NamesShellsThatCutNothingOut) {
    MeshSource nested = source_of(joined({box({0, 0, 0}, 10), box({2, 3, 4}, 5)}));
    ASSERT_TRUE(prepare_mesh(&nested));
    EXPECT_EQ(nested.checks.nested, 1);
    const Vec3d& at = nested.mesh.positions[static_cast<size_t>(nested.mesh.triangles[12][0])];
    EXPECT_EQ(
        nested.warnings,
        (std::vector<std::string>{fmt::format(messages::kShellsInsideShells, "m", "part", "a shell",
                                              fmt::format("({}, {}, {}) mm", at.x, at.y, at.z))}));
    // A solid in the cavity of another is fine.
    MeshSource rattle =
        source_of(joined({box({0, 0, 0}, 10), box({2, 2, 2}, 6, false), box({4, 4, 4}, 2)}));
    ASSERT_TRUE(prepare_mesh(&rattle));
    EXPECT_EQ(rattle.checks.nested, 0);
    EXPECT_EQ(rattle.checks.cavities, 1);
    EXPECT_TRUE(rattle.warnings.empty());
}

/// Boxes side by side that share volume: their sides are coplanar, so that no triangles cross, and vertices of one
/// lie on the other, wherever they begin.
TEST(MeshCheck, NamesShellsThatOverlap) {
    const auto wide = [](const Vec3d& at, const Vec3d& size) {
        Mesh made = box({0, 0, 0}, 1);
        for (Vec3d& p : made.positions)
            p = {at.x + p.x * size.x, at.y + p.y * size.y, at.z + p.z * size.z};
        return made;
    };
    const std::vector<std::pair<Mesh, Mesh>> pairs = {
        {wide({-6, -4, 0}, {8, 8, 8}), wide({-2, -4, 0}, {8, 8, 8})},
        {wide({-2, -4, 0}, {8, 8, 8}), wide({-6, -4, 0}, {8, 8, 8})},
        {wide({0, 0, 0}, {4, 4, 8}), wide({0, 0, 5}, {4, 4, 8})},
        {wide({0, 0, 0}, {9, 3, 3}), wide({3, -3, 0}, {3, 9, 3})},
        {wide({0, 0, 0}, {9, 3, 3}), wide({2, 1, 1}, {10, 4, 4})},
    };
    for (const auto& [one, other] : pairs) {
        MeshSource both = source_of(joined({one, other}));
        ASSERT_TRUE(prepare_mesh(&both));
        EXPECT_EQ(both.checks.overlapping, 1);
        EXPECT_EQ(both.checks.nested, 0);
        ASSERT_EQ(both.warnings.size(), 1U);
        EXPECT_THAT(both.warnings[0],
                    testing::Says(messages::kShellsOverlap, "m", "part", "a pair", "*"));
    }
    // Side by side, or a third one in one of two that overlap.
    MeshSource beside = source_of(joined({box({0, 0, 0}, 4), box({4, 0, 0}, 4)}));
    ASSERT_TRUE(prepare_mesh(&beside));
    EXPECT_TRUE(beside.warnings.empty());
    MeshSource third = source_of(joined({box({0, 0, 0}, 8), box({5, 1, 1}, 8), box({1, 1, 1}, 2)}));
    ASSERT_TRUE(prepare_mesh(&third));
    EXPECT_EQ(third.checks.overlapping, 1);
    EXPECT_EQ(third.checks.nested, 1);
}

TEST(MeshCheck, ManyShellsTakeNoTime) {
    std::vector<Mesh> boxes;
    for (int i = 0; i < 4000; ++i)
        boxes.push_back(box({i % 20 * 3.0, i / 20 % 20 * 3.0, i / 400 * 3.0}, 2, i % 3 != 0));
    MeshSource many = source_of(joined(boxes));
    ASSERT_TRUE(prepare_mesh(&many));
    EXPECT_EQ(many.checks.shells, 4000);
    EXPECT_EQ(many.checks.turned, 1334);
    EXPECT_NEAR(testing::signed_volume(many.mesh), 4000 * 8, 1e-6);
}

TEST(MeshCheck, LeavesOutDuplicatesAndPairsThatCancel) {
    Mesh cube = box({0, 0, 0}, 10);
    const auto t = cube.triangles[4];
    cube.triangles.push_back({t[1], t[2], t[0]});
    MeshSource twice = source_of(cube);
    ASSERT_TRUE(prepare_mesh(&twice));
    EXPECT_EQ(twice.mesh.triangles.size(), 12u);
    EXPECT_EQ(twice.checks.duplicates, 1);
    ASSERT_EQ(twice.warnings.size(), 1u);
    EXPECT_THAT(twice.warnings[0], testing::Says(messages::kRepeatedTriangles, "*", "*", "*1"));
    // An inner wall without thickness: both sides are dropped.
    Mesh wall = box({0, 0, 0}, 10);
    wall.triangles.push_back({0, 2, 5});
    wall.triangles.push_back({0, 5, 2});
    MeshSource walled = source_of(wall);
    ASSERT_TRUE(prepare_mesh(&walled));
    EXPECT_EQ(walled.checks.duplicates, 2);
    EXPECT_NEAR(testing::signed_volume(walled.mesh), 1000, 1e-9);
}

TEST(MeshCheck, WeldsOnlyWithinAPart) {
    // Boxes that share an edge, each triangle with corners of its own: if welded entirely, four
    // triangles would meet at that edge.
    Mesh soup;
    std::vector<int32_t> parts;
    for (int part = 0; part < 2; ++part) {
        const Mesh one = box({part * 10.0, part * 10.0, 0}, 10);
        for (const auto& t : one.triangles) {
            const auto v = static_cast<int32_t>(soup.positions.size());
            soup.triangles.push_back({v, v + 1, v + 2});
            for (int32_t corner : t) {
                soup.positions.push_back(one.positions[corner]);
                parts.push_back(part);
            }
        }
    }
    MeshSource apart = source_of(soup);
    apart.part_of_vertex = parts;
    ASSERT_TRUE(prepare_mesh(&apart));
    EXPECT_EQ(apart.mesh.positions.size(), 16u);
    EXPECT_FALSE(prepare_mesh(&*std::make_unique<MeshSource>(source_of(soup))));
}

/// Of three corners a triangle: joined before and by prepare_mesh.
TEST(MeshCheck, JoinedCornersGiveTheSameMesh) {
    std::mt19937 random(5);
    int closed = 0, refused = 0;
    for (int i = 0; i < 400; ++i) {
        // A box, or two that touch, or cross; with triangles missing, turned, repeated, and without area. Each number is
        // one of single precision, as files have them.
        Mesh whole = box({0, 0, 0}, 10);
        if (i % 4 == 1) whole = joined({whole, box({10, 10, 0}, 10)});
        if (i % 4 == 2) whole = joined({whole, box({4, 3, 2}, 10)});
        const auto some = [&] { return random() % whole.triangles.size(); };
        if (random() % 3 == 0)
            whole.triangles.erase(whole.triangles.begin() + static_cast<std::ptrdiff_t>(some()));
        if (random() % 3 == 0) std::swap(whole.triangles[some()][1], whole.triangles[0][2]);
        if (random() % 3 == 0) whole.triangles.push_back(whole.triangles[some()]);
        if (random() % 3 == 0) whole.triangles.push_back({1, 1, 2});
        if (random() % 3 == 0) std::shuffle(whole.triangles.begin(), whole.triangles.end(), random);
        Mesh soup;
        MeshAttribute color{"color", false, 1, {0.25F, 0.5F, 0.75F}, {}, {}};
        for (const auto& t : whole.triangles) {
            const auto v = static_cast<int32_t>(soup.positions.size());
            soup.triangles.push_back({v, v + 1, v + 2});
            for (const int32_t corner : t) {
                Vec3d p = whole.positions[corner];
                // Equal, and no longer so: -0, and what a shift makes equal again.
                if (p.x == 0 && random() % 4 == 0) p.x = -0.0;
                if (p.y == 0 && random() % 20 == 0) p.y = 1e-30;
                soup.positions.push_back(p);
            }
            color.corners.push_back({v % 3, v % 2, 0});
        }
        soup.attributes.push_back(color);
        MeshSource plain = source_of(soup), early = source_of(soup), short_of_memory = early;
        join_corners(&early, 1'000'000);
        EXPECT_LT(early.mesh.positions.size(), soup.positions.size());
        join_corners(&short_of_memory, 100);
        EXPECT_EQ(short_of_memory.mesh.positions.size(), soup.positions.size());
        const Vec3d shift{random() % 2 == 0 ? 0.0 : 3.0, random() % 2 == 0 ? 0.0 : 7.0, 0};
        early.corners_apart = i % 3 == 0;  // as without a unit and a shift
        for (MeshSource* source : {&plain, &early}) {
            if (early.corners_apart) break;
            for (Vec3d& p : source->mesh.positions)
                p = p * 25.4 - shift;
        }
        const bool repair = random() % 2 == 0;
        const Result<void> a = prepare_mesh(&plain, repair), b = prepare_mesh(&early, repair);
        ASSERT_EQ(a.has_value(), b.has_value()) << i;
        ++(a ? closed : refused);
        EXPECT_EQ(a ? "" : a.error().text(), b ? "" : b.error().text()) << i;
        EXPECT_EQ(plain.warnings, early.warnings) << i;
        EXPECT_EQ(plain.mesh.triangles, early.mesh.triangles) << i;
        EXPECT_EQ(plain.mesh.positions, early.mesh.positions) << i;
        EXPECT_EQ(plain.mesh.attributes[0].corners, early.mesh.attributes[0].corners) << i;
        EXPECT_EQ(plain.mesh.attributes[0].values, early.mesh.attributes[0].values) << i;
        EXPECT_EQ(plain.checks.edges.bad(), early.checks.edges.bad()) << i;
        EXPECT_EQ(plain.checks.edges.triangle, early.checks.edges.triangle) << i;
        EXPECT_EQ(plain.checks.shells, early.checks.shells) << i;
    }
    EXPECT_GT(closed, 100);
    EXPECT_GT(refused, 50);
}

TEST(MeshCheck, CountsTrianglesThatCross) {
    EXPECT_EQ(find_intersections(box({0, 0, 0}, 10)).pairs, 0);
    // Side by side, edge to edge, and on top of each other: only touching.
    for (const Vec3d& at : {Vec3d{10, 0, 0}, Vec3d{10, 10, 0}, Vec3d{5, 5, 10}, Vec3d{10, 3, 3}})
        EXPECT_EQ(find_intersections(joined({box({0, 0, 0}, 10), box(at, 10)})).pairs, 0) << at.x;
    // Intersecting, in general position and where edges meet diagonals.
    const Intersections plain =
        find_intersections(joined({box({0, 0, 0}, 10), box({7, 6.5, 8.25}, 10)}));
    EXPECT_GT(plain.pairs, 0);
    EXPECT_LT(plain.first, 12);
    EXPECT_GE(plain.second, 12);
    EXPECT_TRUE(plain.all);
    Box3d both;
    both.add(Vec3d{7, 6.5, 8.25});
    both.add(Vec3d{10, 10, 10});
    Box3d place;
    place.add(plain.point);
    EXPECT_TRUE(both.overlaps(place)) << plain.point.x << " " << plain.point.y;
    EXPECT_GT(find_intersections(joined({box({0, 0, 0}, 10), box({5, 5, 5}, 10)})).pairs, 0);
}

TEST(MeshCheck, CrossingsAreFoundAsByBruteForce) {
    // Triangles over few random points, far from degenerate: each pair of crossing triangles has an
    // edge of one that goes through the other, by signs of volumes in long double.
    std::mt19937 random(11);
    const auto number = [&] { return static_cast<double>(random() % 20011) / 100; };
    Mesh soup;
    for (int v = 0; v < 90; ++v)
        soup.positions.push_back({number(), number(), number()});
    for (int t = 0; t < 60; ++t) {
        std::array<int32_t, 3> c{};
        do {
            for (int32_t& v : c)
                v = static_cast<int32_t>(random() % 90);
        } while (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]);
        soup.triangles.push_back(c);
    }
    const auto sign = [&](int32_t a, int32_t b, int32_t c, int32_t d) {
        using V = Vec3<long double>;
        const auto p = [&](int32_t v) { return vec_cast<long double>(soup.positions[v]); };
        const V n = cross(p(b) - p(a), p(c) - p(a));
        const long double volume = dot(n, p(d) - p(a));
        return volume > 0 ? 1 : volume < 0 ? -1 : 0;
    };
    const auto through = [&](int32_t p, int32_t q, const std::array<int32_t, 3>& t) {
        const int side = sign(p, q, t[0], t[1]);
        return sign(t[0], t[1], t[2], p) * sign(t[0], t[1], t[2], q) < 0 && side != 0 &&
               sign(p, q, t[1], t[2]) == side && sign(p, q, t[2], t[0]) == side;
    };
    int64_t expected = 0;
    for (size_t i = 0; i < soup.triangles.size(); ++i) {
        for (size_t j = i + 1; j < soup.triangles.size(); ++j) {
            const auto& a = soup.triangles[i];
            const auto& b = soup.triangles[j];
            bool crosses = false;
            for (size_t k = 0; k < 3; ++k) {
                crosses =
                    crosses || through(a[k], a[(k + 1) % 3], b) || through(b[k], b[(k + 1) % 3], a);
            }
            expected += crosses;
        }
    }
    EXPECT_GT(expected, 50);
    EXPECT_EQ(find_intersections(soup).pairs, expected);
}

TEST(MeshCheck, ASearchAtItsLimitFindsTheSameWithAnyThreads) {
    // Strips along x across strips along y, a little steeper: each two cross.
    constexpr int kStrips = 330;
    Mesh grid;
    const auto add = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const auto first = static_cast<int32_t>(grid.positions.size());
        grid.positions.insert(grid.positions.end(), {a, b, c});
        grid.triangles.push_back({first, first + 1, first + 2});
    };
    for (int i = 0; i < kStrips; ++i) {
        const double at = i + 0.5;
        add({-500, at, -1}, {1000, at, -1}, {250, at, 500});
        add({at, -500, -2}, {at, 1000, -2}, {at, 250, 600});
    }
    std::vector<Intersections> found;
    for (const size_t threads : {1, 4}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        found.push_back(find_intersections(grid));
        EXPECT_FALSE(found.back().all);
        EXPECT_EQ(found.back().pairs, 100'000);
    }
    EXPECT_EQ(found[0].first, found[1].first);
    EXPECT_EQ(found[0].second, found[1].second);
}

TEST(MeshCheck, TellsOfMeshesThatCannotBePrinted) {
    testing::TempFolder folder;
    const auto file = folder.write("a.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n");
    EXPECT_FALSE(load_mesh(file, {}));
    const Result<LoadedMesh> told = read_mesh(file, {});
    ASSERT_TRUE(told);
    EXPECT_NE(told->refusal.find("3 open edges"), std::string::npos);
    EXPECT_EQ(told->checks.edges.open, 3);
    EXPECT_EQ(told->mesh.triangles.size(), 1u);
}

}  // namespace
}  // namespace openfab::mesh
