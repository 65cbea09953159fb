// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` of prints as volumes, of two as their difference, and what a print opens on.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/programs/viewer/view_fixtures.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr Rgba kStandsOut{0xd8, 0x1b, 0x60, 0xff};

/// A print of which every voxel is what `code` says.
template <typename Code>
SamplePrint make_print(Vec3i size, const Code& code) {
    SamplePrint print = make_sample(size);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x)
                print.at(x, y, z) = static_cast<uint8_t>(code(x, y, z));
        }
    }
    return print;
}

class ViewVolume : public PrintFixture {
  protected:
    /// The cells once all steps are done.
    static std::string whole_volume(const Viewer& viewer, const std::string& path, double steps) {
        std::string body;
        for (int32_t known = 0; known < steps;) {
            const HttpAnswer answer = viewer.get(path + fmt::format("&known={}", known));
            if (answer.status == 204) continue;
            EXPECT_EQ(answer.status, 200) << answer.body;
            if (answer.status != 200) break;
            known = std::stoi(answer.headers.at("x-openfab-step"));
            body = answer.body;
        }
        return body;
    }
};

TEST_F(ViewVolume, TheVolumeIsFilledAndEnds) {
    SamplePrint print = make_sample({40, 30, 20});
    for (int32_t z = 0; z < 20; ++z) {
        for (int32_t y = 0; y < 30; ++y) {
            for (int32_t x = 0; x < 40; ++x)
                print.at(x, y, z) = z < 10 ? (x < 20 ? 1 : 2) : 0;
        }
    }
    const Viewer viewer({write(print, "a.ofr")});
    const JsonValue state = viewer.get("/api/state").json();
    const JsonValue& volume = member(member(state, "prints").items.at(0), "volume");
    std::array<size_t, 3> cells{};
    for (size_t a = 0; a < 3; ++a)
        cells[a] = static_cast<size_t>(member(volume, "cells").items.at(a).number);
    EXPECT_EQ(cells, (std::array<size_t, 3>{40, 30, 20}));
    const std::string path = "/api/volume?generation=1&print=0&colors=" + std::string(kColorText);
    const double steps = member(volume, "steps").number;
    const std::string body = whole_volume(viewer, path, steps);
    EXPECT_EQ(viewer.get(path + fmt::format("&known={}", steps)).status, 204);
    ASSERT_EQ(body.size(), 40u * 30 * 20 * 4);
    for (const auto& [x, y, z, code] : {std::array{0, 0, 0, 1},
                                        {19, 29, 9, 1},
                                        {20, 0, 5, 2},
                                        {39, 29, 9, 2},
                                        {10, 10, 12, 0},
                                        {39, 29, 19, 0}}) {
        const size_t at =
            ((static_cast<size_t>(z) * 30 + static_cast<size_t>(y)) * 40 + static_cast<size_t>(x)) *
            4;
        EXPECT_EQ(static_cast<uint8_t>(body[at + 3]), kColors[static_cast<size_t>(code)][3]);
        for (size_t c = 0; c < 3 && code != 0; ++c) {
            EXPECT_NEAR(static_cast<uint8_t>(body[at + c]), kColors[static_cast<size_t>(code)][c],
                        2)
                << x << " " << y << " " << z;
        }
    }
}

