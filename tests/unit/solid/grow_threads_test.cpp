// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// A solid that grows has one cache, which all threads of a print share.

#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "tests/unit/solid/growing.h"

namespace openfab::solid {
namespace {

TEST(GrowThreads, CoverTheSameWhileEachTakesWhatOthersNeed) {
    const Made beams(bush, kernel<bush>, 0, all_of(bush));
    const std::vector<uint8_t> expected = beams.covered();
    for (const size_t cache : {kLittle, kMuch}) {
        const Made made(bush, kernel<bush>, cache, nullptr);
        std::array<std::vector<uint8_t>, 4> covered_by;
        {
            std::vector<std::jthread> threads;
            for (std::vector<uint8_t>& covered_voxels : covered_by)
                threads.emplace_back([&] { covered_voxels = covered(*made.placed, made.grid); });
        }
        for (const std::vector<uint8_t>& covered_voxels : covered_by)
            EXPECT_TRUE(covered_voxels == expected);
        EXPECT_TRUE(made.solid->status());
    }
}

}  // namespace
}  // namespace openfab::solid
