// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/time_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

namespace openfab::pipeline {
namespace {

/// A print whose slab z takes seconds(z) for its blocks(z), and dices so many patches when something
/// is first printed of it or a slab beside it, each of which takes `of_patch`.
struct Print {
    std::function<double(int32_t)> seconds = [](int32_t) { return 0.01; };
    std::function<int64_t(int32_t)> blocks = [](int32_t) { return 1000; };
    int64_t patches_a_slab = 0;
    double of_patch = 0;
    int64_t tree_bytes = 0;  ///< of the trees of a patch, whole or in pieces
    double of_rebuilt = 0;   ///< seconds for the trees of a patch whose first were evicted

    std::vector<int32_t> tried, counted;
    std::set<int32_t> diced;

    Result<SlabTrial> operator()(const SlabTry& wanted) {
        constexpr int32_t kPieces = 16;
        const int32_t slab = wanted.slab, pieces = wanted.pieces;
        SlabTrial trial;
        trial.blocks = blocks(slab);
        if (pieces == 0) {
            counted.push_back(slab);
            trial.share = 0;
            return trial;
        }
        tried.push_back(slab);
        int64_t patches = 0;
        for (int32_t near = slab - 1; near <= slab + 1; ++near)
            patches += diced.insert(near).second ? patches_a_slab : 0;
        const int64_t rebuilt = wanted.drop_trees ? 3 * patches_a_slab : 0;
        const double whole = seconds(slab) + of_patch * static_cast<double>(patches) +
                             of_rebuilt * static_cast<double>(rebuilt);
        trial.share =
            std::min({1.0, wanted.seconds / whole, static_cast<double>(pieces) / kPieces});
        trial.pieces = std::min(pieces, static_cast<int32_t>(std::ceil(kPieces * trial.share)));
        trial.seconds = trial.processor_seconds = whole * trial.share;
        const auto of_share = [&](int64_t all) {
            return static_cast<int64_t>(trial.share * static_cast<double>(all));
        };
        trial.patches_diced = of_share(patches);
        trial.tree_bytes = of_share((patches + rebuilt) * tree_bytes);
        return trial;
    }
    TimeSample sample(const Vec2<int32_t>& slabs, double room, const PatchNeeds& needs = {}) {
        return *sample_time(slabs, room, needs, std::ref(*this));
    }
};

TEST(TimeSample, IsExactWhereTheTimeIsLinearInHeight) {
    Print print;
    print.seconds = [](int32_t slab) { return slab * 1e-4; };
    const TimeSample sample = print.sample({100, 800}, 3);
    EXPECT_EQ(sample.places, 15);
    EXPECT_EQ(sample.share, 1);
    // From 0.0100 to 0.0799 s; what is tried is the upper neighbour of the middle of a part.
    EXPECT_NEAR(sample.seconds, 700 * 0.04495, 700 * 0.00016);
    EXPECT_NEAR(sample.slowest_slab_seconds, 0.0777, 1e-9);
    EXPECT_EQ(print.tried[0], 450);
    EXPECT_EQ(print.tried[1], 451);
    const std::set<int32_t> once(print.tried.begin(), print.tried.end());
    EXPECT_EQ(once.size(), 30u);
    EXPECT_GE(*once.begin(), 100);
    EXPECT_LT(*once.rbegin(), 800);
}

TEST(TimeSample, OfLowPrintsTriesEachSlabOnce) {
    for (int32_t count = 1; count < 20; ++count) {
        Print print;
        const TimeSample sample = print.sample({5, 5 + count}, 3);
        EXPECT_NEAR(sample.seconds, 0.01 * count, 1e-12);
        EXPECT_GE(*std::min_element(print.tried.begin(), print.tried.end()), 5);
        EXPECT_LT(*std::max_element(print.tried.begin(), print.tried.end()), 5 + count);
        if (count <= 4) {
            EXPECT_EQ(print.tried.size(), static_cast<size_t>(count));
        }
    }
    // What is diced is part of it, and the last slab, which is stopped, is scaled up.
    Print print;
    print.patches_a_slab = 100;
    print.of_patch = 0.001;
    const TimeSample sample = print.sample({0, 3}, 0.45, {500, 0});
    EXPECT_EQ(print.tried, (std::vector<int32_t>{0, 1, 2}));
    EXPECT_NEAR(sample.seconds, 3 * 0.01 + 0.5, 1e-9);
}

TEST(TimeSample, DicingCountsOncePerPatch) {
    Print print;
    print.patches_a_slab = 50;
    print.of_patch = 0.0005;
    const TimeSample sample = print.sample({0, 200}, 3, {200 * 50, 0});
    EXPECT_NEAR(sample.seconds, 200 * (0.01 + 50 * 0.0005), 0.01);
    EXPECT_NEAR(sample.dicing_seconds, 200 * 50 * 0.0005, 0.01);
}

TEST(TimeSample, DicingIsToldFromStoppedTrials) {
    Print print;
    print.seconds = [](int32_t) { return 2.0; };
    print.patches_a_slab = 1000;
    print.of_patch = 0.005;
    const TimeSample sample = print.sample({0, 200}, 3, {200 * 1000, 0});
    EXPECT_EQ(sample.places, 1);
    EXPECT_LT(sample.share, 0.2);
    EXPECT_NEAR(sample.seconds, 200 * (2 + 1000 * 0.005), 20);
}

TEST(TimeSample, TreesAreBuiltAgainWhereASlabNeedsMoreThanThereIsRoomFor) {
    Print print;
    print.seconds = [](int32_t) { return 2.0; };
    print.patches_a_slab = 1000;
    print.of_patch = 0.005;
    print.tree_bytes = 1000;
    print.of_rebuilt = 0.002;
    const int64_t of_slab = 3 * print.patches_a_slab * print.tree_bytes;
    const double once = 200 * (2 + 1000 * 0.005);
    Print fits = print;
    EXPECT_NEAR(fits.sample({0, 200}, 3, {200 * 1000, of_slab + 100'000}).seconds, once, 20);
    // Those of pieces fill all the room, and are built twice again.
    EXPECT_NEAR(print.sample({0, 200}, 3, {200 * 1000, of_slab - 100'000}).seconds,
                once + 2 * 200 * 1000 * 0.002, 60);
}

TEST(TimeSample, OfLowPrintsNoSlabCountsForAnother) {
    // The two upper ones of 12 take all the time, which more than two places would meet.
    Print print;
    print.seconds = [](int32_t slab) { return slab < 10 ? 0.001 : 0.2; };
    EXPECT_NEAR(print.sample({0, 12}, 3).seconds, 10 * 0.001 + 2 * 0.2, 1e-9);
    const std::set<int32_t> once(print.tried.begin(), print.tried.end());
    EXPECT_EQ(once.size(), print.tried.size());
    // Nor do patches that no slab needs.
    Print diced;
    diced.patches_a_slab = 50;
    diced.of_patch = 0.0005;
    EXPECT_NEAR(diced.sample({0, 12}, 3, {5000, 0}).seconds, 12 * 0.01 + 14 * 50 * 0.0005, 0.002);
}

TEST(TimeSample, PlacesThatWereNotTriedCountByTheirBlocks) {
    // A cone: the middle has a third of the blocks that the mean has, by squares of the height.
    Print print;
    print.blocks = [](int32_t slab) { return int64_t{slab} * slab; };
    print.seconds = [&](int32_t slab) { return 1e-3 * static_cast<double>(print.blocks(slab)); };
    const TimeSample sample = print.sample({0, 70}, 2.9);
    double whole = 0;
    for (int32_t slab = 0; slab < 70; ++slab)
        whole += print.seconds(slab);
    EXPECT_LT(sample.places, 7);
    EXPECT_GE(print.counted.size(), 3u);
    EXPECT_NEAR(sample.seconds, whole, 0.1 * whole);
}

TEST(TimeSample, OfOneSlabThatWasStoppedIsMarkedSo) {
    Print print;
    print.seconds = [](int32_t) { return 9.0; };
    const TimeSample sample = print.sample({0, 1}, 0.9);
    EXPECT_EQ(sample.places, 1);
    EXPECT_NEAR(sample.share, 0.1, 1e-12);
    EXPECT_NEAR(sample.seconds, 9, 1e-9);
}

TEST(TimeSample, OfCoverageAloneIsALeastTime) {
    const TimeSample sample = *sample_time({0, 50}, 1, {}, [](const SlabTry&) {
        SlabTrial trial;
        trial.seconds = trial.processor_seconds = trial.processor_seconds_begun = 3;
        trial.share = 0;
        trial.blocks = -1;
        return trial;
    });
    EXPECT_EQ(sample.share, 0);
    EXPECT_GT(sample.places, 0);
    EXPECT_GE(sample.seconds, 3);
}

}  // namespace
}  // namespace openfab::pipeline
