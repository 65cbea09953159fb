// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The time of a printer that takes one slice after the other.

#include "tools/openfab/layer_clock.h"

#include <gtest/gtest.h>

#include <cmath>

namespace openfab::tools {
namespace {

TEST(LayerClock, WithoutALayerTimeEverySliceIsTakenAtOnce) {
    LayerClock clock(0, 20);
    clock.begin(3, 0);
    EXPECT_EQ(clock.room(), 3);
    for (int i = 0; i < 3; ++i)
        clock.add(i);
    EXPECT_TRUE(clock.finished());
}

TEST(LayerClock, PrintingStartsWhenTheBufferIsFull) {
    LayerClock clock(10, 2);
    clock.begin(5, 0);
    EXPECT_EQ(clock.room(), 2);
    clock.add(1);
    EXPECT_TRUE(std::isinf(clock.due()));
    clock.add(3);  // the first is printed from here on
    EXPECT_EQ(clock.room(), 3);
    EXPECT_DOUBLE_EQ(clock.due(), 13);
    clock.advance(12.9);
    EXPECT_EQ(clock.room(), 3);
    clock.advance(13);
    EXPECT_EQ(clock.room(), 4);
    EXPECT_EQ(clock.starved(), 0);
}

TEST(LayerClock, ALateSliceIsCountedWithItsTime) {
    LayerClock clock(10, 1);
    clock.begin(3, 0);
    clock.add(0);
    clock.advance(10);  // the second is due and not there
    EXPECT_EQ(clock.starved(), 1);
    clock.advance(20);
    EXPECT_EQ(clock.starved(), 1);
    clock.add(14);
    EXPECT_DOUBLE_EQ(clock.starved_seconds(), 4);
    EXPECT_DOUBLE_EQ(clock.due(), 24);
    clock.add(15);
    clock.advance(24);
    EXPECT_TRUE(clock.finished());
    EXPECT_EQ(clock.starved(), 1);
}

TEST(LayerClock, TheLastSlicesNeedNoFullBuffer) {
    LayerClock clock(10, 20);
    clock.begin(2, 0);
    clock.add(0);
    clock.add(1);
    clock.advance(11);
    EXPECT_TRUE(clock.finished());
}

TEST(LayerClock, WhatWasKeptBeforeIsPrinted) {
    LayerClock clock(10, 2);
    clock.begin(9, 9);
    EXPECT_TRUE(clock.finished());
}

}  // namespace
}  // namespace openfab::tools
