// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Timers of a print's stages, and the trace that listens to them.

#include "base/stage_timer.h"

#include <gtest/gtest.h>

#include <thread>

#include "base/clock.h"

namespace openfab {
namespace {

// Sums are of another clock than the thread's own, which the system may slow down or hurry a little.
constexpr double kApart = 0.99;

/// Works for a while; returns what the thread's own clock says of it.
double work() {
    const double begin = thread_processor_seconds();
    uint32_t state = 1;
    for (int i = 0; i < 3'000'000; ++i)
        state = state * 1664525u + 1013904223u;
    EXPECT_NE(state, 1u);
    return thread_processor_seconds() - begin;
}

double seconds(const Trace::Thread& thread, Stage stage) {
    return thread.seconds[static_cast<size_t>(stage)];
}

TEST(StageTimer, AddsTheWholeTimeToItsSum) {
    double sum = 1, worked = 0;
    {
        const StageTimer timer(Stage::kSlab, &sum);
        worked = work();
    }
    EXPECT_GE(sum, 1 + kApart * worked);
}

TEST(Trace, KeepsWhatWasTimedInsideApart) {
    const Trace trace;
    double outer = 0, inner = 0, around = 0, inside = 0;
    const double begin = thread_processor_seconds();
    {
        const StageTimer slab(Stage::kSlab, &outer);
        around += work();
        {
            const StageTimer nearest(Stage::kNearest, &inner);
            inside += work();
        }
        around += work();
    }
    const double whole = thread_processor_seconds() - begin;
    ASSERT_EQ(trace.threads().size(), 1u);
    const Trace::Thread& thread = trace.threads().front();
    EXPECT_GE(seconds(thread, Stage::kSlab), around);
    EXPECT_GE(seconds(thread, Stage::kNearest), inside);
    // Nothing counts twice.
    EXPECT_LE(seconds(thread, Stage::kSlab) + seconds(thread, Stage::kNearest), whole);
    EXPECT_GE(outer, inner + kApart * around);
    ASSERT_EQ(thread.busy.size(), 1u);
    EXPECT_GE(thread.busy[0].second - thread.busy[0].first, kApart * (around + inside));
}

TEST(Trace, HasEachThreadApart) {
    const Trace trace;
    std::thread other([] {
        const StageTimer timer(Stage::kDither);
        work();
    });
    other.join();
    {
        const StageTimer timer(Stage::kPack);
        work();
    }
    ASSERT_EQ(trace.threads().size(), 2u);
    EXPECT_GT(seconds(trace.threads()[0], Stage::kDither), 0);
    EXPECT_EQ(seconds(trace.threads()[0], Stage::kPack), 0);
    EXPECT_GT(seconds(trace.threads()[1], Stage::kPack), 0);
}

TEST(Trace, KnowsNothingOfAnEarlierOne) {
    {
        const Trace first;
        const StageTimer timer(Stage::kSlab);
    }
    const Trace second;
    EXPECT_TRUE(second.threads().empty());
    { const StageTimer timer(Stage::kSlab); }
    EXPECT_EQ(second.threads().size(), 1u);
}

TEST(BusyThreads, AreCountedAtEachTime) {
    // Thread 1 works in [1, 4) and [4, 6), thread 2 in [2, 5), thread 3 in [9, 12).
    std::deque<Trace::Thread> threads(3);
    threads[0].busy = {{1, 4}, {4, 6}};
    threads[1].busy = {{2, 5}};
    threads[2].busy = {{9, 12}};
    EXPECT_EQ(seconds_by_busy_threads(threads, 0, 10), (std::vector<double>{4, 3, 3, 0}));
    EXPECT_EQ(seconds_by_busy_threads(threads, 3, 4), (std::vector<double>{0, 0, 1, 0}));
    EXPECT_EQ(seconds_by_busy_threads(threads, 6, 9), (std::vector<double>{3, 0, 0, 0}));
    EXPECT_EQ(seconds_by_busy_threads({}, 1, 3), (std::vector<double>{2}));
}

}  // namespace
}  // namespace openfab
