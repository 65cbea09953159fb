// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Outlines, their triangles, and what is swept from them: areas and volumes are those of the outlines
// to rounding, every mesh is closed, and what is no area is refused with its place.

#include "mesh/model/sweeps.h"
#include "mesh/model/messages.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "tests/support/meshes/meshes.h"
#include "tests/support/says/says.h"

namespace openfab::mesh {
namespace {

using ::testing::HasSubstr;
using Random = std::mt19937;

double uniform(Random* random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(*random);
}

double area_of(const Outline& outline) {
    double sum = 0;
    for (size_t i = 0; i < outline.size(); ++i) {
        const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        sum += (a.x * b.y - a.y * b.x) / 2;
    }
    return sum;
}

/// Twice the volume by Pappus, per radian: the sum over the triangles from the axis.
double revolved_volume(const Outline& outline) {
    double sum = 0;
    for (size_t i = 0; i < outline.size(); ++i) {
        const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        sum += (a.x * b.y - a.y * b.x) * (a.x + b.x) / 6;
    }
    return std::abs(sum);
}

/// A star around a point, whose corners are at random distances between the two.
Outline star(Random* random, const Point2& middle, double least, double most, int corners) {
    Outline out;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * (i + uniform(random, 0, 0.8)) / corners;
        const double r = uniform(random, least, most);
        out.push_back({middle.x + r * std::cos(angle), middle.y + r * std::sin(angle)});
    }
    if (random->operator()() % 2 == 0) std::reverse(out.begin(), out.end());
    return out;
}

/// Returns the first fault: an edge without exactly one opposite, or a triangle without area.
std::string open_edges(const Mesh& mesh) {
    std::map<std::pair<int32_t, int32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
        for (size_t i = 0; i < 3; ++i) {
            if (++edges[{t[i], t[(i + 1) % 3]}] > 1) return "an edge is passed twice";
        }
        const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        if (length(cross(b - a, c - a)) == 0) return "a triangle has no area";
    }
    for (const auto& [edge, count] : edges) {
        if (!edges.contains({edge.second, edge.first})) return "an edge is open";
    }
    return {};
}

TEST(Outlines, ATriangulationCoversTheAreaOnce) {
    Random random(1);
    int tried = 0;
    for (int round = 0; round < 300; ++round) {
        // A star with holes in a grid, and islands in some of the holes.
        std::vector<Outline> outlines{star(&random, {0, 0}, 10, 30, 5 + round % 60)};
        for (int x = -1; x <= 1; ++x) {
            for (int y = -1; y <= 1; ++y) {
                const Point2 middle{4.5 * x + uniform(&random, -0.2, 0.2), 4.5 * y};
                if (random() % 3 == 0) continue;
                outlines.push_back(star(&random, middle, 1, 2, 3 + static_cast<int>(random() % 9)));
                if (random() % 2 == 0) outlines.push_back(star(&random, middle, 0.05, 0.2, 4));
            }
        }
        if (!check_outlines(outlines)) continue;  // a triangle may miss its middle, or meet another
        std::shuffle(outlines.begin(), outlines.end(), random);
        orient_outlines(&outlines);
        double area = 0, covered = 0;
        for (const Outline& outline : outlines)
            area += area_of(outline);
        for (const auto& t : triangulate_area(outlines)) {
            const double part =
                area_of({outlines[t[0].outline][t[0].corner], outlines[t[1].outline][t[1].corner],
                         outlines[t[2].outline][t[2].corner]});
            ASSERT_GE(part, 0) << round;
            covered += part;
        }
        ASSERT_NEAR(covered, area, 1e-9 * area) << round;
        const Mesh mesh = make_extrusion(outlines, 2);
        ASSERT_EQ(open_edges(mesh), "") << round;
        ASSERT_NEAR(testing::signed_volume(mesh), 2 * area, 1e-9 * area) << round;
        ++tried;
    }
    EXPECT_GT(tried, 150);
}

