// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The search for cuts: boxes get no more pieces than the best grid, every piece fits, connectors fit, seams
// avoid what is painted; boxes of pieces and distances of connectors against sampling.

#include "tools/split/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

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

/// The least number of pieces of a box of whole centimetres that planes across it make, by trying all of them.
class LeastPieces {
  public:
    explicit LeastPieces(const std::array<int, 3>& tray) : tray_(tray) {}
    int of(std::array<int, 3> box) {
        std::sort(box.begin(), box.end());
        if (box[0] <= tray_[0] && box[1] <= tray_[1] && box[2] <= tray_[2]) return 1;
        const auto [known, fresh] = known_.try_emplace(box, 1 << 20);
        if (!fresh) return known->second;
        int least = 1 << 20;
        for (size_t axis = 0; axis < 3; ++axis) {
            for (int at = 1; 2 * at <= box[axis]; ++at) {
                std::array<int, 3> one = box, other = box;
                one[axis] = at, other[axis] -= at;
                least = std::min(least, of(one) + of(other));
            }
        }
        return known_[box] = least;
    }

  private:
    std::array<int, 3> tray_;  ///< rising
    std::map<std::array<int, 3>, int> known_;
};

TEST(PiecesSearch, BoxesGetTheLeastNumberOfPieces) {
    std::mt19937 random(17);
    const std::array<int, 3> tray{3, 4, 6};
    LeastPieces least(tray);
    int mixed = 0;
    for (int i = 0; i < 25; ++i) {
        std::array<int, 3> size;
        for (int& side : size)
            side = 2 + static_cast<int>(random() % 11);
        constexpr double kCell = 10;
        const Vec3d size_mm{size[0] * kCell, size[1] * kCell, size[2] * kCell};
        const mesh::Mesh box = mesh::make_box(size_mm);
        SearchOptions options;
        options.tray_mm = {tray[2] * kCell, tray[0] * kCell, tray[1] * kCell};
        options.voxels = 20'000;
        options.peg_mm = options.number_mm = 0;
        const Result<Found> found = find_cuts(body_of(box), options);
        ASSERT_TRUE(found) << found.error().text();
        const int wanted = least.of(size);
        EXPECT_EQ(found->pieces, wanted) << size[0] << " x " << size[1] << " x " << size[2];
        mixed += wanted < pieces_of_box(size_mm, options.tray_mm) ? 1 : 0;
    }
    EXPECT_GT(mixed, 3);  // poses mix
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

TEST(PiecesSearch, SectionsKeepAwayFromStress) {
    const mesh::Mesh bar = mesh::make_box({150, 20, 20});
    SearchOptions options;
    options.tray_mm = {100, 100, 100};
    options.voxels = 20'000;
    options.stress = [](const Vec3d& p) { return p.x > -22 && p.x < -15 ? 0.1 : 1.0; };
    const Result<Found> found = find_cuts(body_of(bar), options);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->pieces, 2);
    EXPECT_GT(found->tree.cuts[0].offset_mm, -22);
    EXPECT_LT(found->tree.cuts[0].offset_mm, -15);
}

