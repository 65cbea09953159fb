// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of inks, by the profile in them, and of cameras, by EXIF.

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include <jpeglib.h>  // after what declares FILE

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/picture.h"
#include "tools/color/profile.h"
#include "tools/texture/messages.h"

namespace openfab::color {
namespace {

using openfab::testing::SyntheticPrinter;

/// The profile of a printer of CMYK, small.
const std::string& ink_profile() {
    static const std::string kProfile = [] {
        const Result<PrinterModel> model = PrinterModel::fit(SyntheticPrinter(0.1).measured(0));
        ProfileOptions options;
        options.ink_nodes = 9;
        options.color_nodes = 5;
        options.version_two = true;
        const Result<std::string> made = make_profile(*model, options);
        EXPECT_TRUE(made);
        return *made;
    }();
    return kProfile;
}

constexpr std::array<std::array<uint8_t, 4>, 6> kMixtures = {{{0, 0, 0, 0},
                                                              {255, 0, 0, 0},
                                                              {0, 255, 0, 0},
                                                              {0, 0, 0, 255},
                                                              {76, 51, 25, 51},
                                                              {10, 90, 40, 0}}};

/// A TIFF of these mixtures, a pixel each.
void write_inks(const std::filesystem::path& file, OIIO::TypeDesc kind, const std::string& icc) {
    OIIO::ImageSpec spec(static_cast<int>(kMixtures.size()), 1, 4, kind);
    spec.channelnames = {"C", "M", "Y", "K"};
    spec.alpha_channel = -1;
    spec.attribute("tiff:ColorSpace", "CMYK");
    spec.attribute("oiio:ColorSpace", "CMYK");
    if (!icc.empty()) {
        spec.attribute("ICCProfile",
                       OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                       icc.data());
    }
    auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out->open(file.string(), spec)) << out->geterror();
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, kMixtures.data()));
    ASSERT_TRUE(out->close());
}

TEST(PictureOfInks, IsReadByItsProfile) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "inks.tif";
    const std::string& icc = ink_profile();
    const Result<PrinterProfile> profile = PrinterProfile::parse({icc.begin(), icc.end()});
    ASSERT_TRUE(profile);
    std::vector<Inks> inks;
    for (const auto& mixture : kMixtures)
        inks.push_back(
            {mixture[0] / 255.0, mixture[1] / 255.0, mixture[2] / 255.0, mixture[3] / 255.0});
    const Result<std::vector<Lab>> wanted = profile->to_lab(inks, false);
    ASSERT_TRUE(wanted);
    for (const OIIO::TypeDesc& kind :
         {OIIO::TypeDesc(OIIO::TypeDesc::UINT8), OIIO::TypeDesc(OIIO::TypeDesc::UINT16)}) {
        write_inks(file, kind, icc);
        const Result<Picture> picture = Picture::read(file);
        ASSERT_TRUE(picture) << picture.error().text();
        EXPECT_EQ(picture->note(), "");
        for (size_t k = 0; k < inks.size(); ++k) {
            const Lab is = to_lab(xyz_of_linear(picture->at(static_cast<int>(k), 0)));
            EXPECT_LT(ciede2000(is, (*wanted)[k]), 0.3) << k;
        }
    }
    // Without one, as ideal inks, and that is said.
    write_inks(file, OIIO::TypeDesc::UINT8, "");
    const Result<Picture> bare = Picture::read(file);
    ASSERT_TRUE(bare) << bare.error().text();
    EXPECT_THAT(bare->note(), testing::Says(tools::messages::kInksWithoutProfile));
    EXPECT_NEAR(bare->at(1, 0)[0], 0, 1e-6);
    EXPECT_NEAR(bare->at(1, 0)[1], 1, 1e-6);
}