/// Letters as fonts have them: holes whose corners lie on the same lines as the outline's, and on
/// each other's.
TEST(Outlines, HolesInLine) {
    const auto square = [](double x, double y, double size) {
        return Outline{{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}};
    };
    std::vector<Outline> outlines{square(0, 0, 16)};
    for (int x = 0; x < 3; ++x) {
        for (int y = 0; y < 3; ++y)
            outlines.push_back(square(1 + 5 * x, 1 + 5 * y, 4));
    }
    outlines.push_back(square(2, 2, 1));
    ASSERT_TRUE(check_outlines(outlines));
    const Mesh mesh = make_extrusion(outlines, 1);
    EXPECT_EQ(open_edges(mesh), "");
    EXPECT_NEAR(testing::signed_volume(mesh), 256 - 9 * 16 + 1, 1e-9);
}

TEST(Outlines, WhatIsNoAreaIsRefused) {
    const auto refusal = [](const std::vector<Outline>& outlines) {
        const Result<void> fine = check_outlines(outlines);
        return fine ? std::string("fine") : fine.error().text();
    };
    const Outline square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    EXPECT_EQ(refusal({square}), "fine");
    EXPECT_EQ(refusal({square, {{1, 1}, {2, 1}, {2, 2}}}), "fine");
    EXPECT_EQ(refusal({square, {{5, 0}, {6, 0}, {6, 1}}}), "fine") << "two parts";
    EXPECT_EQ(refusal({{{0, 0}, {2, 0}, {4, 0}, {4, 4}}}), "fine") << "a corner on a side's way";
    EXPECT_THAT(refusal({{{0, 0}, {1, 1}}}), testing::Says(messages::kPolygonFewerThan3Corners));
    EXPECT_THAT(refusal({{{0, 0}, {4, 0}, {4, 4}, {0, 0}}}),
                testing::Says(messages::kPolygonTwiceAtCorner, 0, 0));
    EXPECT_THAT(refusal({{{0, 0}, {4, 4}, {4, 0}, {0, 4}}}),
                testing::Says(messages::kPolygonMeetsItself));
    EXPECT_THAT(refusal({{{0, 0}, {4, 0}, {2, 0}}}), testing::Says(messages::kPolygonMeetsItself))
        << "back along itself";
    EXPECT_THAT(refusal({{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}}),
                testing::Says(messages::kPolygonMeetsItself))
        << "touches";
    EXPECT_THAT(refusal({square, {{3, 3}, {6, 3}, {6, 6}}}),
                testing::Says(messages::kPolygonMeetsItself));
    EXPECT_THAT(refusal({square, square}), testing::Says(messages::kPolygonMeetsItself));
    EXPECT_THAT(refusal({Outline(kMostOutlineCorners + 1, {0, 0})}),
                testing::Says(messages::kPolygonTwiceAtCorner));
    Random random(3);
    EXPECT_THAT(refusal({star(&random, {0, 0}, 1, 2, kMostOutlineCorners + 1)}),
                testing::Says(messages::kPolygonTooManyCorners, "*2001"));
}

TEST(Sweeps, ARevolutionHasItsVolume) {
    // Of 128 facets: inscribed in the circle.
    const double facets = 64 / std::numbers::pi * std::sin(std::numbers::pi / 64);
    Random random(2);
    int tried = 0;
    for (int round = 0; round < 40; ++round) {
        Outline outline = star(&random, {4, 1}, 1, 3.9, 3 + round % 20);
        if (!check_outlines({outline})) continue;
        const Mesh mesh = make_revolution(outline);
        ASSERT_EQ(open_edges(mesh), "") << round;
        const double volume = 2 * std::numbers::pi * revolved_volume(outline) * facets;
        ASSERT_NEAR(testing::signed_volume(mesh), volume, 1e-9 * volume) << round;
        ++tried;
    }
    EXPECT_GT(tried, 30);
    // On the axis: a side, a corner, and both.
    for (const Outline& outline :
         {Outline{{0, 0}, {2, 0}, {2, 3}, {0, 3}}, Outline{{0, 0}, {2, 1}, {2, -1}},
          Outline{{0, 0}, {3, 0}, {0, 1}, {2, 2}, {0, 3}}}) {
        const Mesh mesh = make_revolution(outline);
        EXPECT_EQ(open_edges(mesh), "");
        EXPECT_NEAR(testing::signed_volume(mesh),
                    2 * std::numbers::pi * revolved_volume(outline) * facets, 1e-9);
    }
}

