// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Outlines that overlap, as areas: what they cover is what their winding numbers say, at any point, and no
// outline of an area touches another.

#include "tools/text/unite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace openfab::text {
namespace {

using mesh::Outline;
using mesh::Point2;

constexpr double kFinest = 1.0 / (1 << 20), kLeast = 1.0 / (1 << 10);

Outline square(double x, double y, double side) {
    return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}
Outline turned(Outline outline) {
    std::reverse(outline.begin(), outline.end());
    return outline;
}

/// By the angle that the outline turns about the point, which it does not touch.
int turns(const Outline& outline, const Point2& p) {
    double sum = 0;
    for (size_t i = 0; i < outline.size(); ++i) {
        const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        const double ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y;
        sum += std::atan2(ax * by - ay * bx, ax * bx + ay * by);
    }
    return static_cast<int>(std::lround(sum / (2 * 3.14159265358979323846)));
}

double distance(const Outline& outline, const Point2& p) {
    double least = 1e9;
    for (size_t i = 0; i < outline.size(); ++i) {
        const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        const double x = b.x - a.x, y = b.y - a.y;
        const double t =
            std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / (x * x + y * y + 1e-30), 0.0, 1.0);
        least = std::min(least, std::hypot(a.x + t * x - p.x, a.y + t * y - p.y));
    }
    return least;
}

/// Checks the areas at points that are not next to an outline; returns the areas.
std::vector<Area> checked(const std::vector<Glyph>& glyphs, const std::string& what = {}) {
    const std::vector<Area> areas = unite(glyphs, kFinest, kLeast);
    for (const Area& area : areas) {
        const Result<void> fine = mesh::check_outlines(area);
        EXPECT_TRUE(fine) << what << fine.error().text();
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-1, 11);
    for (int k = 0; k < 300; ++k) {
        const Point2 p{place(random), place(random)};
        int winding = 0, covered = 0;
        double least = 1e9;
        for (const Glyph& glyph : glyphs) {
            for (const Outline& outline : glyph) {
                winding += turns(outline, p);
                least = std::min(least, distance(outline, p));
            }
        }
        if (least < 4 * kLeast) continue;
        for (const Area& area : areas) {
            int within = 0;
            for (size_t o = 0; o < area.size(); ++o) {
                const int times = turns(area[o], p);
                EXPECT_TRUE(o == 0 ? times == 0 || times == 1 : times == 0 || times == -1) << what;
                within += times;
            }
            covered += within;
        }
        EXPECT_EQ(covered, winding != 0 ? 1 : 0) << fmt::format("{} at ({}, {})", what, p.x, p.y);
    }
    return areas;
}

TEST(Unite, AreasAreThoseOfTheNonzeroRule) {
    EXPECT_EQ(checked({{square(0, 0, 10)}}).size(), 1U);
    // A hole, and what has none since both go around alike.
    EXPECT_EQ(checked({{square(0, 0, 10), turned(square(3, 3, 4))}})[0].size(), 2U);
    EXPECT_EQ(checked({{square(0, 0, 10), square(3, 3, 4)}})[0].size(), 1U);
    // An island in a hole is an area of its own.
    EXPECT_EQ(checked({{square(0, 0, 10), turned(square(1, 1, 8)), square(3, 3, 2)}}).size(), 2U);
    // Letters that overlap, and that go around in different ways: as fonts of either kind have them.
    EXPECT_EQ(checked({{square(0, 0, 6)}, {square(4, 4, 6)}}).size(), 1U);
    EXPECT_EQ(checked({{turned(square(0, 0, 6))}, {turned(square(4, 4, 6))}}).size(), 1U);
    // An outline that crosses itself.
    EXPECT_EQ(checked({{{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}}).size(), 2U);
    EXPECT_EQ(checked({{{{5, 0}, {8, 9}, {0, 3}, {10, 3}, {2, 9}}}})[0].size(), 1U) << "a star";
    // Sides in common.
    const auto abutting = checked({{square(0, 0, 5)}, {square(5, 0, 5)}, {square(0, 5, 5)}});
    ASSERT_EQ(abutting.size(), 1U);
    EXPECT_EQ(abutting[0][0].size(), 6U);
    EXPECT_EQ(checked({{square(1, 1, 5)}, {square(1, 1, 5)}})[0][0].size(), 4U) << "twice";
    EXPECT_TRUE(checked({{square(1, 1, 5), turned(square(1, 1, 5))}}).empty()) << "to and fro";
    EXPECT_TRUE(checked({}).empty());
    EXPECT_TRUE(checked({{{{0, 0}, {10, 0}, {5, 0}}}}).empty()) << "of no area";
    // Corners that touch are parted.
    EXPECT_EQ(checked({{square(0, 0, 5)}, {square(5, 5, 5)}}).size(), 2U);
    EXPECT_EQ(checked({{square(0, 0, 10), turned({{0, 0}, {5, 4}, {4, 5}})}})[0].size(), 1U);
    EXPECT_EQ(
        checked({{square(0, 0, 10), turned(square(2, 2, 3)), turned(square(5, 5, 3))}})[0].size(),
        2U)
        << "two holes that touch are one";
    // A slit between two strokes that meet at both ends is closed.
    EXPECT_EQ(checked({{{{0, 0}, {5.0001, 0}, {5.0001, 10}, {0, 10}}},
                       {{{5.0002, 0}, {10, 0}, {10, 10}, {5.0002, 10}}},
                       {{{4, 0}, {6, 0}, {6, 1}, {4, 1}}},
                       {{{4, 9}, {6, 9}, {6, 10}, {4, 10}}}})[0]
                  .size(),
              1U);
}

TEST(Unite, AnyOutlinesBecomeAreas) {
    for (unsigned seed = 1; seed <= 150; ++seed) {
        std::mt19937 random(seed);
        // On a coarse lattice much lies in line, at one place and on sides.
        const double step = seed % 3 == 0 ? 1.0 : seed % 3 == 1 ? 0.25 : 1e-6;
        std::uniform_real_distribution<double> place(0, 10);
        std::uniform_int_distribution<int> count(3, seed % 5 == 0 ? 32 : 9);
        std::vector<Glyph> glyphs(1 + seed % 4);
        for (Glyph& glyph : glyphs) {
            for (unsigned o = 0; o <= seed % 2; ++o) {
                Outline outline;
                for (int k = count(random); k > 0; --k)
                    outline.push_back({std::round(place(random) / step) * step,
                                       std::round(place(random) / step) * step});
                glyph.push_back(std::move(outline));
            }
        }
        (void)checked(glyphs, fmt::format("seed {}: ", seed));
    }
}

}  // namespace
}  // namespace openfab::text
