// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/large_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace openfab {
namespace {

TEST(LargePages, HoldWhatIsPutIntoThem) {
    for (const size_t count : {size_t{0}, size_t{1}, size_t{3'000'001}}) {
        const std::vector<int32_t> filled = large_vector<int32_t>(count, -7);
        EXPECT_EQ(filled.size(), count);
        EXPECT_EQ(static_cast<size_t>(std::count(filled.begin(), filled.end(), -7)), count);
        EXPECT_EQ(large_vector<double>(count), std::vector<double>(count));
    }
}

TEST(LargePages, LeaveWhatIsThereAlone) {
    std::vector<std::array<int32_t, 3>> values{{1, 2, 3}, {4, 5, 6}};
    reserve_large(&values, 2'000'000);
    EXPECT_EQ(values, (std::vector<std::array<int32_t, 3>>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_GE(values.capacity(), 2'000'000u);
    const size_t capacity = values.capacity();
    reserve_large(&values, 10);
    EXPECT_EQ(values.capacity(), capacity);
}

}  // namespace
}  // namespace openfab