/// A JPEG of these mixtures, squares of 16 pixels, as Adobe's programs write them: what is left white, with
/// their marker; YCCK: as light and differences of color. Without a marker where `marked` is false.
void write_jpeg_inks(const std::filesystem::path& file, bool ycck, bool marked,
                     const std::string& icc) {
    constexpr size_t kSide = 16;
    jpeg_compress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    FILE* const out = std::fopen(file.c_str(), "wb");
    ASSERT_NE(out, nullptr);
    jpeg_stdio_dest(&jpeg, out);
    jpeg.image_width = static_cast<JDIMENSION>(kSide * kMixtures.size());
    jpeg.image_height = kSide;
    jpeg.input_components = 4;
    jpeg.in_color_space = JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_colorspace(&jpeg, ycck ? JCS_YCCK : JCS_CMYK);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg.write_Adobe_marker = marked ? TRUE : FALSE;
    jpeg_start_compress(&jpeg, TRUE);
    // Segments of a profile (ICC.1, annex B).
    constexpr size_t kMost = 60000;
    const size_t segments = (icc.size() + kMost - 1) / kMost;
    for (size_t k = 0; k < segments; ++k) {
        std::string text("ICC_PROFILE\0", 12);
        text += static_cast<char>(k + 1);
        text += static_cast<char>(segments);
        text += icc.substr(k * kMost, kMost);
        jpeg_write_marker(&jpeg, JPEG_APP0 + 2, reinterpret_cast<const JOCTET*>(text.data()),
                          static_cast<unsigned>(text.size()));
    }
    std::vector<uint8_t> row;
    for (const auto& mixture : kMixtures) {
        for (size_t x = 0; x < kSide; ++x) {
            for (const uint8_t ink : mixture)
                row.push_back(static_cast<uint8_t>(255 - ink));
        }
    }
    for (size_t y = 0; y < kSide; ++y) {
        JSAMPROW line = row.data();
        jpeg_write_scanlines(&jpeg, &line, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    std::fclose(out);
}

TEST(PictureOfInks, InAJpegIsReadByItsProfile) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "inks.jpg";
    const std::string& icc = ink_profile();
    const Result<PrinterProfile> profile = PrinterProfile::parse({icc.begin(), icc.end()});
    ASSERT_TRUE(profile);
    std::vector<Inks> inks;
    for (const auto& mixture : kMixtures)
        inks.push_back(
            {mixture[0] / 255.0, mixture[1] / 255.0, mixture[2] / 255.0, mixture[3] / 255.0});
    const Result<std::vector<Lab>> wanted = profile->to_lab(inks, false);
    ASSERT_TRUE(wanted);
    for (const bool ycck : {false, true}) {
        SCOPED_TRACE(ycck);
        write_jpeg_inks(file, ycck, true, icc);
        const Result<Picture> picture = Picture::read(file);
        ASSERT_TRUE(picture) << picture.error().text();
        EXPECT_EQ(picture->note(), "");
        for (size_t k = 0; k < inks.size(); ++k) {
            const Lab is = to_lab(xyz_of_linear(picture->at(static_cast<int>(16 * k + 8), 8)));
            EXPECT_LT(ciede2000(is, (*wanted)[k]), ycck ? 2 : 1)
                << k;  // steps of 8 bits, where inks tint most
        }
        // Without one, as ideal inks, and that is said.
        write_jpeg_inks(file, ycck, true, "");
        const Result<Picture> bare = Picture::read(file);
        ASSERT_TRUE(bare) << bare.error().text();
        EXPECT_THAT(bare->note(), testing::Says(tools::messages::kInksWithoutProfile));
        EXPECT_NEAR(bare->at(24, 8)[0], 0, 0.01);
        EXPECT_NEAR(bare->at(24, 8)[1], 1, 0.01);
    }
    for (const std::string& with : {icc, std::string()}) {
        write_jpeg_inks(file, false, false, with);
        const Result<Picture> unmarked = Picture::read(file);
        ASSERT_FALSE(unmarked);
        EXPECT_THAT(unmarked.error().text(), testing::Says(tools::messages::kInksOfUnknownSense));
    }
    // What is cut short is damaged, not grey.
    write_jpeg_inks(file, false, true, icc);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 200);
    EXPECT_FALSE(Picture::read(file));
}

