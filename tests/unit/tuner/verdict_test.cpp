// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Verdicts on seconds that are made here, whose true ratio is known: what wins by noise alone, and
// what a real gain is worth under it.

#include "tools/tuner/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace openfab::tuner {
namespace {

/// Runs at places that take 1, 2, … seconds, with noise of that relative deviation; `ratios`: the
/// contender's at each place.
std::vector<std::vector<Triple>> runs_of(int count, const std::vector<double>& ratios, double noise,
                                         std::mt19937* random) {
    std::normal_distribution<double> normal(0, noise);
    const auto seconds = [&](size_t place) {
        return static_cast<double>(place + 1) * std::exp(normal(*random));
    };
    std::vector<std::vector<Triple>> runs(static_cast<size_t>(count));
    for (std::vector<Triple>& run : runs) {
        for (size_t p = 0; p < ratios.size(); ++p)
            run.push_back({seconds(p), ratios[p] * seconds(p), seconds(p)});
    }
    return runs;
}

TEST(Verdict, NoiseAloneWinsAtMostOnceInAHundred) {
    std::mt19937 random(1);
    for (const int count : {4, 7, 25}) {
        for (const double noise : {0.02, 0.2}) {
            int won = 0, less = 0;
            constexpr int kTries = 4000;
            for (int n = 0; n < kTries; ++n) {
                const Verdict verdict = judge(runs_of(count, {1, 1, 1}, noise, &random));
                won += verdict.faster ? 1 : 0;
                less += verdict.ratio < 1 ? 1 : 0;
            }
            // The probability is 1 %; four deviations of its count above.
            EXPECT_LE(won, 40 + 4 * 6.3) << count << " runs, " << noise;
            EXPECT_NEAR(less, kTries / 2, 4 * 32) << count << " runs, " << noise;
        }
    }
}

TEST(Verdict, AGainBeyondNoiseWins) {
    std::mt19937 random(2);
    const Verdict verdict = judge(runs_of(7, {0.9, 0.95, 0.92}, 0.01, &random));
    EXPECT_TRUE(verdict.faster);
    // Places of 1, 2 and 3 seconds.
    EXPECT_NEAR(verdict.ratio, (0.9 + 2 * 0.95 + 3 * 0.92) / 6, 0.02);
    EXPECT_GT(verdict.bound, verdict.ratio);
    EXPECT_LT(verdict.bound, 0.96);
    EXPECT_NEAR(verdict.of_places.x, 0.9, 0.03);
    EXPECT_NEAR(verdict.of_places.y, 0.95, 0.03);
    EXPECT_EQ(verdict.runs, 7);
    EXPECT_EQ(verdict.places, 3);
}

TEST(Verdict, ABoundIsStudents) {
    // Logarithms of ratios -0.2, -0.1 and 0: mean -0.1, deviation 0.1, two degrees of freedom.
    std::vector<std::vector<Triple>> runs;
    for (const double log_ratio : {-0.2, -0.1, 0.0})
        runs.push_back({{1, std::exp(log_ratio), 1}});
    const Verdict verdict = judge(runs);
    EXPECT_NEAR(verdict.ratio, std::exp(-0.1), 1e-12);
    EXPECT_NEAR(verdict.bound, std::exp(-0.1 + 6.965 * 0.1 / std::sqrt(3.0)), 1e-12);
    EXPECT_FALSE(verdict.faster);
    EXPECT_FALSE(verdict.wins(false));
    EXPECT_TRUE(verdict.wins(true)) << "it has won before, and nothing says otherwise";
    runs[2][0].contender = 1.4;
    EXPECT_FALSE(judge(runs).wins(true)) << "no gain any more";
}

TEST(Verdict, WhereTheFirstScheduleVariesAsMuchNothingIsWon) {
    std::vector<std::vector<Triple>> runs;
    for (int n = 0; n < 10; ++n) {
        const bool odd = n % 2 == 1;
        runs.push_back({{odd ? 0.5 : 2.0, 0.9, odd ? 2.0 : 0.5}});
    }
    const Verdict verdict = judge(runs);
    EXPECT_NEAR(verdict.ratio, 0.9, 1e-12) << "the same in each run";
    EXPECT_FALSE(verdict.faster);
}

TEST(Verdict, AGainAtOnePlaceAloneDoesNotWin) {
    std::mt19937 random(3);
    const Verdict verdict = judge(runs_of(25, {1.02, 1.02, 1.02, 0.7}, 0.002, &random));
    EXPECT_LT(verdict.bound, 0.95);
    EXPECT_FALSE(verdict.faster);
    EXPECT_FALSE(judge(runs_of(25, {0.995}, 0.0001, &random)).faster) << "too little to matter";
    EXPECT_FALSE(judge(runs_of(1, {0.5}, 0.01, &random)).faster) << "one run has no bound";
}

}  // namespace
}  // namespace openfab::tuner
