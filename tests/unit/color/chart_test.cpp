// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Charts read back: off photographs, from the front and askew; and the table of the gallery.

#include "tools/color/chart.h"
#include "tests/support/places/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
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
    expect_measured(read_photograph(file, ink_chart(), {}), printer);
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
    expect_measured(read_photograph(file, ink_chart(), corners), printer);
}

TEST(Photograph, SaysWhatIsWrong) {
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "chart.png";
    photograph(file, 20, 18, SyntheticPrinter(0),
               [](double x, double y) { return std::pair(x, y); });
    EXPECT_THAT(read_photograph(file, ink_chart(), {0, 0, 20, 0, 21, 18, 0, 18}).error().text(),
                testing::Says(messages::kCornerOutside, "3", "20", "18"));
    EXPECT_THAT(read_photograph(file, ink_chart(), {0, 0, 5, 0, 10, 0, 15, 0}).error().text(),
                testing::Says(messages::kCornersOnLine));
    SampleTable loose = ink_chart();
    loose.columns = 0;
    EXPECT_THAT(read_photograph(file, loose, {}).error().text(),
                testing::Says(messages::kPatchLayoutUnknown));
    EXPECT_THAT(read_photograph(folder.path() / "none.png", ink_chart(), {}).error().text(),
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
