// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/overlaps.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/says/says.h"

#include <gmock/gmock.h>

namespace openfab::pipeline {
namespace {

part::Part part(const char* name, int32_t priority) {
    part::Part out;
    out.name = name;
    out.priority = priority;
    return out;
}

/// Parts in descending priority, ties in reverse build order, as in a slab; one block each.
Overlaps claim(const std::vector<part::Part>& parts, const std::vector<int32_t>& order,
               const std::vector<uint64_t>& voxels, std::vector<uint64_t>* owned) {
    RowClaims claims;
    Overlaps overlaps;
    claims.reset(4, 1, 3);
    owned->resize(parts.size());
    for (const int32_t p : order) {
        const auto i = static_cast<size_t>(p);
        claims.begin_part(parts[i], p);
        (*owned)[i] = claims.take(2, 5, voxels[i]);
        claims.end_block(2, {16, 8, 0}, &overlaps);
    }
    return overlaps;
}

TEST(Overlaps, AreOfEqualPriorityOnly) {
    const std::vector<part::Part> parts = {part("low", 0), part("low too", 0), part("high", 1)};
    std::vector<uint64_t> owned;
    // The high part has bits 0 to 3; the low ones share bits 2 to 5, of which two are explained.
    const Overlaps overlaps = claim(parts, {2, 1, 0}, {0b1111100, 0b0111100, 0b0001111}, &owned);
    EXPECT_EQ(owned[2], 0b0001111u);
    EXPECT_EQ(owned[1], 0b0110000u);
    EXPECT_EQ(owned[0], 0b1000000u);
    ASSERT_EQ(overlaps.counts().size(), 1u);
    const auto& [pair, count] = *overlaps.counts().begin();
    EXPECT_EQ(pair, (std::pair<int32_t, int32_t>{0, 1}));
    EXPECT_EQ(count.voxels, 2);
    EXPECT_EQ(count.block, (Vec3i{16, 8, 0}));
}

TEST(Overlaps, AreNoneWherePrioritiesDiffer) {
    const std::vector<part::Part> parts = {part("a", 5), part("b", 0)};
    std::vector<uint64_t> owned;
    EXPECT_TRUE(claim(parts, {0, 1}, {0xff, 0xff}, &owned).empty());
    EXPECT_EQ(owned[1], 0u);
}

TEST(Overlaps, AreToldLargestFirst) {
    std::vector<part::Part> parts;
    Overlaps overlaps;
    for (int32_t i = 0; i < 12; ++i) {
        parts.push_back(part("p", 0));
        if (i > 0) overlaps.add(i - 1, i, {1000 * i, {8 * i, 0, 0}});
    }
    overlaps.add(0, 1, {1'000'000, {0, 0, 0}});
    const part::Grid grid{{-10, 0, 0}, {0.1, 0.1, 0.1}, {100, 100, 100}};
    const std::vector<std::string> lines = overlaps.report(parts, grid);
    ASSERT_EQ(lines.size(), 9u);
    EXPECT_THAT(lines[0],
                testing::Says(messages::kPartsOverlap, "p", 0, "p", 1, 1001000, 1, -9.6, 0.4, 0.4));
    EXPECT_THAT(lines[1], testing::Says(messages::kPartsOverlap, "p", "*", "p", "*", 11000));
    EXPECT_EQ(lines[8], fmt::format(messages::kMorePairsOverlap, 3));
}

}  // namespace
}  // namespace openfab::pipeline
