// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Charts read back: off photographs, from the front and askew; and the table of the gallery.

#include "tools/color/chart.h"
#include "tests/support/places/places.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/saved_profile.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/ink_table.h"
#include "tools/color/messages.h"
#include "tools/color/picture.h"

namespace openfab::color {
namespace {

using openfab::testing::SyntheticPrinter;
using ::testing::HasSubstr;

/// What a camera sees of a printed chart: `place` maps a pixel to the chart, 0..1 from its top left.
template <typename Place>
void photograph(const std::filesystem::path& file, int width, int height,
                const SyntheticPrinter& printer, const Place& place) {
    const SampleTable chart = ink_chart();
    const int rows = static_cast<int>(chart.samples.size()) / chart.columns;
    std::vector<Rgb> patches;
    for (const Sample& sample : chart.samples)
        patches.push_back(linear_of_xyz(to_xyz(printer.print(sample.inks))));
    std::vector<Rgb> pixels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto [u, v] = place((x + 0.5) / width, (y + 0.5) / height);
            const bool outside = u < 0 || u >= 1 || v < 0 || v >= 1;
            const auto patch = static_cast<size_t>(static_cast<int>(v * rows) * chart.columns +
                                                   static_cast<int>(u * chart.columns));
            pixels.push_back(outside ? Rgb{0.2, 0.2, 0.2} : patches[patch]);
        }
    }
    const Result<std::vector<uint8_t>> png = png_of(width, height, pixels);
    ASSERT_TRUE(png);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(png->data()),
               static_cast<std::streamsize>(png->size()));
}

Result<SampleTable> read_file(const std::filesystem::path& file, const SampleTable& chart,
                              const std::vector<double>& corners) {
    const Result<Picture> picture = Picture::read(file);
    if (!picture) return picture.error();
    return read_photograph(*picture, chart, {corners, {}});
}

void expect_measured(const Result<SampleTable>& read, const SyntheticPrinter& printer) {
    ASSERT_TRUE(read) << read.error().text();
    for (const Sample& sample : read->samples) {
        const Lab is = printer.print(sample.inks);
        const Rgb linear = linear_of_xyz(to_xyz(is));
        const auto [least, most] = std::minmax_element(linear.begin(), linear.end());
        if (*least < 0 || *most > 1) continue;                 // no sRGB picture has it
        EXPECT_LT(ciede2000(sample.lab, is), 1) << sample.id;  // of 8 bits
    }
}

TEST(Photograph, IsReadFromTheFrontAndAskew) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "chart.png";
    const SyntheticPrinter printer(0);
    photograph(file, 400, 360, printer, [](double x, double y) { return std::pair(x, y); });
    expect_measured(read_file(file, ink_chart(), {}), printer);
    // Turned by a quarter, its bottom farther away than its top, and sheared.
    const auto askew = [](double x, double y) {
        const double v = (x - 0.1) / 0.8, depth = 1 - 0.3 * v;
        return std::pair((0.95 - y - 0.1 * v) / (0.85 * depth), v * 0.7 / depth);
    };
    photograph(file, 700, 700, printer, askew);
    // Where (0, 0), (1, 0), (1, 1), (0, 1) of the chart are, by the inverse of `askew`.
    std::vector<double> corners;
    for (const auto& [u, v] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
        const double along = v / (0.7 + 0.3 * v);
        corners.push_back(700 * (0.1 + 0.8 * along));
        corners.push_back(700 * (0.95 - 0.1 * along - 0.85 * u * (1 - 0.3 * along)));
    }
    expect_measured(read_file(file, ink_chart(), corners), printer);
}

/// A chart of six patches in two rows, without colours of its own.
SampleTable six_patches() {
    SampleTable chart;
    chart.has_inks = true;
    chart.columns = 3;
    for (int k = 0; k < 6; ++k) {
        Sample sample;
        sample.id = std::to_string(k + 1);
        chart.samples.push_back(sample);
    }
    return chart;
}

