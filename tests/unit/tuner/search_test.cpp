// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The search of `openfab fit` on functions whose solutions are known: equations, bounds, what is least or most, steps.

#include "tools/fit/search.h"

#include <gmock/gmock.h>

#include <cmath>

namespace openfab::fit {
namespace {

using ::testing::Le;

Wanted equal(double value, double within = 1e-4) {
    return {value, value, 0, within};
}

/// Searches for values of a function, and counts how often it was asked.
struct Asked {
    SearchResult result;
    int32_t times = 0;
};
Asked found(std::vector<double> start, const std::vector<Wanted>& wanted,
            const std::function<std::vector<double>(std::span<const double>)>& function,
            SearchOptions options = {}) {
    Asked out;
    const Values values = [&](std::span<const double> x) -> Result<std::vector<double>> {
        ++out.times;
        return function(x);
    };
    Result<SearchResult> result = search_unknowns(std::move(start), wanted, values, options);
    EXPECT_TRUE(result);
    if (result) out.result = std::move(*result);
    return out;
}

TEST(Search, AStraightLineTakesAStepOfNewtons) {
    const Asked asked =
        found({0.9}, {equal(0.3)}, [](auto x) { return std::vector<double>{2 * x[0]}; });
    EXPECT_TRUE(asked.result.reached);
    EXPECT_NEAR(asked.result.best.x[0], 0.15, 1e-5);
    EXPECT_THAT(asked.times, Le(8));
}

TEST(Search, TwoEquationsOfTwoUnknowns) {
    const Asked asked = found({0.2, 0.2}, {equal(1.5), equal(0.3)}, [](auto x) {
        return std::vector<double>{std::exp(x[0]) * x[1] + x[0], x[0] * x[1]};
    });
    EXPECT_TRUE(asked.result.reached);
    const std::vector<double>& x = asked.result.best.x;
    EXPECT_NEAR(std::exp(x[0]) * x[1] + x[0], 1.5, 1e-4);
    EXPECT_NEAR(x[0] * x[1], 0.3, 1e-4);
}

TEST(Search, OfManySolutionsItIsTheNearestToTheStart) {
    // On x + y = 1, from (0.2, 0.4): (0.4, 0.6).
    const Asked asked =
        found({0.2, 0.4}, {equal(1.0)}, [](auto x) { return std::vector<double>{x[0] + x[1]}; });
    EXPECT_TRUE(asked.result.reached);
    EXPECT_NEAR(asked.result.best.x[0], 0.4, 1e-3);
    EXPECT_NEAR(asked.result.best.x[1], 0.6, 1e-3);
}

TEST(Search, TheLeastUnderABound) {
    // The least x² + y² with x y >= 0.16: both 0.4.
    const Asked asked = found({0.9, 0.3}, {{{}, {}, -1, 1e-4}, {0.16, {}, 0, 1e-4}}, [](auto x) {
        return std::vector<double>{x[0] * x[0] + x[1] * x[1], x[0] * x[1]};
    });
    EXPECT_TRUE(asked.result.reached);
    EXPECT_NEAR(asked.result.best.x[0], 0.4, 5e-3);
    EXPECT_NEAR(asked.result.best.x[1], 0.4, 5e-3);
    EXPECT_NEAR(asked.result.best.values[0], 0.32, 5e-4);
}

TEST(Search, TheMostWithinTheBoundsOfUnknowns) {
    const Asked asked =
        found({0.5}, {{{}, {}, 1, 1e-4}}, [](auto x) { return std::vector<double>{3 * x[0]}; });
    EXPECT_NEAR(asked.result.best.values[0], 3, 1e-9);
}

TEST(Search, StepsHaveNoSlopes) {
    // 64 steps, one of which is what is wanted: slopes are zero or say nothing.
    const Asked asked = found({0.02}, {equal(21.0 / 64, 1e-3)}, [](auto x) {
        return std::vector<double>{std::floor(std::min(x[0] * 64, 63.0)) / 64};
    });
    EXPECT_TRUE(asked.result.reached);
    EXPECT_NEAR(asked.result.best.x[0], 21.5 / 64, 0.5 / 64);
}

TEST(Search, WhatCannotBeReachedIsComeNearTo) {
    const Asked asked = found({0.5}, {equal(2.0)}, [](auto x) {
        return std::vector<double>{1 - (x[0] - 0.3) * (x[0] - 0.3)};
    });
    EXPECT_FALSE(asked.result.reached);
    EXPECT_NEAR(asked.result.best.x[0], 0.3, 1e-3);
}

TEST(Search, MoreConditionsThanUnknowns) {
    // x = 0.4 and x = 0.4: both hold; with 0.6, neither does, and the best is between.
    const auto twice = [](auto x) { return std::vector<double>{x[0], x[0]}; };
    EXPECT_TRUE(found({0.9}, {equal(0.4), equal(0.4)}, twice).result.reached);
    const Asked torn = found({0.9}, {equal(0.4), equal(0.6)}, twice);
    EXPECT_FALSE(torn.result.reached);
    EXPECT_GE(torn.result.best.x[0], 0.4 - 1e-4);
    EXPECT_LE(torn.result.best.x[0], 0.6 + 1e-4);
}

TEST(Search, OtherStartsFindWhatTheFirstDoesNot) {
    // Flat but for a bump far from the start.
    const auto bump = [](auto x) {
        return std::vector<double>{std::max(0.0, 1 - 8 * std::abs(x[0] - 0.8))};
    };
    const Asked asked = found({0.05}, {equal(0.9, 1e-2)}, bump, {.seed = 1});
    EXPECT_TRUE(asked.result.reached);
    const Asked again = found({0.05}, {equal(0.9, 1e-2)}, bump, {.seed = 1});
    EXPECT_EQ(asked.times, again.times);
    EXPECT_EQ(asked.result.best.x, again.result.best.x);
}

TEST(Search, AnInterruptKeepsTheBest) {
    std::atomic<bool> interrupt{false};
    int32_t times = 0;
    const Asked asked = found({0.5}, {equal(2.0)},
                              [&](auto x) {
                                  interrupt = ++times >= 5;
                                  return std::vector<double>{x[0]};
                              },
                              {.interrupt = &interrupt});
    EXPECT_TRUE(asked.result.interrupted);
    EXPECT_EQ(asked.times, 5);
    EXPECT_FALSE(asked.result.best.x.empty());
}

TEST(Search, AnInterruptOfWhatMakesTheValuesEndsItToo) {
    for (const int32_t after : {0, 3}) {
        int32_t times = 0;
        const Values values = [&](std::span<const double> x) -> Result<std::vector<double>> {
            if (times++ >= after) return Error{ErrorCode::kInterrupted, "", "", {}};
            return std::vector<double>{x[0]};
        };
        const std::vector<Wanted> wanted{equal(2.0)};
        const Result<SearchResult> result = search_unknowns({0.5}, wanted, values, {});
        ASSERT_TRUE(result);
        EXPECT_TRUE(result->interrupted);
        EXPECT_FALSE(result->reached);
        EXPECT_EQ(result->best.x.empty(), after == 0);
        EXPECT_EQ(times, after + 1);
    }
}

TEST(Search, AnErrorEndsIt) {
    const Values values = [](std::span<const double>) -> Result<std::vector<double>> {
        return user_error("no such voxel");
    };
    const std::vector<Wanted> wanted{equal(1)};
    const Result<SearchResult> result = search_unknowns({0.5}, wanted, values, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "no such voxel");
}

}  // namespace
}  // namespace openfab::fit
