// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NRRD in every order of axes: the same texels must come out in the same place, wherever the file has its
// channels, and whichever way its axes run.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using NrrdTest = FieldTest;

/// Sizes along x, y and z, and a value for each place and channel.
constexpr std::array<int, 3> kSize{4, 3, 2};
float value_at(const std::array<int, 3>& at, int channel) {
    return static_cast<float>(100 * at[2] + 10 * at[1] + at[0]) +
           0.25F * static_cast<float>(channel);
}

/// An order of axes: axis i of the file runs along `axes[i]`, down where `mirrored[i]`.
struct Order {
    std::array<int, 3> axes{0, 1, 2};
    std::array<bool, 3> mirrored{};
};

/// Writes texels of 0.5 x 1 x 2 mm, the lowest corner at (10, 20, 30), with the channels as axis
/// `channel_axis` of the file.
std::string nrrd(const Order& order, int channels, int channel_axis, const std::string& more = {},
                 bool with_directions = true) {
    constexpr std::array<double, 3> kStep{0.5, 1, 2}, kLow{10, 20, 30};
    std::array<double, 3> first{};
    std::string sizes, directions;
    std::array<int, 4> count{};
    for (int a = 0, axis = 0; a < 4; ++a) {
        if (a == channel_axis) {
            count[static_cast<size_t>(a)] = channels;
            if (channels > 0) sizes += fmt::format(" {}", channels);
            if (channels > 0) directions += " none";
            continue;
        }
        const auto i = static_cast<size_t>(axis++);
        const auto along = static_cast<size_t>(order.axes[i]);
        count[static_cast<size_t>(a)] = kSize[along];
        std::array<double, 3> step{};
        step[along] = order.mirrored[i] ? -kStep[along] : kStep[along];
        first[along] = kLow[along] + kStep[along] * (order.mirrored[i] ? kSize[along] - 0.5 : 0.5);
        sizes += fmt::format(" {}", kSize[along]);
        directions += fmt::format(" ({},{},{})", step[0], step[1], step[2]);
    }
    std::string data;
    std::array<int, 4> at{};
    const std::array<int, 4> n{count[0], count[1], count[2], std::max(count[3], 1)};
    for (at[3] = 0; at[3] < n[3]; ++at[3]) {
        for (at[2] = 0; at[2] < std::max(n[2], 1); ++at[2]) {
            for (at[1] = 0; at[1] < std::max(n[1], 1); ++at[1]) {
                for (at[0] = 0; at[0] < std::max(n[0], 1); ++at[0]) {
                    std::array<int, 3> place{};
                    for (int a = 0, axis = 0; a < 4; ++a) {
                        if (a == channel_axis) continue;
                        const auto i = static_cast<size_t>(axis++);
                        const auto along = static_cast<size_t>(order.axes[i]);
                        const int index = at[static_cast<size_t>(a)];
                        place[along] = order.mirrored[i] ? kSize[along] - 1 - index : index;
                    }
                    const float value =
                        value_at(place, channels > 0 ? at[static_cast<size_t>(channel_axis)] : 0);
                    data.append(reinterpret_cast<const char*>(&value), sizeof value);
                }
            }
        }
    }
    std::string header = "NRRD0005\ntype: float\n" +
                         fmt::format("dimension: {}\n", channels > 0 ? 4 : 3) + "sizes:" + sizes +
                         "\n" + more + "endian: little\nencoding: raw\n";
    if (with_directions)
        header += "space directions:" + directions +
                  fmt::format("\nspace origin: ({},{},{})\n", first[0], first[1], first[2]);
    return header + "\n" + data;
}

std::vector<float> expected(int channels) {
    std::vector<float> out;
    for (int z = 0; z < kSize[2]; ++z) {
        for (int y = 0; y < kSize[1]; ++y) {
            for (int x = 0; x < kSize[0]; ++x) {
                for (int c = 0; c < channels; ++c)
                    out.push_back(value_at({x, y, z}, c));
            }
        }
    }
    return out;
}