/// Normals are those of the smooth surfaces, and the faces are told apart.
TEST(Sweeps, NormalsAreSmoothWhereTheOutlineIs) {
    const auto each_corner = [](const Mesh& mesh, auto visit) {
        const MeshAttribute& n = *mesh.find("n");
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            for (size_t c = 0; c < 3; ++c) {
                const float* v = &n.values[static_cast<size_t>(n.corners[t][c]) * 3];
                visit(mesh.positions[mesh.triangles[t][c]], Vec3d{v[0], v[1], v[2]},
                      mesh.find("face")->faces[t]);
            }
        }
    };
    each_corner(make_torus(10, 4), [](const Vec3d& p, const Vec3d& n, int32_t face) {
        const double r = std::sqrt(p.x * p.x + p.y * p.y);
        const Vec3d middle{p.x / r * 5, p.y / r * 5, 2};
        ASSERT_NEAR(dot(n, (p - middle) * 0.5), 1, 1e-6);
        ASSERT_EQ(face, 2);
    });
    each_corner(make_capsule(4, 10), [](const Vec3d& p, const Vec3d& n, int32_t) {
        const Vec3d middle{0, 0, std::clamp(p.z, 2.0, 8.0)};
        ASSERT_GT(dot(n, (p - middle) * 0.5), 0.998);  // the tip's facets have their own normals
    });
    int tops = 0, bottoms = 0;
    each_corner(make_cone(6, 2, 4), [&](const Vec3d& p, const Vec3d& n, int32_t face) {
        ASSERT_NEAR(n.z, face == 0 ? 1 : face == 1 ? -1 : 2 / std::sqrt(20.0), 1e-6);
        if (face != 2) {
            ASSERT_EQ(p.z, face == 0 ? 4 : 0);
        }
        tops += face == 0 ? 1 : 0;
        bottoms += face == 1 ? 1 : 0;
    });
    EXPECT_EQ(tops, 3 * 128);
    EXPECT_EQ(bottoms, 3 * 128);
    // A square has edges, a polygon of 36 corners none.
    int flat = 0;
    each_corner(make_extrusion({{{0, 0}, {2, 0}, {2, 2}, {0, 2}}}, 1),
                [&](const Vec3d&, const Vec3d& n, int32_t face) {
                    flat += face == 2 && std::abs(n.x) + std::abs(n.y) == 1 ? 1 : 0;
                });
    EXPECT_EQ(flat, 4 * 2 * 3);
}

TEST(Sweeps, ShapesHaveTheirVolumes) {
    const double pi = std::numbers::pi;
    const std::pair<Mesh, double> shapes[] = {{make_cone(6, 0, 4), pi * 9 * 4 / 3},
                                              {make_cone(0, 6, 4), pi * 9 * 4 / 3},
                                              {make_cone(6, 2, 4), pi * 4 / 3 * (9 + 3 + 1)},
                                              {make_torus(10, 4), 2 * pi * 5 * pi * 4},
                                              {make_capsule(4, 10), pi * 4 * 6 + 4 * pi * 8 / 3},
                                              {make_capsule(4, 4), 4 * pi * 8 / 3}};
    for (const auto& [mesh, volume] : shapes) {
        EXPECT_EQ(open_edges(mesh), "");
        EXPECT_NEAR(testing::signed_volume(mesh), volume, 3e-3 * volume);
        double lowest = 1;
        for (const Vec3d& p : mesh.positions)
            lowest = std::min(lowest, p.z);
        EXPECT_EQ(lowest, 0);
    }
}

}  // namespace
}  // namespace openfab::mesh
