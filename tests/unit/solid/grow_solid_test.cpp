// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What grows by a rule against the same rule run to its end into a list of beams: the same bits everywhere, however
// little is kept; and what a rule may not do.

#include "runtime/solid/grow/grow_solid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "runtime/solid/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/solid/growing.h"

namespace openfab::solid {
namespace {

TEST(GrowSolid, CoversWhatItsBeamsCover) {
    const auto beams = all_of(bush);
    ASSERT_GT(beams->beams.size(), 2000u);
    const std::vector<uint8_t> expected = Made(bush, kernel<bush>, 0, beams).covered();
    ASSERT_GT(std::ranges::count(expected, 1), 2000);
    const Box3d box{{-12, -12, -3}, {12, 12, 20}};
    for (const bool asked : {true, false}) {
        for (const size_t cache : {kLittle, kMuch}) {
            const Made made(bush, kernel<bush>, cache, nullptr, box, true, asked);
            EXPECT_TRUE(made.covered() == expected);
            EXPECT_TRUE(made.solid->status());
        }
    }
}

/// Its thin beams are compared with voxels one by one, where axes of voxels are the part's.
TEST(GrowSolid, CoversWhatItsBeamsCoverWhereItIsNotTurned) {
    const Box3d box{{-12, -12, -3}, {12, 12, 20}};
    const std::vector<uint8_t> expected =
        Made(bush, kernel<bush>, 0, all_of(bush), box, false).covered();
    ASSERT_GT(std::ranges::count(expected, 1), 2000);
    for (const bool asked : {true, false}) {
        for (const size_t cache : {kLittle, kMuch}) {
            const Made made(bush, kernel<bush>, cache, nullptr, box, false, asked);
            EXPECT_TRUE(made.covered() == expected);
        }
    }
}

/// Distances and attributes of blocks have the bits of those of all beams.
TEST(GrowSolid, BlocksHaveTheAnswersOfAllBeams) {
    const auto beams = all_of(bush);
    const Made all(bush, kernel<bush>, 0, beams);
    const std::vector<uint8_t> covered = all.covered();
    const Vec3i base = part::part_base_voxel(all.part, all.grid);
    for (const size_t cache : {kLittle, kMuch}) {
        const Made made(bush, kernel<bush>, cache, nullptr);
        int64_t compared = 0;
        for (int32_t z = 0; z + 8 <= all.grid.size.z; z += 8) {
            for (int32_t y = 0; y + 8 <= all.grid.size.y; y += 40) {
                for (int32_t x = 0; x + 8 <= all.grid.size.x; x += 16) {
                    nearest::BlockQuery query;
                    query.block = Vec3i{x, y, z} - base;
                    nearest::BlockAnswer expected, found;
                    all.placed->engine()->query(query, all.scratch->engine.get(), &expected);
                    made.placed->engine()->query(query, made.scratch->engine.get(), &found);
                    std::vector<float> heat(1024), steps(6 * 512);
                    std::vector<uint32_t> kind(1024);
                    for (const bool grown : {false, true}) {
                        float* values[] = {heat.data() + (grown ? 512 : 0)};
                        uint32_t* flat[] = {kind.data() + (grown ? 512 : 0)};
                        float* gradients[3];
                        for (size_t a = 0; a < 3; ++a)
                            gradients[a] = steps.data() + ((grown ? 3 : 0) + a) * 512;
                        const Made& of = grown ? made : all;
                        of.placed->read(grown ? found : expected, nullptr,
                                        {values, gradients, flat}, of.scratch.get());
                    }
                    for (size_t v = 0; v < 512; ++v) {
                        ASSERT_EQ(std::bit_cast<uint32_t>(found.distance2[v]),
                                  std::bit_cast<uint32_t>(expected.distance2[v]));
                        ASSERT_EQ(heat[512 + v], heat[v]);
                        ASSERT_EQ(kind[512 + v], kind[v]);
                        for (size_t a = 0; a < 3; ++a)
                            ASSERT_EQ(steps[(3 + a) * 512 + v], steps[a * 512 + v]);
                        ++compared;
                    }
                }
            }
        }
        EXPECT_GT(compared, 80000);
    }
}

TEST(GrowSolid, PointsHaveTheAnswersOfAllBeams) {
    const auto beams = all_of(bush);
    const Made all(bush, kernel<bush>, 0, beams), made(bush, kernel<bush>, kLittle, nullptr);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> at(-14, 14);
    std::vector<nearest::PointPacket> packets(60);
    for (nearest::PointPacket& packet : packets) {
        for (auto& axis : packet.p)
            for (float& x : axis)
                x = at(random);
    }
    std::vector<nearest::PointAnswer> expected(packets.size()), found(packets.size());
    all.placed->engine()->query_points(packets, kInfinity, all.scratch->engine.get(),
                                       expected.data());
    made.placed->engine()->query_points(packets, kInfinity, made.scratch->engine.get(),
                                        found.data());
    for (size_t g = 0; g < packets.size(); ++g) {
        EXPECT_EQ(all.placed->inside(packets[g], expected[g], {}, all.scratch.get()),
                  made.placed->inside(packets[g], found[g], {}, made.scratch.get()));
        std::array<std::array<float, 8>, 2> heat{};
        std::array<std::array<uint32_t, 8>, 2> kind{};
        for (const bool grown : {false, true}) {
            float* values[] = {heat[grown ? 1 : 0].data()};
            uint32_t* flat[] = {kind[grown ? 1 : 0].data()};
            nearest::PointTargets targets;
            targets.values = values;
            targets.flat = flat;
            const Made& of = grown ? made : all;
            of.placed->read_points(grown ? found[g] : expected[g], targets, of.scratch.get());
        }
        EXPECT_EQ(heat[0], heat[1]);
        EXPECT_EQ(kind[0], kind[1]);
        for (size_t l = 0; l < 8; ++l) {
            EXPECT_EQ(found[g].distance2[l], expected[g].distance2[l]);
            EXPECT_EQ(found[g].in_patch.bary2[l], expected[g].in_patch.bary2[l]);
        }
    }
}

TEST(GrowSolid, TopsAreCovered) {
    const Made all(bush, kernel<bush>, 0, all_of(bush)), made(bush, kernel<bush>, kMuch, nullptr);
    const Columns columns{8, 8, 80, 60};
    TopRows expected{made.grid.size.x, 8, std::vector<int32_t>(96 * 52, -1)}, found = expected;
    all.placed->raise_tops(columns, &expected);
    made.placed->raise_tops(columns, &found);
    EXPECT_EQ(found.top, expected.top);
    EXPECT_GT(*std::ranges::max_element(found.top), 0);
}

Node endless(const Node& parent, int32_t /*child*/, int32_t level, uint32_t path) {
    Node n = bush(parent, 0, std::min(level, 3), path);
    n.end[3] = n.end[0];
    n.end[4] = n.end[1];
    n.end[5] = n.end[2] + 0.01f * std::pow(0.9f, static_cast<float>(level));
    n.radius[0] = n.radius[1] = 0.1f;
    n.children = 1;
    n.reach = 1;
    return n;
}
Node leaves(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    n.reach *= 0.2f;
    return n;
}
Node lost(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    if (level == 3) n.end[4] = std::nanf("");
    return n;
}
Node crowd(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    n.children = level == 2 ? 1 << 20 : n.children;
    return n;
}
/// Nodes without beams, each kStep tenths of a mm long and at the end of its parent, without an end.
template <int kStep>
Node drifting(const Node& parent, int32_t /*child*/, int32_t level, uint32_t /*path*/) {
    Node n;
    n.end[0] = level == 0 ? 0 : parent.end[3];
    n.end[3] = n.end[0] + 0.1f * kStep;
    n.children = 1;
    n.reach = 6;
    return n;
}

/// A dense rule: all its nodes lie in one voxel, of which there are 4^20.
Node dust(const Node& /*parent*/, int32_t /*child*/, int32_t level, uint32_t path) {
    Node n;
    for (int e = 0; e < 2; ++e) {
        for (int a = 0; a < 3; ++a)
            n.end[3 * e + a] = 0.01f * chance(path, static_cast<uint32_t>(3 * e + a));
    }
    n.radius[0] = n.radius[1] = 1e-4f;
    n.children = level == 20 ? 0 : 4;
    n.reach = 0.1f;
    return n;
}

/// Grows all of a rule; of what is not asked for distances, nothing small is kept.
Result<void> outcome_of(openfab_kernel_fn fn, bool asked) {
    const Made made(nullptr, fn, 8 << 20, nullptr, {{-12, -12, -3}, {12, 12, 20}}, true, asked);
    if (made.placed == nullptr) return made.status;
    made.covered();
    return made.solid->status();
}

TEST(GrowSolid, SaysWhatIsWrongAndWhere) {
    const std::pair<openfab_kernel_fn, ::testing::Matcher<std::string>> kWrong[] = {
        {kernel<endless>, testing::Says(messages::kChildrenTooDeep, 1000)},
        {kernel<leaves>, testing::Says(messages::kBeamOutside)},
        {kernel<lost>, testing::Says(messages::kNotFinite)},
        {kernel<crowd>, testing::Says(messages::kTooManyChildren, 1048576, 65536)},
        {kernel<dust>, testing::Says(messages::kTooManyBeamsAtOnce, 524288)},
    };
    for (const bool asked : {true, false}) {
        for (const auto& [fn, what] : kWrong) {
            const Result<void> status = outcome_of(fn, asked);
            ASSERT_FALSE(status);
            EXPECT_THAT(status.error().message, what);
            EXPECT_EQ(exit_code(status.error().code), 1) << status.error().text();
        }
    }
    const Made small(bush, kernel<bush>, kMuch, nullptr, {{-1, -1, -1}, {1, 1, 1}});
    ASSERT_FALSE(small.status);
    EXPECT_EQ(small.status.error().location.line, 7);
    EXPECT_NE(small.status.error().help.find("box_mm"), std::string::npos);
}

/// A larger box is no remedy for a rule without an end, of which nothing is seen outside.
TEST(GrowSolid, ARuleOfNodesWithoutBeamsIsToldToEnd) {
    for (const bool asked : {true, false}) {
        const Result<void> soon = outcome_of(kernel<drifting<20>>, asked);
        ASSERT_FALSE(soon);
        EXPECT_THAT(soon.error().message, testing::Says(messages::kGrowsOutside));
        EXPECT_EQ(soon.error().help, messages::kEndOrEnlarge);
        const Result<void> late = outcome_of(kernel<drifting<4>>, asked);
        ASSERT_FALSE(late);
        EXPECT_THAT(late.error().message, testing::Says(messages::kChildrenOutside));
        EXPECT_EQ(late.error().help, messages::kLetChildrenEnd);
    }
}

}  // namespace
}  // namespace openfab::solid