/// Their colours, in sRGB.
constexpr std::array<std::array<uint8_t, 3>, 6> kSix = {
    {{250, 250, 250}, {0, 160, 220}, {220, 0, 120}, {250, 220, 0}, {20, 20, 20}, {128, 128, 128}}};

Lab lab_of_eight_bits(const std::array<uint8_t, 3>& rgb) {
    Rgb linear;
    for (size_t c = 0; c < 3; ++c)
        linear[c] = srgb_to_linear(rgb[c] / 255.0);
    return to_lab(xyz_of_linear(linear));
}

/// Puts a chunk with an EXIF orientation behind a PNG's header, which the library does not write.
void add_exif(const std::filesystem::path& file, int orientation) {
    std::ifstream in(file, std::ios::binary);
    std::string png((std::istreambuf_iterator<char>(in)), {});
    std::string chunk("eXIfMM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 4 + 19);
    chunk += static_cast<char>(orientation);
    chunk += std::string(6, '\0');
    uint32_t sum = ~0u;
    for (const char c : chunk) {
        sum ^= static_cast<uint8_t>(c);
        for (int bit = 0; bit < 8; ++bit)
            sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0);
    }
    const auto big = [](uint32_t n) {
        std::string out;
        for (int shift = 24; shift >= 0; shift -= 8)
            out += static_cast<char>(n >> shift);
        return out;
    };
    constexpr size_t kHeader = 33;
    png.insert(kHeader, big(static_cast<uint32_t>(chunk.size() - 4)) + chunk + big(~sum));
    std::ofstream(file, std::ios::binary) << png;
}

/// A picture of these patches, 16 pixels each, `margin` pixels of grey above and left of them, stored with
/// an EXIF orientation: where its first row and its first column are seen.
void write_six(const std::filesystem::path& file, int orientation, int margin,
               const std::vector<uint8_t>& icc = {}, bool exposed = false) {
    const int width = 48 + margin, height = 32 + margin;
    constexpr const char* kRowSide = " ttbblrrl";     // of the first row: top, bottom, left, right
    constexpr const char* kColumnSide = " lrrlttbb";  // of the first column
    const bool swapped = orientation > 4;
    OIIO::ImageSpec spec(swapped ? height : width, swapped ? width : height, 3,
                         OIIO::TypeDesc::UINT8);
    spec.attribute("Orientation", orientation);
    spec.attribute("CompressionQuality", 100);
    spec.attribute("jpeg:subsampling", "4:4:4");
    if (exposed) spec.attribute("ExposureTime", 0.01f);
    if (!icc.empty()) {
        spec.attribute("ICCProfile",
                       OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                       icc.data());
    }
    std::vector<uint8_t> pixels;
    for (int r = 0; r < spec.height; ++r) {
        for (int c = 0; c < spec.width; ++c) {
            int x = 0, y = 0;
            const auto place = [&](char side, int n) {
                if (side == 't') y = n;
                if (side == 'b') y = height - 1 - n;
                if (side == 'l') x = n;
                if (side == 'r') x = width - 1 - n;
            };
            place(kRowSide[orientation], r);
            place(kColumnSide[orientation], c);
            const bool outside = x < margin || y < margin;
            const auto patch = static_cast<size_t>((y - margin) / 16 * 3 + (x - margin) / 16);
            for (size_t k = 0; k < 3; ++k)
                pixels.push_back(outside ? 90 : kSix[patch][k]);
        }
    }
    auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out->open(file.string(), spec));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    ASSERT_TRUE(out->close());
}

