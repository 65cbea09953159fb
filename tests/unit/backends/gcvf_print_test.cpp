// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// GCVF packages as other programs may write them: names and kinds of slices, and what is refused.

#include "backends/read/gcvf_print.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <png.h>

#include <fstream>
#include <string>
#include <vector>

#include "backends/read/messages.h"
#include "backends/read/png_pixels.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::prints {
namespace {

using ::testing::ElementsAre;
using testing::Says;

/// A picture of 3 x 2 pixels of numbers 0 to 2, the upper row first.
using Picture = std::vector<std::vector<int>>;

constexpr int kPalette[3][4] = {{0, 0, 0, 0}, {255, 255, 255, 255}, {200, 10, 20, 255}};

struct Kind {
    int type = PNG_COLOR_TYPE_RGBA;
    int bits = 8;
    bool interlaced = false, transparent = false;
    double gamma = 0;
};

/// Writes a picture by libpng, of grey as the numbers themselves.
std::string png(const Picture& picture, const Kind& kind) {
    std::string out;
    png_structp file = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(file);
    png_set_write_fn(
        file, &out,
        [](png_structp p, png_bytep bytes, size_t n) {
            static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(bytes), n);
        },
        nullptr);
    const auto width = static_cast<uint32_t>(picture[0].size());
    png_set_IHDR(file, info, width, static_cast<uint32_t>(picture.size()), kind.bits, kind.type,
                 kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_color colors[3];
    png_byte opacity[3];
    for (size_t i = 0; i < 3; ++i) {
        colors[i] = {static_cast<png_byte>(kPalette[i][0]), static_cast<png_byte>(kPalette[i][1]),
                     static_cast<png_byte>(kPalette[i][2])};
        opacity[i] = static_cast<png_byte>(kPalette[i][3]);
    }
    if (kind.type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(file, info, colors, 3);
    if (kind.transparent) png_set_tRNS(file, info, opacity, 3, nullptr);
    if (kind.gamma > 0) png_set_gAMA(file, info, kind.gamma);
    png_write_info(file, info);
    if (kind.bits < 8) png_set_packing(file);
    const int channels = png_get_channels(file, info);
    std::vector<std::string> rows;
    for (const std::vector<int>& from : picture) {
        std::string& row = rows.emplace_back();
        for (const int number : from) {
            for (int c = 0; c < channels; ++c) {
                const bool is_number = channels == 1;
                const int value = is_number ? number : kPalette[number][c];
                if (kind.bits == 16) row.push_back(static_cast<char>(value));
                row.push_back(static_cast<char>(value));
            }
        }
    }
    std::vector<png_bytep> at;
    for (std::string& row : rows)
        at.push_back(reinterpret_cast<png_bytep>(row.data()));
    png_write_image(file, at.data());
    png_write_end(file, nullptr);
    png_destroy_write_struct(&file, &info);
    return out;
}

const Picture kFirst{{0, 1, 2}, {1, 1, 0}}, kSecond{{2, 2, 0}, {0, 1, 1}};

std::string config(const std::string& more = {}, const std::string& background = "0 0 0 0") {
    return fmt::format(
        "<?xml version=\"1.0\"?>\n<GCVF><Version>2</Version><Resolution><XDpi>600</XDpi>"
        "<YDpi> 300 </YDpi><SliceThicknessNanoMeter>27000</SliceThicknessNanoMeter></Resolution>"
        "<SliceDimensions><SliceWidth>3</SliceWidth><SliceHeight>2</SliceHeight></SliceDimensions>"
        "<SliceRange><StartIndex>7</StartIndex><NumberOfSlices>2</NumberOfSlices></SliceRange>"
        "<ImageFilePrefix>layer-</ImageFilePrefix>{}<MaterialList>"
        "<BackGroundMaterialRGBA>{}</BackGroundMaterialRGBA>"
        "<Material><Name>VeroWhite</Name><RGBA>255 255 255 255</RGBA></Material>"
        "<Material><Name>Agilus &amp; co</Name><RGBA>200 10 20 255</RGBA><VoxelCount>3</VoxelCount>"
        "</Material></MaterialList></GCVF>",
        more, background);
}

class GcvfPrints : public ::testing::Test {
  protected:
    std::string package(const std::vector<std::pair<std::string, std::string>>& files) {
        const std::string name = (scratch_ / "a.gcvf").string();
        std::ofstream(name, std::ios::binary) << testing::zip_archive(files);
        return name;
    }
    std::string slices(const Kind& first, const Kind& second, const std::string& text = config()) {
        return package({{"ConfigFile.xml", text},
                        {"layer-7.png", png(kFirst, first)},
                        {"layer-8.png", png(kSecond, second)}});
    }
    /// The codes of a slice, lowest row first.
    std::vector<int> codes(const PrintFile& print, int32_t z) {
        SliceBuffers buffers;
        const Result<void> read = print.read_slice(z, &buffers);
        if (!read) return ADD_FAILURE() << read.error().text(), std::vector<int>();
        std::vector<int> out;
        for (size_t y = 0; y < 2; ++y) {
            for (size_t x = 0; x < 3; ++x)
                out.push_back(buffers.rows[y * print.row_bytes() + x / 2] >> (4 * (x % 2)) & 15);
        }
        return out;
    }
    std::string refusal(const std::string& file) {
        const auto print = PrintFile::open(file, int64_t{1} << 30);
        if (!print) return print.error().text();
        SliceBuffers buffers;
        for (int32_t z = 0; z < 2; ++z) {
            if (const Result<void> read = (*print)->read_slice(z, &buffers); !read)
                return read.error().text();
        }
        return "nothing is wrong";
    }

    testing::ScratchFolder scratch_;
};

TEST_F(GcvfPrints, HaveSlicesOfAnyKindOfPng) {
    const Kind rgba, rgb{PNG_COLOR_TYPE_RGB}, interlaced{PNG_COLOR_TYPE_RGBA, 8, true};
    const Kind palette{PNG_COLOR_TYPE_PALETTE, 8, false, true};
    const Kind small{PNG_COLOR_TYPE_PALETTE, 2, true, true};
    // A file that says how its colours look means the same names.
    const Kind dark{PNG_COLOR_TYPE_RGBA, 8, false, false, 1.0};
    for (const Kind& kind : {rgba, interlaced, palette, small, dark, rgb}) {
        SCOPED_TRACE(fmt::format("type {}, {} bits", kind.type, kind.bits));
        const auto print = PrintFile::open(slices(kind, rgba), int64_t{1} << 30);
        ASSERT_TRUE(print) << print.error().text();
        EXPECT_THAT(codes(**print, 0), ElementsAre(1, 1, 0, 0, 1, 2));
        EXPECT_THAT(codes(**print, 1), ElementsAre(0, 1, 1, 2, 2, 0));
    }
}

TEST_F(GcvfPrints, SayWhatTheyAre) {
    const auto print = PrintFile::open(slices({}, {}), int64_t{1} << 30);
    ASSERT_TRUE(print) << print.error().text();
    const pipeline::PrintInfo& info = (*print)->info();
    EXPECT_EQ(info.size, (Vec3i{3, 2, 2}));
    EXPECT_DOUBLE_EQ(info.pitch_mm.x, 25.4 / 600);
    EXPECT_DOUBLE_EQ(info.pitch_mm.y, 25.4 / 300);
    EXPECT_DOUBLE_EQ(info.pitch_mm.z, 0.027);
    ASSERT_EQ(info.materials.size(), 2u);
    EXPECT_EQ(info.materials[1].name, "Agilus & co");
    EXPECT_EQ((*print)->whole_slices(), 2);
    // One material has no number of voxels, so there are no totals.
    EXPECT_FALSE((*print)->totals());
}

TEST_F(GcvfPrints, MissASliceAndSayWhich) {
    const auto print = PrintFile::open(
        package({{"ConfigFile.xml", config()}, {"layer-7.png", png(kFirst, {})}}), 1 << 30);
    ASSERT_TRUE(print) << print.error().text();
    EXPECT_EQ((*print)->whole_slices(), 1);
    SliceBuffers buffers;
    EXPECT_THAT((*print)->read_slice(1, &buffers).error().text(),
                Says(messages::kSliceNotThere, "1"));
}

TEST_F(GcvfPrints, OfAnotherBackground) {
    const Picture opaque{{1, 1, 1}, {1, 2, 1}};
    const auto with = [&](const std::string& background) {
        return package({{"ConfigFile.xml", config({}, background)},
                        {"layer-7.png", png(kFirst, {PNG_COLOR_TYPE_RGB})},
                        {"layer-8.png", png(opaque, {})}});
    };
    EXPECT_EQ(refusal(with("0 0 0 255")), "nothing is wrong");
    // Black is void in the first kind alone; a picture without opacity tells colours apart by three numbers.
    EXPECT_THAT(refusal(with("9 9 9 255")),
                Says(messages::kColourOfNoMaterial, "0", "0", "0", "0", "255", "0", "0"));
}

TEST_F(GcvfPrints, AreRefusedByName) {
    const auto without = [](std::string text, const std::string& part) {
        const size_t at = text.find("<" + part + ">");
        const std::string end = "</" + part + ">";
        return text.erase(at, text.find(end) + end.size() - at);
    };
    const auto config_is = [&](const std::string& text) { return slices({}, {}, text); };
    EXPECT_THAT(refusal(package({{"a.png", "x"}})),
                Says(messages::kNoGcvf, messages::kConfigMissing));
    for (const char* part : {"SliceWidth", "NumberOfSlices", "YDpi", "SliceThicknessNanoMeter"}) {
        EXPECT_THAT(refusal(config_is(without(config(), part))),
                    Says(messages::kNoGcvf, fmt::format(messages::kConfigLacks, part)));
    }
    EXPECT_THAT(refusal(config_is(config("<DataSemantics>Colors</DataSemantics>"))),
                Says(messages::kNotOfMaterials, "Colors"));
    std::string same = config();
    same.replace(same.find("200 10 20"), 9, "255 255 255");
    EXPECT_THAT(refusal(config_is(same)), Says(messages::kMaterialsOfOneColour));
    const std::string good = png(kFirst, {});
    EXPECT_THAT(refusal(package({{"ConfigFile.xml", config()},
                                 {"layer-7.png", good},
                                 {"layer-8.png", png({{1, 1}, {1, 1}}, {})}})),
                Says(messages::kPictureOfOtherSize, "2", "2", "3", "2"));
    EXPECT_THAT(refusal(package({{"ConfigFile.xml", config()},
                                 {"layer-7.png", png(kFirst, {PNG_COLOR_TYPE_RGBA, 16})},
                                 {"layer-8.png", good}})),
                Says(messages::kPngOfSixteenBits));
    for (const size_t kept : {size_t{0}, size_t{7}, size_t{40}, good.size() - 20}) {
        EXPECT_THAT(refusal(package({{"ConfigFile.xml", config()},
                                     {"layer-7.png", good},
                                     {"layer-8.png", good.substr(0, kept)}})),
                    Says(messages::kNoPng))
            << kept;
    }
}

}  // namespace
}  // namespace openfab::prints
