// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Timers of a print's stages, and the trace that listens to them.

#include "base/stage_timer.h"

#include <gtest/gtest.h>

#include <thread>

#include "base/clock.h"

namespace openfab {
namespace {

/// Works until the thread has used so much of a processor.
void work(double seconds) {
    const double end = thread_processor_seconds() + seconds;
    while (thread_processor_seconds() < end) {
    }
}

double seconds(const Trace::Thread& thread, Stage stage) {
    return thread.seconds[static_cast<size_t>(stage)];
}

TEST(StageTimer, AddsTheWholeTimeToItsSum) {
    double sum = 1;
    {
        const StageTimer timer(Stage::kSlab, &sum);
        work(0.01);
    }
    EXPECT_GE(sum, 1.01);
}

TEST(Trace, KeepsWhatWasTimedInsideApart) {
    const Trace trace;
    double outer = 0, inner = 0;
    const double begin = thread_processor_seconds();
    {
        const StageTimer slab(Stage::kSlab, &outer);
        work(0.02);
        {
            const StageTimer nearest(Stage::kNearest, &inner);
            work(0.05);
        }
        work(0.02);
    }
    const double whole = thread_processor_seconds() - begin;
    ASSERT_EQ(trace.threads().size(), 1u);
    const Trace::Thread& thread = trace.threads().front();
    EXPECT_GE(seconds(thread, Stage::kSlab), 0.04);
    EXPECT_GE(seconds(thread, Stage::kNearest), 0.05);
    // Nothing counts twice.
    EXPECT_LE(seconds(thread, Stage::kSlab) + seconds(thread, Stage::kNearest), whole);
    EXPECT_GE(outer, inner + 0.04);
    ASSERT_EQ(thread.busy.size(), 1u);
    EXPECT_GE(thread.busy[0].second - thread.busy[0].first, 0.09);
}

TEST(Trace, HasEachThreadApart) {
    const Trace trace;
    std::thread other([] {
        const StageTimer timer(Stage::kDither);
        work(0.01);
    });
    other.join();
    {
        const StageTimer timer(Stage::kPack);
        work(0.01);
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