TEST_F(ViewVolume, TheDifferenceShowsTheVoxelsThatDiffer) {
    SamplePrint other = print_;
    other.at(100, 5, 4) = static_cast<uint8_t>((print_.at(100, 5, 4) + 1) % 4);
    // The same materials by name, in another order: not a difference.
    std::swap(other.info.materials[0], other.info.materials[1]);
    for (uint8_t& code : other.codes)
        code = code == 1 ? 2 : code == 2 ? 1 : code;
    const Viewer viewer({write(print_, "a.ofr"), write(other, "b.ofr")});
    const std::string values = "/api/tile?generation=2&print=diff&lu=0&lv=0&u=0&v=0&colors=";
    for (const auto& [axis, x, y] : {std::tuple{"axis=z&at=4", 100, 5}, {"axis=y&at=5", 100, 4}}) {
        const ReadPng tile = picture(viewer.get(values + kColorText + "&" + axis));
        int marked = 0;
        for (int32_t v = 0; v < tile.height; ++v) {
            for (int32_t u = 0; u < tile.width; ++u)
                marked += tile.at(u, v)[3] == 255 ? 1 : 0;
        }
        EXPECT_EQ(marked, 1) << axis;
        EXPECT_EQ(tile.at(x, tile.height - 1 - y)[3], 255) << axis;
    }
    const JsonValue slice = viewer.get("/api/slice?generation=2&print=diff&z=4").json();
    EXPECT_EQ(member(slice, "different").number, 1);
    ASSERT_EQ(member(slice, "changes").items.size(), 1u);
    EXPECT_EQ(member(member(slice, "changes").items[0], "voxels").number, 1);
    EXPECT_EQ(member(member(slice, "changes").items[0], "first").number, print_.at(100, 5, 4));
    const JsonValue picked = viewer.get("/api/pick?generation=2&print=diff&x=100&y=5&z=4").json();
    EXPECT_EQ(member(picked, "code").number, print_.at(100, 5, 4));
    EXPECT_EQ(member(picked, "other").number, (print_.at(100, 5, 4) + 1) % 4);
}

TEST_F(ViewVolume, GridsOfOtherSizesAreNotCompared) {
    const Viewer viewer({write(print_, "a.ofr"), write(make_sample({10, 10, 10}), "b.ofr")});
    EXPECT_THAT(member(viewer.get("/api/state").json(), "difference").text,
                HasSubstr("517 x 23 x 37 and 10 x 10 x 10"));
    EXPECT_EQ(viewer.get("/api/slice?generation=2&print=diff&z=4").status, 422);
}

