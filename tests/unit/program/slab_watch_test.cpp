// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// When a slab that takes long is told of, and when it ends a print.

#include "program/slab_watch.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

namespace openfab::program {
namespace {

using Slab = pipeline::SlabClock::Slab;

TEST(SlabPatience, TellsAfterHalfAMinuteAndThenTwiceAsLong) {
    SlabPatience patience(std::nullopt);
    const Slab slab{8, 16, 100};
    std::vector<int> told;
    for (int second = 100; second <= 400; ++second) {
        if (patience.tells(slab, second)) told.push_back(second - 100);
    }
    EXPECT_EQ(told, (std::vector<int>{30, 60, 120, 240}));
    // Of the next one it tells anew; a late look tells once.
    const Slab next{16, 24, 400};
    EXPECT_FALSE(patience.tells(next, 429));
    EXPECT_TRUE(patience.tells(next, 500));
    EXPECT_FALSE(patience.tells(next, 519));
    EXPECT_TRUE(patience.tells(next, 520));
}

TEST(SlabPatience, IsOverAfterTheLimitAlone) {
    const Slab slab{8, 16, 100};
    EXPECT_FALSE(SlabPatience(std::nullopt).is_over(slab, 1e9));
    EXPECT_FALSE(SlabPatience(5.0).is_over(slab, 105));
    EXPECT_TRUE(SlabPatience(5.0).is_over(slab, 105.1));
}

TEST(SlabClock, TheOldestIsTheFirstThatStillRuns) {
    pipeline::SlabClock clock;
    EXPECT_FALSE(clock.oldest());
    auto first = std::make_unique<pipeline::SlabClock::Running>(&clock, 0, 8);
    const pipeline::SlabClock::Running second(&clock, 8, 16);
    EXPECT_EQ(clock.oldest()->first, 0);
    first.reset();
    EXPECT_EQ(clock.oldest()->first, 8);
    const pipeline::SlabClock::Running unwatched(nullptr, 0, 8);
}

}  // namespace
}  // namespace openfab::program