/// Numbers of a TIFF structure, either end first.
struct Numbers {
    bool little;
    std::string text;
    void add(uint32_t value, int bytes) {
        for (int k = 0; k < bytes; ++k)
            text += static_cast<char>(value >> 8 * (little ? k : bytes - 1 - k));
    }
    void entry(uint32_t tag, uint32_t type, uint32_t count, uint32_t value, int bytes) {
        add(tag, 2);
        add(type, 2);
        add(count, 4);
        add(value, bytes);
        text += std::string(static_cast<size_t>(4 - bytes), '\0');
    }
};

/// EXIF of a camera: a colour space, and an index of interoperability where it is not empty.
std::string exif(bool little, uint32_t color_space, const std::string& index) {
    Numbers n{little, little ? "II" : "MM"};
    n.add(42, 2);
    n.add(8, 4);
    n.add(1, 2);  // at 8
    n.entry(0x8769, 4, 1, 26, 4);
    n.add(0, 4);
    n.add(index.empty() ? 1 : 2, 2);  // at 26
    n.entry(0xa001, 3, 1, color_space, 2);
    if (!index.empty()) n.entry(0xa005, 4, 1, 56, 4);
    n.add(0, 4);
    if (index.empty()) return n.text;
    n.add(1, 2);  // at 56
    n.add(1, 2);
    n.add(2, 2);
    n.add(4, 4);
    n.text += index + '\0';
    n.add(0, 4);
    return n.text;
}

void write_photograph(const std::filesystem::path& file, const std::string& exif) {
    constexpr std::array<uint8_t, 3> kGreen = {0, 255, 0};
    OIIO::ImageSpec spec(16, 16, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("CompressionQuality", 100);
    spec.attribute("jpeg:subsampling", "4:4:4");
    std::vector<uint8_t> pixels;
    for (int k = 0; k < 256; ++k)
        pixels.insert(pixels.end(), kGreen.begin(), kGreen.end());
    auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out->open(file.string(), spec));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    ASSERT_TRUE(out->close());
    if (exif.empty()) return;
    std::ifstream in(file, std::ios::binary);
    std::string jpeg((std::istreambuf_iterator<char>(in)), {});
    const std::string body = std::string("Exif\0\0", 6) + exif;
    const size_t length = body.size() + 2;
    std::string segment = "\xff\xe1";
    segment += static_cast<char>(length >> 8);
    segment += static_cast<char>(length);
    jpeg.insert(2, segment + body);
    std::ofstream(file, std::ios::binary) << jpeg;
}

TEST(PictureOfACamera, IsAdobeRgbWhereExifSaysSo) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "photo.jpg";
    // Its green in linear sRGB, from the two sets of primaries: (-0.3984, 1, -0.0429).
    for (const bool little : {false, true}) {
        write_photograph(file, exif(little, 65535, "R03"));
        const Result<Picture> wide = Picture::read(file);
        ASSERT_TRUE(wide) << wide.error().text();
        EXPECT_NEAR(wide->at(8, 8)[0], -0.398, 0.02);
        EXPECT_NEAR(wide->at(8, 8)[1], 1, 0.02);
        EXPECT_NEAR(wide->at(8, 8)[2], -0.043, 0.02);
        EXPECT_EQ(wide->note(), "");
        for (const char* other : {"R98", ""}) {
            write_photograph(file, exif(little, 65535, other));
            const Result<Picture> unsaid = Picture::read(file);
            ASSERT_TRUE(unsaid);
            EXPECT_NEAR(unsaid->at(8, 8)[0], 0, 0.02);
            EXPECT_THAT(unsaid->note(), testing::Says(tools::messages::kUncalibrated));
        }
        write_photograph(file, exif(little, 1, "R98"));
        EXPECT_EQ(Picture::read(file)->note(), "");
        EXPECT_NEAR(Picture::read(file)->at(8, 8)[0], 0, 0.02);
    }
    write_photograph(file, "");
    EXPECT_EQ(Picture::read(file)->note(), "");
    // Directories that point anywhere say nothing.
    for (size_t k = 0; k < 60; ++k) {
        std::string broken = exif(true, 65535, "R03");
        broken[k] = '\xff';
        write_photograph(file, broken.substr(0, broken.size() - k / 2));
        EXPECT_TRUE(Picture::read(file)) << k;
    }
}

}  // namespace
}  // namespace openfab::color