TEST_F(NrrdTest, MirroredAndExchangedAxesArePutInOrderWithChannelsAnywhere) {
    std::array<int, 3> axes{0, 1, 2};
    do {
        for (unsigned mirrored = 0; mirrored < 8; ++mirrored) {
            const Order order{axes,
                              {(mirrored & 1) != 0, (mirrored & 2) != 0, (mirrored & 4) != 0}};
            for (const auto& [channels, axis] :
                 std::vector<std::pair<int, int>>{{0, 3}, {1, 3}, {2, 0}, {3, 1}, {2, 2}, {4, 3}}) {
                SCOPED_TRACE(fmt::format("axes {} {} {}, mirrored {}, {} channels at {}", axes[0],
                                         axes[1], axes[2], mirrored, channels, axis));
                const auto p = converted(folder_.write("a.nrrd", nrrd(order, channels, axis)));
                ASSERT_NE(p, nullptr);
                const Vec3i size = this->size(*p);
                ASSERT_EQ(size, (Vec3i{4, 3, 2}));
                EXPECT_EQ(level0(*p), expected(std::max(channels, 1)));
                EXPECT_EQ(domain(*p), (std::vector<float>{10, 20, 30, 2, 3, 4}));
            }
        }
    } while (std::next_permutation(axes.begin(), axes.end()));
}

TEST_F(NrrdTest, ChannelsAreFoundWithoutDirections) {
    for (const auto& [more, axis] : std::vector<std::pair<std::string, int>>{
             {"kinds: domain domain domain vector\n", 3},
             {"kinds: RGB-color space space space\n", 0},
             {"kinds: domain list domain domain\n", 1},
             {"spacings: 0.5 1 2 nan\n", 3},
             {"kinds: ??? domain domain domain\nspacings: NaN 0.5 1 2\n", 0},
             {"", 0}}) {
        const auto p = converted(folder_.write("a.nrrd", nrrd({}, 3, axis, more, false)));
        ASSERT_NE(p, nullptr) << more;
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 2})) << more;
        EXPECT_EQ(level0(*p), expected(3)) << more;
    }
    // More than four channels are not possible: the last of five, three and two is of two.
    const auto p = converted(folder_.write("l.nrrd",
                                           "NRRD0001\ntype: float\ndimension: 4\nsizes: 5 1 1 "
                                           "2\nencoding: text\n\n0 1 2 3 4 5 6 7 8 9\n"));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(level0(*p), (std::vector<float>{0, 5, 1, 6, 2, 7, 3, 8, 4, 9}));
}

TEST_F(NrrdTest, TurnedAxesAreSampledInPlace) {
    // x + 10 y at the places of the texels, whose axes are turned by 45 degrees about z.
    const double s = std::sqrt(0.5);
    std::string data;
    constexpr int kSide = 9;
    for (int k = 0; k < kSide; ++k) {
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                const double x = s * (i - j), y = s * (i + j);
                data += fmt::format("{} ", x + 10 * y);
            }
        }
    }
    const auto p = converted(folder_.write(
        "t.nrrd",
        fmt::format("NRRD0004\ntype: double\ndimension: 3\nsizes: 9 9 9\nspace: scanner-xyz\n"
                    "space directions: ({0},{0},0) (-{0},{0},0) (0,0,1)\n"
                    "space origin: (0,0,0)\nencoding: text\n\n",
                    s) +
            data));
    ASSERT_NE(p, nullptr);
    const Vec3i n = size(*p);
    const std::vector<float> values = level0(*p), box = domain(*p);
    int inside = 0;
    for (int y = 0; y < n.y; ++y) {
        for (int x = 0; x < n.x; ++x) {
            const double px = static_cast<double>(box[0]) + x + 0.5,
                         py = static_cast<double>(box[1]) + y + 0.5;
            const double i = s * (px + py), j = s * (py - px);
            if (i < 0 || j < 0 || i > kSide - 1 || j > kSide - 1) continue;
            ++inside;
            EXPECT_NEAR(values[static_cast<size_t>(y * n.x + x)], px + 10 * py, 1e-4);
        }
    }
    EXPECT_GT(inside, 40);
}

TEST_F(NrrdTest, UnitsAreMillimetres) {
    const std::string head =
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nspace directions: (1,0,0) (0,2,0) "
        "(0,0,3)\n"
        "space origin: (0.5,1,1.5)\nencoding: text\n";
    const auto extent = [&](const std::string& units, const VolumeOptions& options = {}) {
        const auto p = converted(folder_.write("u.nrrd", head + units + "\n1\n"), options);
        return p == nullptr ? std::vector<float>{} : domain(*p);
    };
    const std::vector<float> cm{0, 0, 0, 10, 20, 30};
    EXPECT_EQ(extent("space units: \"mm\" \"mm\" \"mm\"\n"),
              (std::vector<float>{0, 0, 0, 1, 2, 3}));
    EXPECT_EQ(extent("space units: \"cm\" \"cm\" \"cm\"\n"), cm);
    VolumeOptions options;
    options.unit = "cm";
    EXPECT_EQ(extent("", options), cm);
    EXPECT_EQ(trouble(folder_.write("u.nrrd", head + "space units: \"au\" \"au\" \"au\"\n\n1\n")),
              fmt::format(messages::kUnknownUnit, "au") + "; " + messages::kUnknownUnitHelp);
}

