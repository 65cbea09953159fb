// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/units.h"

#include <gtest/gtest.h>

#include "base/messages.h"
#include "tests/support/says/says.h"

namespace openfab {
namespace {

TEST(Units, AreRead) {
    EXPECT_EQ(*parse_length_mm("60mm"), 60);
    EXPECT_EQ(*parse_length_mm("2.5 cm"), 25);
    EXPECT_EQ(*parse_length_mm("1in"), 25.4);
    EXPECT_EQ(*parse_bytes("1.5GB"), 1'500'000'000);
    EXPECT_EQ(*parse_bytes("2KiB"), 2048);
    EXPECT_EQ(*parse_duration("2min"), 120);
}

TEST(Units, WhatToWriteIsShownInFull) {
    EXPECT_THAT(parse_length_mm("60").error().message,
                testing::Says(messages::kNoUnit, "60", "60mm"));
    EXPECT_THAT(parse_bytes("300 ").error().message,
                testing::Says(messages::kNoUnit, "300", "300MB"));
    EXPECT_THAT(parse_duration("10").error().message,
                testing::Says(messages::kNoUnit, "10", "10s"));
    EXPECT_THAT(parse_length_mm("6.5ft").error().message,
                testing::Says(messages::kWrongUnit, "6.5ft", "ft", "6.5mm", "um, cm, m, in"));
    EXPECT_THAT(parse_length_mm("wide").error().message,
                testing::Says(messages::kNotAQuantity, "wide", messages::kALength, "0.1mm"));
}

}  // namespace
}  // namespace openfab
