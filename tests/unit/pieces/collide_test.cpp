// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Connectors and numbers of a piece against each other: distances against sampling, and what is refused.

#include "pieces/collide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pieces/tree.h"

namespace openfab::pieces {
namespace {

constexpr std::array<double, 9> kSame{1, 0, 0, 0, 1, 0, 0, 0, 1};

Vec3d unit(const Vec3d& v) {
    return v * (1 / length(v));
}

/// A cylinder, a dovetail or a text somewhere.
Shape random_shape(std::mt19937* random) {
    std::uniform_real_distribution<double> real(-1, 1);
    Shape s;
    s.at = Vec3d{real(*random), real(*random), real(*random)} * 4.0;
    s.n = unit({real(*random), real(*random), real(*random) + 2});
    s.v = upright(s.n);
    s.u = cross(s.v, s.n);
    s.hi = 1.5 + real(*random);
    switch ((*random)() % 3) {
        case 0:
            s.radius = 1.2 + real(*random);
            break;
        case 1:
            s.kind = Shape::Kind::kDovetail;
            s.half_width = 0.8, s.slope = 0.3, s.half_length = 2;
            break;
        default:
            s.kind = Shape::Kind::kStrokes;
            s.strokes = {{-1, -1, -1, 1}, {-1, 1, 0.5, 0}, {0.5, 0, 1, -1}};
            s.radius = 0.25;
            break;
    }
    return s;
}

TEST(PiecesCollide, DistancesOfShapesAreThoseOfTheirSamples) {
    std::mt19937 random(11);
    int apart = 0;
    for (int i = 0; i < 60; ++i) {
        const Shape a = random_shape(&random), b = random_shape(&random);
        constexpr double kStep = 0.25;
        std::vector<Vec3d> in_a, in_b;
        const auto sample = [&](const Shape& s, std::vector<Vec3d>* out) {
            const Box3d of = s.box();
            for (double z = of.lo.z; z <= of.hi.z; z += kStep) {
                for (double y = of.lo.y; y <= of.hi.y; y += kStep) {
                    for (double x = of.lo.x; x <= of.hi.x; x += kStep) {
                        if (s.contains({x, y, z})) out->push_back({x, y, z});
                    }
                }
            }
        };
        sample(a, &in_a);
        sample(b, &in_b);
        if (in_a.empty() || in_b.empty()) continue;
        double least = 1e30;
        for (const Vec3d& p : in_a) {
            for (const Vec3d& q : in_b)
                least = std::min(least, length(p - q));
        }
        const double found = distance(a, b);
        EXPECT_LE(found, least + 1e-6);
        // Every place of a shape is within a cell's diagonal of a sample.
        EXPECT_GE(found, least - 2 * kStep * std::sqrt(3.0)) << i;
        EXPECT_NEAR(found, distance(b, a), 2e-4);
        apart += found > 0 ? 1 : 0;
    }
    EXPECT_GT(apart, 20);
}

Connector connector(Connector::Kind kind, const Vec3d& at, double diameter) {
    Connector c;
    c.kind = kind;
    c.at_mm = at;
    c.diameter_mm = diameter;
    c.length_mm = 4;
    c.skin_mm = 1;
    return c;
}

std::string collision_in(const Tree& tree) {
    for (const Region& region : regions(tree)) {
        SourceLocation at;
        const std::string text = collision(mapped(region, kSame, {}), &at);
        if (!text.empty()) return text;
    }
    return "";
}

TEST(PiecesCollide, ConnectorsKeepTheSkinBetweenThem) {
    Tree tree;
    tree.pieces = {"1", "2"};
    tree.cuts.resize(1);
    tree.cuts[0].back = ~0;
    tree.cuts[0].front = ~1;
    auto& all = tree.cuts[0].connectors;
    // Cylinders of 4 mm, 5.2 mm apart: 1.2 mm of wall.
    all = {connector(Connector::Kind::kPeg, {0, 0, 0}, 4),
           connector(Connector::Kind::kMagnet, {5.2, 0, 0}, 4)};
    EXPECT_EQ(collision_in(tree), "");
    all[1].clearance_mm = 0.3;
    EXPECT_EQ(collision_in(tree),
              "the hole of the magnet is 0.9 mm from the hole of the peg in piece `2`, and 1 mm "
              "are asked for");
    // The less demanding one counts.
    all[0].skin_mm = 0.8;
    EXPECT_EQ(collision_in(tree), "");
    all[1].at_mm.x = 4;
    EXPECT_EQ(collision_in(tree),
              "the hole of the magnet runs into the hole of the peg in piece "
              "`2`");
}

TEST(PiecesCollide, HolesOfTwoCutsOfOnePieceMeet) {
    // A slice 5 mm thick with a dowel of 8 mm, 4 mm deep, from either side.
    Tree tree;
    tree.pieces = {"1", "2.1", "2.2"};
    tree.cuts.resize(2);
    tree.cuts[0].back = ~0, tree.cuts[0].front = 1;
    tree.cuts[1].offset_mm = 5;
    tree.cuts[1].back = ~1, tree.cuts[1].front = ~2;
    Connector dowel = connector(Connector::Kind::kDowel, {0, 0, 0}, 2);
    dowel.length_mm = 8;
    tree.cuts[0].connectors = {dowel};
    tree.cuts[1].connectors = {dowel};
    EXPECT_EQ(collision_in(tree),
              "the hole of the dowel runs into the hole of the dowel in piece `2.1`");
    tree.cuts[1].connectors[0].at_mm.x = 3.5;
    EXPECT_EQ(collision_in(tree), "");
}

TEST(PiecesCollide, ANumberKeepsOffAPeg) {
    Tree tree;
    tree.pieces = {"1", "2"};
    tree.cuts.resize(1);
    tree.cuts[0].back = ~0, tree.cuts[0].front = ~1;
    tree.cuts[0].connectors = {connector(Connector::Kind::kPeg, {4, 0, 0}, 4)};
    Number number;
    number.height_mm = 6, number.depth_mm = 0.5;
    tree.cuts[0].numbers = {number};
    EXPECT_EQ(collision_in(tree), "");
    tree.cuts[0].connectors[0].at_mm.x = 2.5;
    EXPECT_EQ(collision_in(tree), "the hole of the peg runs into a number in piece `2`");
}

}  // namespace
}  // namespace openfab::pieces