TEST(Photograph, IsTurnedAsItsFileSays) {
    const openfab::testing::TempFolder folder;
    for (const char* name : {"a.jpg", "a.tif", "a.png"}) {
        for (int orientation = 1; orientation <= 8; ++orientation) {
            SCOPED_TRACE(std::string(name) + ", " + std::to_string(orientation));
            const std::filesystem::path file = folder.path() / name;
            for (const int margin : {0, 10}) {
                write_six(file, orientation, margin);
                if (file.extension() == ".png") add_exif(file, orientation);
                std::vector<double> corners;
                if (margin > 0) corners = {10, 10, 58, 10, 58, 42, 10, 42};  // as a viewer shows it
                const Result<SampleTable> read = read_file(file, six_patches(), corners);
                ASSERT_TRUE(read) << read.error().text();
                for (size_t k = 0; k < 6; ++k)
                    EXPECT_LT(ciede2000(read->samples[k].lab, lab_of_eight_bits(kSix[k])), 1) << k;
            }
        }
    }
}

/// A profile of sRGB's colours, but of this class, made from a target whose paper reflects `white`.
std::vector<uint8_t> profile_of_class(cmsProfileClassSignature kind, double white) {
    cmsHPROFILE profile = cmsCreate_sRGBProfile();
    cmsSetProfileVersion(profile, 2.4);
    cmsSetDeviceClass(profile, kind);
    const cmsCIEXYZ paper{kD50.x * white, kD50.y * white, kD50.z * white * 0.9};
    EXPECT_TRUE(cmsWriteTag(profile, cmsSigMediaWhitePointTag, &paper));
    return openfab::testing::saved(profile);
}

TEST(Photograph, OfAScannerIsMeasuredAgainstThePaperOfItsProfile) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "scan.tif";
    const auto read = [&](const std::vector<uint8_t>& icc, bool exposed) {
        write_six(file, 1, 0, icc, exposed);
        const Result<Picture> picture = Picture::read(file);
        EXPECT_TRUE(picture);
        EXPECT_EQ(picture->by_camera(), exposed);
        const Result<SampleTable> table =
            read_photograph(*picture, six_patches(), {{}, picture->input_white()});
        EXPECT_TRUE(table);
        return table->samples;
    };
    // Absolute colorimetric: each of X, Y, Z times that of the paper through that of D50 (ICC.1, D.6).
    const std::vector<Sample> scan = read(profile_of_class(cmsSigInputClass, 0.85), false);
    const std::vector<Sample> screen = read(profile_of_class(cmsSigDisplayClass, 0.85), true);
    for (size_t k = 0; k < 6; ++k) {
        const Lab relative = lab_of_eight_bits(kSix[k]);
        Xyz xyz = to_xyz(relative);
        xyz = {xyz.x * 0.85, xyz.y * 0.85, xyz.z * 0.85 * 0.9};
        EXPECT_LT(ciede2000(scan[k].lab, to_lab(xyz)), 0.3) << k;
        EXPECT_LT(ciede2000(screen[k].lab, relative), 0.3) << k;
    }
}

TEST(Photograph, CornersThatNoChartHasAreRefused) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "a.png";
    write_six(file, 1, 0);
    struct Refused {
        std::vector<double> corners;
        std::string message;
    };
    const std::string equal = fmt::format(messages::kCornersEqual, 1, 2);
    for (const Refused& refused : {
             // As one reads: the sides left and right cross, or those above and below.
             Refused{{0, 0, 48, 0, 0, 32, 48, 32}, messages::kCornersCross},
             Refused{{0, 0, 48, 32, 48, 0, 0, 32}, messages::kCornersCross},
             Refused{{48, 32, 0, 32, 48, 0, 0, 0}, messages::kCornersCross},
             Refused{{48, 0, 0, 0, 0, 32, 48, 32}, messages::kCornersMirrored},
             Refused{{0, 0, 0, 32, 48, 32, 48, 0}, messages::kCornersMirrored},
             Refused{{0, 0, 24, 16, 48, 32, 0, 32}, messages::kCornersOnLine},
             Refused{{0, 0, 16, 0, 32, 0, 48, 0}, messages::kCornersOnLine},
             Refused{{0, 0, 48, 0, 8, 6, 0, 32}, messages::kCornerWithin},
             Refused{{5, 5, 5, 5, 48, 32, 0, 32}, equal},
             Refused{{5, 5, 48, 0, 48, 32, 5, 5}, fmt::format(messages::kCornersEqual, 1, 4)},
             Refused{{5, 5, 5, 5, 5, 5, 5, 5}, equal},
             Refused{{0, 0, std::nan(""), 0, 48, 32, 0, 32},
                     fmt::format(messages::kCornerOutside, 2, 48, 32)},
         }) {
        const Result<SampleTable> read = read_file(file, six_patches(), refused.corners);
        ASSERT_FALSE(read) << refused.message;
        EXPECT_THAT(read.error().text(), testing::Says(refused.message));
    }
    // Upside down, and on its side: as photographs have it.
    for (const std::vector<double>& corners : std::vector<std::vector<double>>{
             {48, 32, 0, 32, 0, 0, 48, 0}, {48, 0, 48, 32, 0, 32, 0, 0}}) {
        EXPECT_TRUE(read_file(file, six_patches(), corners));
    }
}

