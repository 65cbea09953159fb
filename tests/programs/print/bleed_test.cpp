// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Bleed and grey pictures, as seen in the outputs. What bleed computes: tests/unit/process.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "backends/raster/png_encode.h"
#include "program/messages.h"
#include "runtime/process/bleed/messages.h"
#include "tests/programs/print/process_fixture.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class BleedOption : public ProcessOption {
  protected:
    BleedOption() {
        scratch_.write("bleed.json", R"({"bleed": {"sigma_um": [60, 50, 70],
            "pairs": [{"materials": ["white", "K"], "sigma_um": 80}]}})");
        scratch_.write("swell.json",
                       R"({"bleed": {"pairs": [{"materials": ["void", "*"], "sigma_um": 100}]}})");
    }
    /// Stripes of 0.3 mm of 30 % and of 70 %.
    void write_stripes() {
        scratch_.write("t.fl", "fablet Tint {}\n");
        std::string build;
        for (int i = 0; i < 16; ++i) {
            build += fmt::format(R"({}{{"object": "{}", "translate_mm": [{}, 0, 0]}})",
                                 i == 0 ? "" : ", ", i % 2 == 0 ? "s" : "t", 0.3 * i);
        }
        scratch_.write("stripes.fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json",
  "fablets": {{"t": {{"source": "t.fl", "fablet": "Tint"}}}},
  "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000", "channel": "K"}},
    "grey": {{"key": "#808080"}}}},
  "meshes": {{"bar": {{"box": [0.3, 4, 4]}}}},
  "objects": {{
    "s": {{"mesh": "bar", "fablet": "t", "uniforms": {{"a": "white", "b": "black"}}}},
    "t": {{"mesh": "bar", "fablet": "t", "uniforms": {{"a": "black", "b": "white"}}}}}},
  "build": [{}]
}})",
                                                       build));
    }
    static int64_t count(const Voxels& voxels, uint8_t code) {
        return std::count(voxels.codes.begin(), voxels.codes.end(), code);
    }
    std::vector<uint8_t> bytes(const std::filesystem::path& file) const {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
};

TEST_F(BleedOption, IsTheSameForAllWaysToPrint) {
    write_stripes();
    for (const std::string what : {"undo", "show", "both"}) {
        const std::vector<std::string> options{"--process", path("bleed.json"), "--bleed", what};
        const Voxels whole = print_voxels(options, "stripes.fab.json");
        for (const std::vector<std::string>& more :
             std::vector<std::vector<std::string>>{{"--threads", "1"},
                                                   {"--threads", "5", "--no-cull"},
                                                   {"--groups-in-flight", "3"}}) {
            std::vector<std::string> all = options;
            all.insert(all.end(), more.begin(), more.end());
            EXPECT_TRUE(print_voxels(all, "stripes.fab.json").codes == whole.codes)
                << what << " " << more.front();
        }
        std::vector<std::string> some = options;
        some.insert(some.end(), {"--slices", "13:30"});
        const Voxels part = print_voxels(some, "stripes.fab.json");
        const size_t slice = static_cast<size_t>(whole.info.size.x) * whole.info.size.y;
        ASSERT_EQ(part.codes.size(), 17 * slice);
        EXPECT_TRUE(std::equal(part.codes.begin(), part.codes.end(),
                               whole.codes.begin() + static_cast<std::ptrdiff_t>(13 * slice)))
            << what;
    }
}

TEST_F(BleedOption, SharesMergeAndInterruptedPrintsGoOn) {
    write_stripes();
    const std::string world = "stripes.fab.json";
    for (const std::string what : {"undo", "both"}) {
        const auto print_to = [&](const std::string& name, const std::vector<std::string>& more) {
            std::vector<std::string> all{"--process", path("bleed.json"), "--bleed", what,
                                         "-o",        path(name)};
            all.insert(all.end(), more.begin(), more.end());
            const Outcome outcome = print(all, world);
            ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        };
        print_to("whole.ofr", {});
        // The first share ends within a slab, whose neighbours both look at.
        print_to("low.ofr", {"--slices", "0:21"});
        print_to("high.ofr", {"--slices", fmt::format("21:{}", read("whole.ofr").info.size.z)});
        const Outcome merged = run({program("openfab"), "merge", path("high.ofr"), path("low.ofr"),
                                    "-o", path("merged.ofr")});
        ASSERT_EQ(merged.exit_code, 0) << merged.err;
        EXPECT_TRUE(bytes(path("merged.ofr")) == bytes(path("whole.ofr"))) << what;

        std::filesystem::copy_file(path("whole.ofr"), path("cut.ofr"));
        std::filesystem::resize_file(path("cut.ofr"),
                                     std::filesystem::file_size(path("cut.ofr")) / 2);
        print_to("cut.ofr", {"--resume"});
        EXPECT_TRUE(read("cut.ofr").codes == read("whole.ofr").codes) << what;
        std::filesystem::remove(path("cut.ofr"));
    }
}

