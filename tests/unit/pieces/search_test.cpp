// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The search for cuts: boxes get no more pieces than the best grid, every piece fits, connectors fit, seams
// avoid what is painted; boxes of pieces and distances of connectors against sampling.

#include "pieces/search.h"

#include <gtest/gtest.h>

#include <random>

#include "mesh/model/primitives.h"

namespace openfab::pieces {
namespace {

constexpr std::array<double, 9> kSame{1, 0, 0, 0, 1, 0, 0, 0, 1};

Body body_of(const mesh::Mesh& mesh) {
    return {mesh.positions, mesh.triangles};
}

void expect_all_fit(const Body& body, const Found& found, const Vec3d& tray) {
    for (const Region& region : regions(found.tree)) {
        const Box3d box = piece_box(body, region, {});
        ASSERT_FALSE(box.empty()) << region.name;
        EXPECT_TRUE(fits(box.size(), tray)) << region.name;
        SourceLocation at;
        EXPECT_EQ(misfit(body, mapped(region, kSame, {}), 0, &at), "");
    }
}

TEST(PiecesSearch, BoxesGetNoMoreThanTheBestGrid) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> side(30, 260);
    for (int i = 0; i < 12; ++i) {
        const Vec3d size{side(random), side(random), side(random)};
        const Vec3d tray{110, 80, 70};
        const mesh::Mesh box = mesh::make_box(size);
        SearchOptions options;
        options.tray_mm = tray;
        options.voxels = 20'000;
        const Result<Found> found = find_cuts(body_of(box), options);
        ASSERT_TRUE(found) << found.error().text();
        // Of the best grid, or fewer, where poses mix; never fewer than the volume needs.
        EXPECT_LE(found->pieces, pieces_of_box(size, tray));
        EXPECT_GE(found->pieces * tray.x * tray.y * tray.z, size.x * size.y * size.z);
        if (found->pieces > 1) expect_all_fit(body_of(box), *found, tray);
    }
}

TEST(PiecesSearch, ExactMultiplesOfTheTrayNeedNoMore) {
    const mesh::Mesh box = mesh::make_box({200, 100, 50});
    SearchOptions options;
    options.tray_mm = {100, 100, 50};
    options.voxels = 20'000;
    const Result<Found> found = find_cuts(body_of(box), options);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->pieces, 2);
    ASSERT_EQ(found->tree.cuts.size(), 1u);
    EXPECT_EQ(found->tree.cuts[0].connectors.size(), 2u);
    EXPECT_EQ(found->tree.cuts[0].numbers.size(), 1u);
}

TEST(PiecesSearch, SeamsGoWhereTheyAreWanted) {
    // A bar that must be cut once, where a belt is painted.
    const mesh::Mesh bar = mesh::make_box({150, 20, 20});
    SearchOptions options;
    options.tray_mm = {100, 100, 100};
    options.voxels = 20'000;
    options.seam = [](const Vec3d& p) { return p.x > 12 && p.x < 20 ? 0.0 : 1.0; };
    const Result<Found> found = find_cuts(body_of(bar), options);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->pieces, 2);
    EXPECT_GT(found->tree.cuts[0].offset_mm, 12);
    EXPECT_LT(found->tree.cuts[0].offset_mm, 20);
}

TEST(PiecesExtent, TheDistanceOfACylinderIsThatOfItsSamples) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> real(-4, 4);
    for (int i = 0; i < 100; ++i) {
        Shape shape;
        shape.radius = 1;
        shape.hi = 2;
        std::array<Vec3d, 3> t;
        for (Vec3d& p : t)
            p = {real(random), real(random), real(random) + 1};
        double least = 1e30;
        for (int a = 0; a <= 60; ++a) {
            for (int b = 0; a + b <= 60; ++b) {
                const Vec3d p =
                    t[0] * (a / 60.0) + t[1] * (b / 60.0) + t[2] * ((60 - a - b) / 60.0);
                least = std::min(least, length(p - shape.nearest(p)));
            }
        }
        // Samples are at most a step of the triangle's sides from the nearest point.
        const double step = 14.0 / 60;
        EXPECT_LE(distance(shape, t), least + 1e-9);
        EXPECT_GE(distance(shape, t), least - step);
    }
}

}  // namespace
}  // namespace openfab::pieces
