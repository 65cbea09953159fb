// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/deadline.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace openfab {
namespace {

bool passes(const Deadline& deadline) {
    // Far longer than it takes; then the test fails.
    for (int i = 0; i < 6000 && !deadline.passed(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return deadline.passed();
}

TEST(Deadline, PassesOnceTheTimeIsOver) {
    const std::atomic<bool> interrupt{false};
    Deadline deadline(interrupt);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(deadline.passed());
    deadline.start(0.001);
    EXPECT_TRUE(passes(deadline));
}

TEST(Deadline, StartsAgain) {
    const std::atomic<bool> interrupt{false};
    Deadline deadline(interrupt);
    deadline.start(1e9);
    deadline.start(0.001);
    EXPECT_TRUE(passes(deadline));
}

TEST(Deadline, PassesAtAnInterrupt) {
    std::atomic<bool> interrupt{false};
    Deadline deadline(interrupt);
    deadline.start(1e9);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(deadline.passed());
    interrupt = true;
    EXPECT_TRUE(passes(deadline));
}

TEST(Deadline, EndsBeforeItPasses) {
    const std::atomic<bool> interrupt{false};
    Deadline(interrupt).start(1e9);
}

}  // namespace
}  // namespace openfab