TEST_F(BleedOption, UndoneKeepsVolumesAndChangesTheDither) {
    write_stripes();
    const std::string world = "stripes.fab.json";
    const Voxels plain = print_voxels({}, world);
    const Voxels undone = print_voxels({"--process", path("bleed.json")}, world);
    EXPECT_TRUE(print_voxels({"--process", path("bleed.json"), "--bleed", "off"}, world).codes ==
                plain.codes);
    ASSERT_EQ(plain.codes.size(), undone.codes.size());
    EXPECT_FALSE(plain.codes == undone.codes);
    for (uint8_t code = 0; code <= 3; ++code) {
        const auto before = static_cast<double>(count(plain, code));
        EXPECT_NEAR(static_cast<double>(count(undone, code)), before, 0.01 * before + 2) << +code;
    }
    for (size_t i = 0; i < plain.codes.size(); ++i)
        ASSERT_EQ(plain.codes[i] == 0, undone.codes[i] == 0);
}

TEST_F(BleedOption, MaterialRunsBeyondThePartWhereItIsShown) {
    const Voxels plain = print_voxels({});
    const Voxels shown = print_voxels({"--process", path("swell.json"), "--bleed", "show"});
    EXPECT_GT(shown.info.size.x, plain.info.size.x);
    EXPECT_LT(shown.info.origin_mm.x, plain.info.origin_mm.x);
    const auto solid = [&](const Voxels& voxels) {
        return static_cast<double>(voxels.codes.size()) - static_cast<double>(count(voxels, 0));
    };
    EXPECT_NEAR(solid(shown), solid(plain), 0.01 * solid(plain));
    // Some of what was void has material now: the ball is blurred.
    const Vec3i& size = shown.info.size;
    const double radius = 3;  // of a ball that stands on the tray
    int64_t outside = 0;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const Vec3d p{shown.info.origin_mm.x + (x + 0.5) * 0.1,
                              shown.info.origin_mm.y + (y + 0.5) * 0.1,
                              shown.info.origin_mm.z + (z + 0.5) * 0.1 - radius};
                const double r = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
                ASSERT_FALSE(r > radius + 0.6 && shown.at(x, y, z) != 0);
                outside += r > radius + 0.05 && shown.at(x, y, z) != 0 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(outside, 500);
}

TEST_F(BleedOption, DeadRowsHoldNoDropAfterIt) {
    scratch_.write("both.json", R"({"bleed": {"sigma_um": 80}, "dead": [{"material": "black",
        "nozzles": [0], "head": 2, "substitute": "grey"}]})");
    const Voxels printed = print_voxels({"--process", path("both.json")});
    const auto origin = static_cast<int32_t>(std::lround(printed.info.origin_mm.y / 0.1));
    for (int32_t z = 0; z < printed.info.size.z; ++z) {
        for (int32_t y = 0; y < printed.info.size.y; ++y) {
            for (int32_t x = 0; x < printed.info.size.x && (origin + y) % 2 == 0; ++x)
                ASSERT_NE(printed.at(x, y, z), 2);
        }
    }
}

