// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The stand-in for TBB that the thread sanitizer sees into does what our loops ask of TBB.

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <numeric>
#include <vector>

#include "tests/support/plain_threads/tbb/enumerable_thread_specific.h"
#include "tests/support/plain_threads/tbb/global_control.h"
#include "tests/support/plain_threads/tbb/parallel_for.h"
#include "tests/support/plain_threads/tbb/parallel_invoke.h"
#include "tests/support/plain_threads/tbb/parallel_pipeline.h"
#include "tests/support/plain_threads/tbb/parallel_reduce.h"

namespace {

TEST(PlainThreads, VisitEachIndexOnceAndInLoopsWithinLoops) {
    std::vector<std::atomic<int>> visits(1000);
    tbb::parallel_for(0, 10, [&](int tens) {
        tbb::parallel_for(100 * tens, 100 * (tens + 1),
                          [&](int i) { ++visits[static_cast<size_t>(i)]; });
    });
    tbb::parallel_for(3, 3, [&](int i) { ++visits[static_cast<size_t>(i)]; });
    for (const std::atomic<int>& visit : visits)
        EXPECT_EQ(visit, 1);
}

TEST(PlainThreads, DivideRangesIntoPartsOfAGrain) {
    for (const size_t count : {0, 1, 7, 64, 65, 100'000}) {
        std::vector<std::atomic<int>> visits(count);
        tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 7), [&](const auto& range) {
            EXPECT_TRUE(range.size() >= 7 || range.end() == count);
            for (size_t i = range.begin(); i < range.end(); ++i)
                ++visits[i];
        });
        for (const std::atomic<int>& visit : visits)
            EXPECT_EQ(visit, 1);
    }
}

TEST(PlainThreads, ReduceInOrder) {
    const auto listed = tbb::parallel_reduce(
        tbb::blocked_range<int>(0, 1000), std::vector<int>{},
        [](const auto& range, std::vector<int> list) {
            for (int i = range.begin(); i < range.end(); ++i)
                list.push_back(i);
            return list;
        },
        [](std::vector<int> a, const std::vector<int>& b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
    std::vector<int> expected(1000);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(listed, expected);
}

TEST(PlainThreads, APipelineEndsInOrderWithAtMostItsTokensOnTheirWay) {
    constexpr int kItems = 500, kTokens = 3;
    int next = 0;
    std::vector<int> ended;
    std::atomic<int> on_their_way{0}, most{0};
    const auto source = [&](tbb::flow_control& control) {
        if (next == kItems) {
            control.stop();
            return 0;
        }
        const int now = ++on_their_way;
        if (now > most) most = now;
        return next++;
    };
    const auto wrap = [](int i) { return std::make_unique<int>(2 * i); };
    const auto end = [&](const std::unique_ptr<int>& item) {
        ended.push_back(*item);
        --on_their_way;
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(
        kTokens,
        tbb::make_filter<void, int>(filter_mode::serial_in_order, source) &
            tbb::make_filter<int, std::unique_ptr<int>>(filter_mode::parallel, wrap) &
            tbb::make_filter<std::unique_ptr<int>, void>(filter_mode::serial_in_order, end));
    ASSERT_EQ(ended.size(), static_cast<size_t>(kItems));
    for (int i = 0; i < kItems; ++i)
        EXPECT_EQ(ended[static_cast<size_t>(i)], 2 * i);
    EXPECT_LE(most, kTokens);
}

TEST(PlainThreads, EachStageInOrderSeesAllItemsInTurn) {
    constexpr int kItems = 300;
    int next = 0;
    std::vector<int> gathered, ended;
    const auto source = [&](tbb::flow_control& control) {
        if (next == kItems) control.stop();
        return next++;
    };
    const auto halve = [](int i) { return 0.5 * i; };
    const auto gather = [&](double half) {
        gathered.push_back(static_cast<int>(2 * half));
        return std::make_unique<int>(gathered.back());
    };
    const auto add = [](const std::unique_ptr<int>& i) { return *i + 1; };
    using tbb::filter_mode;
    tbb::parallel_pipeline(
        4,
        tbb::make_filter<void, int>(filter_mode::serial_in_order, source) &
            tbb::make_filter<int, double>(filter_mode::parallel, halve) &
            tbb::make_filter<double, std::unique_ptr<int>>(filter_mode::serial_in_order, gather) &
            tbb::make_filter<std::unique_ptr<int>, int>(filter_mode::parallel, add) &
            tbb::make_filter<int, void>(filter_mode::serial_in_order,
                                        [&](int i) { ended.push_back(i); }));
    std::vector<int> expected(kItems);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(gathered, expected);
    std::iota(expected.begin(), expected.end(), 1);
    EXPECT_EQ(ended, expected);
}

// While the first item is at the end, others are made ready, as many as there are tokens.
TEST(PlainThreads, ItemsThatWaitForTheirTurnKeepNoThread) {
    constexpr int kItems = 20, kTokens = 6;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
    int next = 0, ended = 0;
    std::atomic<int> made{0};
    const auto source = [&](tbb::flow_control& control) {
        if (next == kItems) control.stop();
        return next++;
    };
    const auto make = [&](int i) {
        ++made;
        made.notify_all();
        return i;
    };
    const auto end = [&](int i) {
        for (int now; i == 0 && (now = made) < kTokens;)
            made.wait(now);
        EXPECT_EQ(i, ended++);
        EXPECT_LE(made, i + kTokens);
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(kTokens,
                           tbb::make_filter<void, int>(filter_mode::serial_in_order, source) &
                               tbb::make_filter<int, int>(filter_mode::parallel, make) &
                               tbb::make_filter<int, void>(filter_mode::serial_in_order, end));
    EXPECT_EQ(ended, kItems);
}

TEST(PlainThreads, OneThreadWhereOneIsAllowed) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    const std::thread::id self = std::this_thread::get_id();
    tbb::enumerable_thread_specific<int> calls([] { return 0; });
    const auto call = [&] {
        EXPECT_EQ(std::this_thread::get_id(), self);
        ++calls.local();
    };
    tbb::parallel_invoke(call, call, call);
    EXPECT_EQ(std::accumulate(calls.begin(), calls.end(), 0), 3);
}

}  // namespace