/// Also in parts of layers, of which a volume of one print reads a slice each.
TEST_F(ViewVolume, OfADifferenceNoVoxelIsMissed) {
    const Vec3i size{40, 30, 1600};
    const auto solid = [](int32_t x, int32_t, int32_t) { return x < 30 ? 1 : 0; };
    const SamplePrint first = make_print(size, solid);
    SamplePrint second = first;
    second.at(7, 11, 803) = 2;
    second.at(35, 2, 1200) = 3;
    const Viewer viewer({write(first, "a.ofr"), write(second, "b.ofr")});
    const JsonValue state = viewer.get("/api/state").json();
    const JsonValue& volume = member(member(state, "prints").items.at(0), "volume");
    std::array<size_t, 3> cells{};
    for (size_t a = 0; a < 3; ++a)
        cells[a] = static_cast<size_t>(member(volume, "cells").items.at(a).number);
    ASSERT_LT(cells[2] * 2, 1600u);
    const std::string body = whole_volume(
        viewer, "/api/volume?generation=2&print=diff&colors=" + std::string(kColorText),
        member(state, "difference_steps").number);
    ASSERT_EQ(body.size(), cells[0] * cells[1] * cells[2] * 4);
    std::vector<std::array<size_t, 3>> marked;
    for (size_t i = 0; i < body.size() / 4; ++i) {
        Rgba rgba{};
        for (size_t c = 0; c < 4; ++c)
            rgba[c] = static_cast<uint8_t>(body[i * 4 + c]);
        const std::array<size_t, 3> cell{i % cells[0], i / cells[0] % cells[1],
                                         i / cells[0] / cells[1]};
        // What is equal is a veil, and void is nothing.
        if (rgba[3] < 128) {
            EXPECT_EQ(rgba[3] > 0, cell[0] < cells[0] * 3 / 4);
            EXPECT_LT(rgba[3], 64);
        } else {
            marked.push_back(cell);
            for (size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(rgba[c], kStandsOut[c], 2);
        }
    }
    const auto cell_of = [&](size_t x, size_t y, size_t z) {
        return std::array<size_t, 3>{x * cells[0] / 40, y * cells[1] / 30, z * cells[2] / 1600};
    };
    EXPECT_THAT(marked, ::testing::ElementsAre(cell_of(7, 11, 803), cell_of(35, 2, 1200)));
}

TEST_F(ViewVolume, OfADifferenceWhatOnePrintAloneHasDiffersFromVoid) {
    const Vec3i size{40, 30, 20};
    SamplePrint first = make_print(size, [](int32_t, int32_t, int32_t) { return 1; });
    SamplePrint second = first;
    second.info.slice_end = 10;
    const Viewer viewer({write(first, "a.ofr"), write(second, "b.ofr")});
    const JsonValue state = viewer.get("/api/state").json();
    const std::string body = whole_volume(
        viewer, "/api/volume?generation=2&print=diff&colors=" + std::string(kColorText),
        member(state, "difference_steps").number);
    ASSERT_EQ(body.size(), 40u * 30 * 20 * 4);
    for (size_t z = 0; z < 20; ++z)
        EXPECT_EQ(static_cast<uint8_t>(body[z * 40 * 30 * 4 + 3]) == 255, z >= 10) << z;
}

TEST_F(ViewVolume, APrintOpensOnASliceThatShowsSomething) {
    const auto opening = [&](const SamplePrint& print) {
        const Viewer viewer({write(print, "a.ofr")});
        return member(viewer.get("/api/opening?generation=1&print=0").json(), "z").number;
    };
    const Vec3i size{200, 150, 160};
    // A blank sheet with a picture on top, and one with a picture below.
    const auto picture = [](int32_t x, int32_t y) { return 1 + (x / 20 + y / 20) % 3; };
    const auto sheet = [&](bool above) {
        return make_print(size, [&](int32_t x, int32_t y, int32_t z) {
            return (above ? z >= 140 : z < 20) ? picture(x, y) : 1;
        });
    };
    EXPECT_GE(opening(sheet(true)), 140);
    EXPECT_LT(opening(sheet(false)), 20);
    // All alike: the middle. Support is not what one wants to see.
    EXPECT_EQ(opening(make_print(size, [](int32_t, int32_t, int32_t) { return 2; })), 80);
    SamplePrint supported = make_print(size, [&](int32_t x, int32_t y, int32_t z) {
        return z < 100 ? (x / 20 % 2 == 0 ? 3 : 0) : z < 140 ? 1 : picture(x, y) == 1 ? 1 : 2;
    });
    supported.info.support_code = 3;
    EXPECT_GE(opening(supported), 140);
    // Nothing but void opens, too.
    EXPECT_EQ(opening(make_print(size, [](int32_t, int32_t, int32_t) { return 0; })), 80);
}

/// A cell of the volume that is partly solid stands for all of its voxels.
TEST_F(ViewVolume, TheSolidVoxelNearAPlaceIsPicked) {
    const SamplePrint print = make_print({40, 30, 20}, [](int32_t x, int32_t y, int32_t) {
        return x == 20 && y == 10 ? 2 : x > 30 ? 3 : 0;
    });
    const Viewer viewer({write(print, "a.ofr")});
    const auto pick = [&](const std::string& values) {
        return viewer.get("/api/pick?generation=1&print=0&" + values).json();
    };
    const auto voxel = [](const JsonValue& picked) {
        std::vector<double> made;
        for (const JsonValue& one : member(picked, "voxel").items)
            made.push_back(one.number);
        return made;
    };
    using ::testing::ElementsAre;
    EXPECT_THAT(voxel(pick("x=18&y=11&z=4&reach=3")), ElementsAre(20, 10, 4));
    EXPECT_EQ(member(pick("x=18&y=11&z=4&reach=3"), "code").number, 2);
    EXPECT_THAT(voxel(pick("x=18&y=11&z=4&reach=1")), ElementsAre(18, 11, 4));
    EXPECT_EQ(member(pick("x=18&y=11&z=4"), "code").number, 0);
    EXPECT_THAT(voxel(pick("x=39&y=29&z=19&reach=64")), ElementsAre(39, 29, 19));
    EXPECT_EQ(viewer.get("/api/pick?generation=1&print=0&x=1&y=1&z=1&reach=65").status, 400);
}

}  // namespace
}  // namespace openfab::testing
