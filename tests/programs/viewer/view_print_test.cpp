// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` of prints: what the page is given is what the file holds, and nobody else is given
// anything.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "backends/ofr/ofr_sink.h"
#include "backends/raster/folder_sink.h"
#include "backends/read/messages.h"
#include "tests/programs/viewer/view_fixtures.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/viewer/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class ViewPrint : public PrintFixture {};

double linear(double srgb) {
    const double s = srgb / 255;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// The mean of codes in linear light, void left out, with the share that is not void as alpha.
std::array<double, 4> mean_color(const std::vector<uint8_t>& codes) {
    std::array<double, 4> sum{};
    for (const uint8_t code : codes) {
        if (code == 0) continue;
        for (size_t c = 0; c < 3; ++c)
            sum[c] += linear(kColors[code][c]);
        sum[3] += 1;
    }
    std::array<double, 4> mean{};
    for (size_t c = 0; c < 3 && sum[3] > 0; ++c) {
        const double x = sum[c] / sum[3];
        mean[c] = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
    }
    mean[3] = 255 * sum[3] / static_cast<double>(codes.size());
    return mean;
}

/// As the same print in an .ofr file; also while it is not complete, and after it was begun anew.
TEST_F(ViewPrint, AFolderOfSlicesIsShown) {
    const Viewer expected({write(print_, "a.ofr")});
    for (const auto format : {raster::SliceFormat::kRgba, raster::SliceFormat::kIndexed,
                              raster::SliceFormat::kBitmaps}) {
        raster::FolderOptions options;
        options.format = format;
        options.flip_x = format == raster::SliceFormat::kIndexed;
        const auto write_folder = [&](const SamplePrint& print, bool complete) {
            auto sink = raster::FolderSink::create(path("slices"), options);
            EXPECT_TRUE(sink && print.send(sink->get(), complete));
        };
        SamplePrint half = print_;
        write_folder(half, false);
        const Viewer viewer({path("slices")});
        const std::string tile = tile_path("axis=z&at=5&lu=0&lv=0&u=0&v=0");
        const HttpAnswer shown = viewer.get(tile), wanted = expected.get(tile);
        EXPECT_EQ(shown.status, wanted.status) << shown.body;
        EXPECT_TRUE(shown.body == wanted.body);
        const std::string pick = "/api/pick?generation=1&print=0&x=7&y=11&z=36";
        // All but the millimetres, which a manifest rounds.
        const auto what = [&](const Viewer& of) {
            const std::string body = of.get(pick).body;
            return body.substr(0, body.find(",\"mm\"")) + body.substr(body.find("\"around\""));
        };
        EXPECT_EQ(what(viewer), what(expected));
        write_folder(print_, true);
        viewer.wait_for(
            [](const JsonValue& state) { return state.find("generation")->value.number == 2; });
    }
}

TEST_F(ViewPrint, TheStateIsTheFilesOwn) {
    const Viewer viewer({write(print_, "a.ofr")});
    const JsonValue state = viewer.get("/api/state").json();
    EXPECT_EQ(state.find("live"), nullptr);
    const JsonValue& print = member(state, "prints").items.at(0);
    EXPECT_EQ(member(print, "title").text, "sample");
    EXPECT_EQ(member(print, "name").text, "a.ofr");
    for (size_t a = 0; a < 3; ++a)
        EXPECT_EQ(member(print, "size").items.at(a).number, kSize[static_cast<int>(a)]);
    EXPECT_TRUE(member(print, "complete").boolean);
    EXPECT_EQ(member(print, "whole").number, kSize.z);
    EXPECT_EQ(member(print, "hash").text, fmt::format("{:016x}", print_.totals().hash));
    const JsonValue& material = member(print, "materials").items.at(2);
    EXPECT_EQ(member(material, "name").text, "clear \"x\"");
    EXPECT_EQ(member(material, "preview").text, "#c8dcff80");
    EXPECT_EQ(member(material, "voxels").number,
              static_cast<double>(print_.totals().voxels_by_code.at(3)));
}

TEST_F(ViewPrint, ATileOfWholeVoxelsHasTheirColors) {
    for (const int32_t bits : {4, 8}) {
        const SamplePrint print = make_sample(kSize, bits);
        const Viewer viewer({write(print, "a.ofr")});
        for (const int32_t u : {0, 1}) {
            const ReadPng tile =
                picture(viewer.get(tile_path(fmt::format("axis=z&at=17&lu=0&lv=0&u={}&v=0", u))));
            ASSERT_EQ(tile.width, u == 0 ? 512 : 5);
            ASSERT_EQ(tile.height, kSize.y);
            for (int32_t y = 0; y < tile.height; ++y) {
                for (int32_t x = 0; x < tile.width; ++x) {
                    const uint8_t code = print.at(u * 512 + x, y, 17);
                    ASSERT_EQ(tile.at(x, tile.height - 1 - y), kColors[code]) << x << " " << y;
                }
            }
        }
    }
}

TEST_F(ViewPrint, APixelOfManyVoxelsIsTheirMeanInLinearLight) {
    for (const int32_t bits : {4, 8}) {
        const SamplePrint print = make_sample(kSize, bits);
        const Viewer viewer({write(print, "a.ofr")});
        for (const auto& [lu, lv] : {std::pair{1, 1}, {0, 2}, {2, 0}, {3, 1}, {6, 4}, {9, 5}}) {
            const ReadPng tile = picture(
                viewer.get(tile_path(fmt::format("axis=z&at=3&lu={}&lv={}&u=0&v=0", lu, lv))));
            const int32_t across = 1 << lu, up = 1 << lv;
            ASSERT_EQ(tile.width, std::min(512, (kSize.x + across - 1) / across));
            ASSERT_EQ(tile.height, (kSize.y + up - 1) / up);
            for (int32_t y = 0; y < tile.height; ++y) {
                for (int32_t x = 0; x < tile.width; ++x) {
                    std::vector<uint8_t> codes;
                    for (int32_t j = y * up; j < std::min((y + 1) * up, kSize.y); ++j) {
                        for (int32_t i = x * across; i < std::min((x + 1) * across, kSize.x); ++i)
                            codes.push_back(print.at(i, j, 3));
                    }
                    const std::array<double, 4> mean = mean_color(codes);
                    const Rgba& got = tile.at(x, tile.height - 1 - y);
                    // Fields of 10 bits: a dark channel is off by two of 255.
                    ASSERT_NEAR(got[3], mean[3], 1.5) << lu << lv << " " << x << " " << y;
                    for (size_t c = 0; c < 3 && mean[3] > 0; ++c)
                        ASSERT_NEAR(got[c], mean[c], 2.5) << lu << lv << " " << x << " " << y;
                }
            }
        }
    }
}

TEST_F(ViewPrint, ABrowserMayKeepATileForThisServerAlone) {
    const Viewer viewer({write(print_, "a.ofr")});
    const HttpAnswer tile = viewer.get(tile_path("axis=z&at=0&lu=0&lv=0&u=0&v=0"));
    EXPECT_THAT(tile.headers.at("cache-control"), HasSubstr("private"));
    EXPECT_EQ(tile.headers.at("vary"), "X-OpenFab-Token");
    EXPECT_EQ(viewer.get("/api/state").headers.at("cache-control"), "no-store");
}

TEST_F(ViewPrint, ACutHasARowOfEachSlice) {
    const Viewer viewer({write(print_, "a.ofr")});
    for (const int32_t coarse : {16, 4, 1}) {
        const ReadPng xz = picture(
            viewer.get(tile_path(fmt::format("axis=y&at=11&lu=0&lv=0&u=0&v=0&coarse={}", coarse))));
        const ReadPng yz = picture(viewer.get(
            tile_path(fmt::format("axis=x&at=400&lu=0&lv=0&u=0&v=0&coarse={}", coarse))));
        ASSERT_EQ(xz.height, (kSize.z + coarse - 1) / coarse);
        ASSERT_EQ(yz.height, xz.height);
        ASSERT_EQ(yz.width, kSize.y);
        for (int32_t row = 0; row < xz.height; ++row) {
            const int32_t top = xz.height - 1 - row;
            for (int32_t x = 0; x < 512; ++x)
                ASSERT_EQ(xz.at(x, top), kColors[print_.at(x, 11, row * coarse)]);
            for (int32_t y = 0; y < kSize.y; ++y)
                ASSERT_EQ(yz.at(y, top), kColors[print_.at(400, y, row * coarse)]);
        }
    }
}

TEST_F(ViewPrint, APickedVoxelIsNamedAndPlaced) {
    const Viewer viewer({write(print_, "a.ofr")});
    const JsonValue picked = viewer.get("/api/pick?generation=1&print=0&x=516&y=7&z=20").json();
    EXPECT_EQ(member(picked, "code").number, print_.at(516, 7, 20));
    const Vec3d& pitch = print_.info.pitch_mm;
    const std::vector<JsonValue>& mm = member(picked, "mm").items;
    EXPECT_NEAR(mm.at(0).number, -1.5 + 516.5 * pitch.x, 1e-9);
    EXPECT_NEAR(mm.at(1).number, 2.25 + 7.5 * pitch.y, 1e-9);
    EXPECT_NEAR(mm.at(2).number, 20.5 * pitch.z, 1e-9);
    EXPECT_EQ(picked.find("part"), nullptr);
    // Five voxels on each side along x, cut by the edge, and two along y.
    std::array<double, 4> shares{};
    for (int32_t y = 5; y <= 9; ++y) {
        for (int32_t x = 511; x <= 516; ++x)
            shares[print_.at(x, y, 20)] += 1.0 / 30;
    }
    for (const JsonValue& share : member(picked, "around").items) {
        const auto code = static_cast<size_t>(member(share, "code").number);
        EXPECT_NEAR(member(share, "share").number, shares.at(code), 1e-9);
    }
}

TEST_F(ViewPrint, ASlicesVoxelsAreCounted) {
    const Viewer viewer({write(print_, "a.ofr")});
    const JsonValue slice = viewer.get("/api/slice?generation=1&print=0&z=36").json();
    std::array<double, 4> counts{};
    for (int32_t y = 0; y < kSize.y; ++y) {
        for (int32_t x = 0; x < kSize.x; ++x)
            ++counts[print_.at(x, y, 36)];
    }
    for (size_t code = 0; code < counts.size(); ++code)
        EXPECT_EQ(member(slice, "voxels").items.at(code).number, counts[code]);
}

TEST_F(ViewPrint, AnUnfinishedPrintGrowsAndIsComplete) {
    const std::string whole = read_file(write(print_, "whole.ofr"));
    // In steps that end amid heads, frames and the index.
    const std::string file = path("growing.ofr");
    std::ofstream out(file, std::ios::binary);
    const size_t step = whole.size() / 9 + 1;
    out << whole.substr(0, step) << std::flush;
    const Viewer viewer({file});
    double last = -1;
    for (size_t at = step; at < whole.size(); at += step) {
        const JsonValue state = viewer.get("/api/state").json();
        const JsonValue& print = member(state, "prints").items.at(0);
        EXPECT_FALSE(member(print, "complete").boolean);
        EXPECT_TRUE(member(print, "solid").is(JsonValue::Kind::kNull));
        EXPECT_GT(member(print, "whole").number, last);
        last = member(print, "whole").number;
        const auto there = static_cast<int32_t>(last);
        const std::string slice = "/api/slice?generation=1&print=0&z=";
        EXPECT_EQ(viewer.get(slice + std::to_string(there - 1)).status, there > 0 ? 200 : 400);
        EXPECT_EQ(viewer.get(slice + std::to_string(there)).status, 422);
        // Of a cut, what is not there is void.
        const ReadPng cut = picture(viewer.get(tile_path("axis=y&at=2&lu=0&lv=0&u=0&v=0")));
        for (int32_t z = 0; z < kSize.z; ++z) {
            const uint8_t code = z < there ? print_.at(9, 2, z) : uint8_t{0};
            ASSERT_EQ(cut.at(9, cut.height - 1 - z), kColors[code]) << z << " of " << there;
        }
        out << whole.substr(at, step) << std::flush;
    }
    const JsonValue state = viewer.get("/api/state").json();
    EXPECT_TRUE(member(member(state, "prints").items.at(0), "complete").boolean);
    EXPECT_EQ(member(state, "generation").number, 1);
}

TEST_F(ViewPrint, AFileThatIsReplacedIsAnotherPrint) {
    const Viewer viewer({write(print_, "a.ofr")});
    EXPECT_EQ(member(viewer.get("/api/state").json(), "generation").number, 1);
    write(make_sample({9, 8, 7}), "b.ofr");
    std::filesystem::rename(path("b.ofr"), path("a.ofr"));
    const JsonValue state = viewer.get("/api/state").json();
    EXPECT_EQ(member(state, "generation").number, 2);
    EXPECT_EQ(member(member(state, "prints").items.at(0), "size").items.at(0).number, 9);
    EXPECT_EQ(viewer.get(tile_path("axis=z&at=0&lu=0&lv=0&u=0&v=0")).status, 409);
}

TEST_F(ViewPrint, ADamagedSliceIsNamedAndTheOthersAreShown) {
    const std::string file = write(print_, "a.ofr");
    std::string bytes = read_file(file);
    // The frame of some slice, amid the file.
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
    const Viewer viewer({file});
    int damaged = 0;
    for (int32_t z = 0; z < kSize.z; ++z) {
        const HttpAnswer answer =
            viewer.get(tile_path(fmt::format("axis=z&at={}&lu=0&lv=0&u=0&v=0", z)));
        if (answer.status == 200) continue;
        ++damaged;
        EXPECT_EQ(answer.status, 422);
        EXPECT_THAT(answer.body, testing::Says(prints::messages::kOfSlice, z, "its"));
        EXPECT_EQ(viewer.get(tile_path("axis=x&at=0&lu=0&lv=0&u=0&v=0")).status, 422);
    }
    EXPECT_EQ(damaged, 1);
}

}  // namespace
}  // namespace openfab::testing