TEST(PiecesSearch, SeamsLieInCreases) {
    // A bar that is thicker from x = 8 on: any cut in its thin half is as long, one at the step lies in a crease.
    mesh::Mesh bar;
    const auto ring = [&](double x, double half) {
        for (const auto& [y, z] :
             {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
            bar.positions.push_back({x, y * half, z * half});
    };
    ring(-75, 20), ring(8, 20), ring(8, 26), ring(75, 26);
    const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d) {
        bar.triangles.push_back({a, b, c});
        bar.triangles.push_back({a, c, d});
    };
    quad(3, 2, 1, 0), quad(12, 13, 14, 15);
    for (int32_t r = 0; r < 3; ++r) {
        for (int32_t i = 0; i < 4; ++i) {
            const int32_t j = (i + 1) % 4;
            quad(4 * r + i, 4 * r + j, 4 * r + 4 + j, 4 * r + 4 + i);
        }
    }
    SearchOptions options;
    options.tray_mm = {100, 100, 100};
    options.voxels = 60'000;
    const Result<Found> found = find_cuts(body_of(bar), options);
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_EQ(found->pieces, 2);
    EXPECT_NEAR(found->tree.cuts[0].offset_mm, 8, 3 * found->voxel_mm);
    EXPECT_LT(found->tree.cuts[0].offset_mm, 8);
}

TEST(PiecesSearch, SectionsHoldADowelUpToTheirLastTenth) {
    // A dowel of 3 mm with 0.1 mm of clearance and 1.5 mm of skin takes 6.2 mm, in voxels of more than 1 mm.
    for (const double width : {6.1, 6.3, 6.7, 8.0}) {
        mesh::Mesh bar = mesh::make_box({180, width, 24});
        for (Vec3d& p : bar.positions)
            p = p + Vec3d{0.3, 0.77, 0.1};
        SearchOptions options;
        options.tray_mm = {100, 40, 60};
        options.voxels = 20'000;
        options.peg_mm = 3;
        options.number_mm = 0;
        const Result<Found> found = find_cuts(body_of(bar), options);
        ASSERT_TRUE(found);
        ASSERT_EQ(found->pieces, 2);
        EXPECT_GT(found->voxel_mm, 0.9);
        EXPECT_EQ(found->without_peg, width < 6.2 ? 1 : 0) << width;
        EXPECT_EQ(found->tree.cuts[0].connectors.empty(), width < 6.2) << width;
        expect_all_fit(body_of(bar), *found, options.tray_mm);
    }
}

/// A bar of 150 mm, and a block on it from its left end to `right`.
mesh::Mesh bar_with_block(double right) {
    mesh::Mesh bar = mesh::make_box({150, 20, 20});
    const mesh::Mesh block = mesh::make_box({right + 75, 10, 30});
    const auto first = static_cast<int32_t>(bar.positions.size());
    for (const Vec3d& p : block.positions)
        bar.positions.push_back(p + Vec3d{(right - 75) / 2, 0, 10});
    for (const auto& [a, b, c] : block.triangles)
        bar.triangles.push_back({first + a, first + b, first + c});
    return bar;
}

TEST(PiecesSlivers, AreFoundOnBothSidesAndAvoided) {
    for (const bool front : {true, false}) {
        Tree tree;
        tree.pieces = {"1", "2"};
        tree.cuts.resize(1);
        tree.cuts[0].normal = {front ? 1.0 : -1.0, 0, 0};
        tree.cuts[0].offset_mm = front ? -25 : 25;
        tree.cuts[0].back = ~0, tree.cuts[0].front = ~1;
        for (const double beyond : {0.4, 0.003}) {
            const mesh::Mesh bar = bar_with_block(-25 + beyond);
            const std::vector<Sliver> found = find_slivers(body_of(bar), tree);
            ASSERT_EQ(found.size(), 1u);
            EXPECT_NEAR(found[0].thickness_mm, beyond, 1e-9);
            EXPECT_EQ(found[0].front, front);
            Tree moved = tree;
            avoid_slivers(body_of(bar), {101, 60, 60}, &moved);
            EXPECT_TRUE(find_slivers(body_of(bar), moved).empty());
            EXPECT_NEAR(std::fabs(moved.cuts[0].offset_mm), 25 - beyond, 1e-9);
            // Where the pieces would not fit then it stays, and is told.
            moved = tree;
            avoid_slivers(body_of(bar), {90, 90, 90}, &moved);
            EXPECT_EQ(find_slivers(body_of(bar), moved).size(), 1u);
        }
        EXPECT_TRUE(find_slivers(body_of(bar_with_block(-25)), tree).empty());
        EXPECT_TRUE(find_slivers(body_of(bar_with_block(-20)), tree).empty());
        EXPECT_TRUE(find_slivers(body_of(bar_with_block(-25.4)), tree).empty());
    }
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
