// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/memory_planner.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/says/says.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace openfab::pipeline {
namespace {

constexpr int64_t kMB = 1'000'000;

/// 4 MB a slab, 1 MB a row and a thread.
MemoryNeeds small_needs() {
    MemoryNeeds needs;
    needs.fixed = 50 * kMB;
    needs.per_slab = 4 * kMB;
    needs.per_row = kMB;
    needs.per_thread = kMB;
    return needs;
}

MemoryPlanner planner_of(int64_t bytes, int32_t threads, int64_t reserved = 0) {
    return MemoryPlanner({bytes, reserved}, threads);
}

TEST(MemoryPlanner, KeepsWithinTheBudget) {
    // One surface of a part alone, one that parts share, and none.
    for (const SurfaceCounts& counts :
         {SurfaceCounts{1, 1}, SurfaceCounts{1, 40}, SurfaceCounts{3, 3}, SurfaceCounts{}}) {
        for (const int32_t threads : {1, 2, 5, 64}) {
            for (int64_t budget = 60 * kMB; budget < 3000 * kMB; budget = budget * 5 / 4) {
                const MemoryPlanner planner = planner_of(budget, threads);
                const CacheBudgets caches = planner.caches(counts, 40 * kMB, 0);
                const Result<MemoryPlan> plan =
                    planner.plan(small_needs(), caches, counts, counts, 100, 0);
                if (!plan) continue;
                EXPECT_LE(plan->total_bytes, budget);
                EXPECT_GE(plan->slabs_in_flight, 1);
                EXPECT_LE(plan->slabs_in_flight, threads > 1 ? threads + 1 : 1);
            }
        }
    }
}

TEST(MemoryPlanner, ABudgetThatAnErrorNamesIsEnough) {
    for (const SurfaceCounts& counts : {SurfaceCounts{2, 2}, SurfaceCounts{}}) {
        for (const int32_t threads : {1, 4}) {
            const auto plan_of = [&](int64_t budget) {
                const MemoryPlanner planner = planner_of(budget, threads);
                return planner.plan(small_needs(), planner.caches(counts, 40 * kMB, 0), counts,
                                    counts, 100, 0);
            };
            const Result<MemoryPlan> refused = plan_of(20 * kMB);
            ASSERT_FALSE(refused);
            const std::string text = refused.error().text();
            EXPECT_THAT(text, testing::Says(messages::kPrintNeeds, "* MB"));
            const std::string needs = messages::kPrintNeeds;
            const size_t at = text.find(needs.substr(0, needs.find('{'))) + needs.find('{');
            const int64_t named = std::stoll(text.substr(at)) * kMB;
            EXPECT_TRUE(plan_of(named)) << text;
            EXPECT_FALSE(plan_of(named / 2)) << text;
        }
    }
}

TEST(MemoryPlanner, WhereNoLimitWasGivenAPrintGetsWhatItNeeds) {
    const MemoryPlanner planner({20 * kMB, 0, 500 * kMB}, 1);
    EXPECT_TRUE(planner.check(300 * kMB, 100 * kMB));
    EXPECT_FALSE(planner.check(500 * kMB, 100 * kMB));
    const SurfaceCounts counts{1, 1};
    const CacheBudgets caches = planner.caches(counts, 40 * kMB, 0);
    const Result<MemoryPlan> plan = planner.plan(small_needs(), caches, counts, counts, 100, 0);
    ASSERT_TRUE(plan) << plan.error().text();
    EXPECT_GT(plan->total_bytes, 20 * kMB);
    // Caches stay at their least: what is beyond the default is for what the print needs.
    EXPECT_LE(plan->total_bytes, 120 * kMB);
    // Where the default is enough, nothing differs.
    const Result<MemoryPlan> usual =
        planner_of(400 * kMB, 2)
            .plan(small_needs(), planner_of(400 * kMB, 2).caches(counts, 40 * kMB, 0), counts,
                  counts, 100, 0);
    const MemoryPlanner wide({400 * kMB, 0, 4000 * kMB}, 2);
    const Result<MemoryPlan> same =
        wide.plan(small_needs(), wide.caches(counts, 40 * kMB, 0), counts, counts, 100, 0);
    ASSERT_TRUE(usual && same);
    EXPECT_EQ(usual->total_bytes, same->total_bytes);
}

TEST(MemoryPlanner, ReservedBytesCountInWhatPeopleAreTold) {
    const Result<MemoryPlan> refused =
        planner_of(20 * kMB, 1, 100 * kMB).plan(small_needs(), {}, {}, {}, 1, 0);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), testing::Says(messages::kBudgetTooSmall, "120 MB"));
    EXPECT_THAT(refused.error().text(), testing::Says(messages::kBudgetTooSmall));
}

TEST(MemoryPlanner, SlabsInFlightFollowMemoryThreadsAndSlabs) {
    const auto in_flight = [](int64_t budget, int32_t slabs, int32_t most) {
        return planner_of(budget, 4).plan(small_needs(), {}, {}, {}, slabs, most)->slabs_in_flight;
    };
    // 50 MB, 4 a thread, and 10 a slab with the 6 rows of it.
    EXPECT_EQ(in_flight(1000 * kMB, 100, 0), 5);
    EXPECT_EQ(in_flight(150 * kMB, 100, 0), 4);
    EXPECT_EQ(in_flight(1000 * kMB, 100, 7), 7);
    EXPECT_EQ(in_flight(1000 * kMB, 2, 0), 2);
    EXPECT_EQ(in_flight(84 * kMB, 100, 0), 3);
    EXPECT_EQ(in_flight(64 * kMB, 100, 0), 1);
}

TEST(MemoryPlanner, TreesTakeAShareOfWhatIsLeft) {
    const SurfaceCounts one{1, 1};
    const MemoryPlanner planner = planner_of(2000 * kMB, 2);
    const CacheBudgets caches = planner.caches(one, 40 * kMB, 0);
    const Result<MemoryPlan> plan = planner.plan(small_needs(), caches, one, one, 100, 0);
    ASSERT_TRUE(plan);
    EXPECT_GT(plan->caches.trees, caches.trees);
    // Without a surface that is diced there are none.
    EXPECT_EQ(planner.plan(small_needs(), caches, one, {}, 100, 0)->caches.trees, caches.trees);
}

TEST(MemoryPlanner, OnlyLargeAllocationsAreRefusedBeforehand) {
    const MemoryPlanner planner = planner_of(300 * kMB, 2);
    EXPECT_TRUE(planner.check(100 * kMB, 290 * kMB));
    EXPECT_FALSE(planner.check(250 * kMB, 100 * kMB));
    EXPECT_TRUE(planner.check(250 * kMB, 40 * kMB));
}

}  // namespace
}  // namespace openfab::pipeline
