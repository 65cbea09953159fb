// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/time_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace openfab::pipeline {
namespace {

/// Samples where slab z takes seconds(z), and stops in trial number `last`, of which `share` is
/// done.
struct Sampled {
    TimeSample sample;
    std::vector<int32_t> tried;
};
template <typename Seconds>
Sampled sampled(const Vec2<int32_t>& slabs, const Seconds& seconds, size_t last = 100,
                double share = 1) {
    Sampled out;
    std::atomic<bool> stop{false};
    out.sample = *sample_time(slabs, stop, [&](int32_t slab) -> Result<SlabTrial> {
        out.tried.push_back(slab);
        stop = out.tried.size() > last;
        return SlabTrial{seconds(slab), stop ? share : 1, slab};
    });
    return out;
}

TEST(TimeSample, IsExactWhereTheTimeIsLinearInHeight) {
    const Sampled s = sampled({100, 800}, [](int32_t slab) { return slab * 0.01; });
    EXPECT_EQ(s.sample.places, 7);
    EXPECT_EQ(s.sample.share, 1);
    // From 1.00 to 7.99 s; what is tried is the upper neighbour of the middle of a seventh.
    EXPECT_NEAR(s.sample.seconds, 700 * 4.495, 700 * 0.016);
    EXPECT_EQ(s.tried[0], 450);
    EXPECT_EQ(s.tried[1], 451);
    const std::set<int32_t> once(s.tried.begin(), s.tried.end());
    EXPECT_EQ(once.size(), 14u);
    EXPECT_GE(*once.begin(), 100);
    EXPECT_LT(*once.rbegin(), 800);
}

TEST(TimeSample, OfLowPrintsTriesNoSlabBeyondThem) {
    for (int32_t count = 1; count < 20; ++count) {
        const Sampled s = sampled({5, 5 + count}, [](int32_t) { return 2.0; });
        EXPECT_GE(s.sample.places, 1);
        EXPECT_LE(s.sample.places, count);
        EXPECT_DOUBLE_EQ(s.sample.seconds, 2.0 * count);
        EXPECT_GE(*std::min_element(s.tried.begin(), s.tried.end()), 5);
        EXPECT_LT(*std::max_element(s.tried.begin(), s.tried.end()), 5 + count);
    }
}

TEST(TimeSample, CountsTheSecondOfTwoNeighbours) {
    int32_t before = -2;
    const Sampled s = sampled({0, 70}, [&](int32_t slab) {
        const double seconds = slab == before + 1 ? 1 : 100;  // what is near is cached
        before = slab;
        return seconds;
    });
    EXPECT_DOUBLE_EQ(s.sample.seconds, 70);
}

TEST(TimeSample, OfOneSlabThatWasStoppedIsMarkedSo) {
    const Sampled s = sampled(
        {0, 50}, [](int32_t) { return 9.0; }, 0, 0.1);
    EXPECT_EQ(s.tried, std::vector<int32_t>{25});
    EXPECT_EQ(s.sample.places, 1);
    EXPECT_EQ(s.sample.share, 0.1);
    EXPECT_DOUBLE_EQ(s.sample.seconds, 450);
}

TEST(TimeSample, BlocksOfAPlaceThatWasStoppedCountLikeThoseBefore) {
    // The third trial, the first at its place, would tell 1000 s from one per cent.
    const Sampled s = sampled(
        {0, 70}, [](int32_t slab) { return slab > 30 ? slab * 0.5 : 1000; }, 2, 0.01);
    ASSERT_EQ(s.tried, (std::vector<int32_t>{35, 36, 5}));
    EXPECT_EQ(s.sample.places, 2);
    EXPECT_EQ(s.sample.share, 1);
    EXPECT_DOUBLE_EQ(s.sample.seconds, 70 * (18 + 2.5) / 2);
}

TEST(TimeSample, AlsoIfMostOfItWasDone) {
    const Sampled s = sampled(
        {0, 70}, [](int32_t slab) { return slab > 30 ? slab * 0.5 : 1000; }, 2, 0.9);
    EXPECT_DOUBLE_EQ(s.sample.seconds, 70 * (18 + 2.5) / 2);
}

TEST(TimeSample, EndsAtOnce) {
    const std::atomic<bool> stop{true};
    const Result<TimeSample> sample =
        sample_time({0, 50}, stop, [](int32_t) { return SlabTrial{}; });
    EXPECT_EQ(sample->places, 0);
}

}  // namespace
}  // namespace openfab::pipeline