TEST_F(NrrdTest, LeftHandedSpacesAreNotMirrored) {
    const auto text = [](const std::string& space) {
        return "NRRD0004\ntype: float\nsizes: 2 2 1\nencoding: text\nspace: " + space +
               "\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5,6,7)\n\n1 2 3 4\n";
    };
    for (const char* space : {"left-anterior-superior", "LAS"}) {
        const auto file = folder_.write("a.nrrd", text(space));
        ::testing::internal::CaptureStderr();
        const auto p = converted(file);
        EXPECT_EQ(::testing::internal::GetCapturedStderr(),
                  "note: " + fmt::format(messages::kTurnedToBack, "a.nrrd") + "\n");
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(level0(*p), (std::vector<float>{3, 4, 1, 2}));
        EXPECT_EQ(origin(*p), (Vec3d{4.5, -7.5, 6.5}));
    }
    EXPECT_EQ(
        trouble(folder_.write("a.nrrd", text("3D-left-handed"))),
        fmt::format(messages::kLeftHanded, "3d-left-handed") + "; " + messages::kLeftHandedHelp);
    const auto p = converted(folder_.write("a.nrrd", text("right-anterior-superior")));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(level0(*p), (std::vector<float>{1, 2, 3, 4}));
}

TEST_F(NrrdTest, AnAxisThatMayBeOfChannelsIsTold) {
    const auto file =
        folder_.write("a.nrrd", "NRRD0004\ntype: uint8\nsizes: 2 5 1 2\nencoding: raw\n\n" +
                                    std::string(20, '\1'));
    ::testing::internal::CaptureStderr();
    const auto p = converted(file);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(),
              "note: " + fmt::format(messages::kAxesUnknown, 2, 2) + "\n");
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{5, 1, 2}));
}

TEST_F(NrrdTest, WhatStandsBehindTheNumbersIsTold) {
    const std::string head = "NRRD0004\ntype: uint8\nsizes: 2 1 1\nencoding: raw\n\n";
    const auto file = folder_.write("a.nrrd", head + "\1\2\3\4\5");
    ::testing::internal::CaptureStderr();
    ASSERT_NE(converted(file), nullptr);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(),
              "note: " + fmt::format(messages::kBytesBehind, 3) + "\n");
}

TEST_F(NrrdTest, SaysWhatIsWrong) {
    const auto with = [&](const std::string& fields) {
        return trouble(folder_.write(
            "w.nrrd", "NRRD0004\ntype: float\n" + fields + "encoding: text\n\n1 2 3 4 5 6 7 8\n"));
    };
    EXPECT_EQ(with("sizes: 2 2\n"), fmt::format(messages::kNrrdDimensions, 2));
    EXPECT_EQ(with("sizes: 2 2 2\nkinds: vector domain domain\n"),
              fmt::format(messages::kAxesInSpace, 2, 3));
    EXPECT_EQ(with("sizes: 1 2 2 2\nkinds: domain domain domain domain\n"),
              messages::kFourAxesInSpace);
    EXPECT_EQ(with("sizes: 1 2 2 2\nkinds: vector list domain domain\n"),
              fmt::format(messages::kAxesInSpace, 2, 4));
    EXPECT_EQ(with("sizes: 2 2 1 2\nkinds: domain domain domain time\n"),
              fmt::format(messages::kStepsOfTime, 2));
    EXPECT_EQ(with("sizes: 2 2 2\nspace directions: (1,0,0) (0,1,0)\n"),
              fmt::format(messages::kEntriesForAxes, "space directions", 2, 3));
    EXPECT_EQ(with("sizes: 2 2 2\nspace directions: (1,0) (0,1) (0,1)\n"),
              messages::kSpaceDirectionsMalformed);
    EXPECT_EQ(with("sizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n"),
              messages::kAxesInAPlane);
    EXPECT_THAT(with("sizes: 2 2 2\ndata file: a%d.raw 1 3\n"),
                testing::Says(texture::messages::kDataFilesMalformed, "a%d.raw 1 3"));
}

}  // namespace
}  // namespace openfab::tools