TEST(Photograph, SaysWhatIsWrong) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "chart.png";
    photograph(file, 20, 18, SyntheticPrinter(0),
               [](double x, double y) { return std::pair(x, y); });
    EXPECT_THAT(read_file(file, ink_chart(), {0, 0, 20, 0, 21, 18, 0, 18}).error().text(),
                testing::Says(messages::kCornerOutside, "3", "20", "18"));
    EXPECT_THAT(read_file(file, ink_chart(), {0, 0, 5, 0, 10, 0, 15, 0}).error().text(),
                testing::Says(messages::kCornersOnLine));
    SampleTable loose = ink_chart();
    loose.columns = 0;
    EXPECT_THAT(read_file(file, loose, {}).error().text(),
                testing::Says(messages::kPatchLayoutUnknown));
    EXPECT_THAT(read_file(folder.path() / "none.png", ink_chart(), {}).error().text(),
                HasSubstr("none.png"));
}

// Made of the nominal inks by the commands of its README, which take longer than a test may. What
// it says must hold for those inks.
TEST(GalleryTable, GreysAreGreyAndHuesAreThemselves) {
    const Result<InkTable> table =
        InkTable::read(testing::source_dir() / "gallery/ink_profile/inks.nrrd");
    ASSERT_TRUE(table) << table.error().text();
    const SyntheticPrinter printer(0);
    const Xyz white = to_xyz(printer.print({}));
    const auto printed = [&](const Rgb& rgb) {
        return to_lab(to_xyz(printer.print(table->at(rgb))), white);
    };
    double before = -1;
    for (int i = 0; i <= 32; ++i) {
        const double v = i / 32.0;
        const Lab grey = printed({v, v, v});
        EXPECT_LT(std::hypot(grey.a, grey.b), 4) << v;
        EXPECT_GT(grey.l, before - 0.5) << v;
        before = grey.l;
    }
    EXPECT_NEAR(before, 100, 0.5);
    EXPECT_LT(printed({0, 0, 0}).l, 40);
    for (const Rgb& rgb : {Rgb{0.8, 0.4, 0.4}, Rgb{0.8, 0.8, 0.4}, Rgb{0.4, 0.7, 0.4},
                           Rgb{0.5, 0.6, 0.8}, Rgb{0.7, 0.5, 0.8}}) {
        Rgb linear;
        for (size_t c = 0; c < 3; ++c)
            linear[c] = std::pow(rgb[c], 2.2);
        const Lab asked = to_lab(xyz_of_linear(linear)), is = printed(rgb);
        const double turn = std::atan2(is.b, is.a) - std::atan2(asked.b, asked.a);
        EXPECT_LT(std::abs(std::remainder(turn, 2 * 3.14159265)), 0.3);
    }
}

}  // namespace
}  // namespace openfab::color