TEST_F(BleedOption, MistakesAreTold) {
    const auto fails = [&](const std::string& text, const std::vector<std::string>& more,
                           const std::string& with) {
        scratch_.write("wrong.json", text);
        std::vector<std::string> all{"--process", path("wrong.json"), "-o", path("x.ofr")};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = print(all);
        EXPECT_NE(outcome.exit_code, 0) << text;
        EXPECT_THAT(outcome.err, Says(with)) << text;
    };
    fails(R"({"bleed": {"sigma_um": -1}})", {}, "sigma_um");
    fails(R"({"bleed": {"sigma_um": [1, 2]}})", {}, "sigma_um");
    fails(R"({"bleed": {"sigma_um": 2000}})", {}, "at most 32");
    fails(R"({"bleed": {"pairs": [{"materials": ["white"], "sigma_um": 3}]}})", {}, "two names");
    fails(R"({"bleed": {"pairs": [{"materials": ["white", "white"], "sigma_um": 3}]}})", {},
          "does not bleed into itself");
    fails(R"({"bleed": {"pairs": 4}})", {}, "`pairs`");
    fails(R"({"scale": 1})", {"--bleed", "show"}, process::messages::kBleedNotKnown);
    scratch_.write("other.json",
                   R"({"bleed": {"pairs": [{"materials": ["white", "gold"], "sigma_um": 30}]}})");
    const Outcome other = print({"--process", path("other.json"), "-o", path("x.ofr")});
    EXPECT_EQ(other.exit_code, 0) << other.err;
    EXPECT_THAT(other.err, Says(process::messages::kBleedIdle, "gold"));
}

/// The sum of the pictures of a folder, in voxels of pure material, and the number of grey pixels.
struct Grey {
    double sum = 0;
    int64_t between = 0;
};

TEST_F(BleedOption, GreyPicturesAreMeansOfVoxels) {
    const Voxels voxels = print_voxels({});
    const Vec3i& size = voxels.info.size;
    const auto read = [&](const std::string& folder, int bits) {
        Grey grey;
        raster::PngImage image;
        image.width = size.x;
        image.height = size.y;
        image.color = raster::PngColor::kGrey;
        image.bits = bits;
        image.pixels_per_metre_x = image.pixels_per_metre_y = 1000 / voxels.info.pitch_mm.x;
        image.text = "OpenFab";
        for (int32_t z = 1; z <= size.z; ++z) {
            const std::vector<uint8_t> rows = raster::decode_png(
                bytes(scratch_ / folder / fmt::format("slice_{:04}.png", z)), image);
            const size_t stride = 1 + static_cast<size_t>(size.x) * static_cast<size_t>(bits / 8);
            EXPECT_EQ(rows.size(), stride * static_cast<size_t>(size.y)) << z;
            for (size_t y = 0; (y + 1) * stride <= rows.size(); ++y) {
                for (size_t i = 1; i < stride; i += static_cast<size_t>(bits / 8)) {
                    const uint8_t* p = &rows[y * stride + i];
                    const double value = bits == 8 ? p[0] / 255.0 : (p[0] * 256 + p[1]) / 65535.0;
                    grey.sum += value;
                    grey.between += value > 0.01 && value < 0.99 ? 1 : 0;
                }
            }
        }
        return grey;
    };
    const Outcome eight = print({"--format", "grey", "--grey-material", "black", "-o", path("g8")});
    ASSERT_EQ(eight.exit_code, 0) << eight.err;
    const Outcome sixteen = print(
        {"--format", "grey16", "--grey-material", "black", "-o", path("g16"), "--threads", "3"});
    ASSERT_EQ(sixteen.exit_code, 0) << sixteen.err;
    const Grey g8 = read("g8", 8), g16 = read("g16", 16);
    const auto black = static_cast<double>(count(voxels, 2));
    EXPECT_NEAR(g16.sum, black, 0.02 * black);
    EXPECT_NEAR(g8.sum, g16.sum, 0.002 * black);
    EXPECT_GT(g16.between, 1000);
    const std::vector<uint8_t> manifest = bytes(scratch_ / "g8" / "manifest.json");
    EXPECT_THAT(std::string(manifest.begin(), manifest.end()), HasSubstr("\"black\""));

    const Outcome tiff = print({"--format", "tiff16", "-o", path("t16")});
    ASSERT_EQ(tiff.exit_code, 0) << tiff.err;
    const std::vector<uint8_t> file = bytes(scratch_ / "t16" / "slice_0030.tif");
    ASSERT_GT(file.size(), 200u);
    EXPECT_EQ(std::string(file.begin(), file.begin() + 2), "II");
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "t16" / "slice_0030.png"));

    const Outcome none = print({"--format", "grey", "--grey-material", "gold", "-o", path("g")});
    EXPECT_EQ(none.exit_code, 1);
    EXPECT_THAT(none.err, Says(program::messages::kGreyOfNoMaterial, "gold"));
}

}  // namespace
}  // namespace openfab::testing
