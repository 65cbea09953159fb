// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A chart of colours through a table of inks, by the programs that users run: what the kernel looks
// up and the dither makes against the table itself. And commands that are refused.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "program/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/chart.h"
#include "tools/color/ink_table.h"
#include "tools/color/messages.h"
#include "tools/color/picture.h"
#include "tools/color/printer_model.h"
#include "tools/texture/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
const std::string kTable = source_dir() / "gallery/ink_profile/inks.nrrd";

Outcome openfab(const ScratchFolder& folder, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program("openfab"));
    RunOptions options;
    options.folder = folder.path();
    options.environment = {{"OPENFAB_CACHE", (folder / "cache").string()}};
    return run(arguments, options);
}

TEST(ColorCommand, APrintedChartHasTheInksOfItsTable) {
    const ScratchFolder folder;
    const Outcome made = openfab(folder, {"color", "chart", "--table", kTable, "-o", "chart"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const Outcome printed =
        openfab(folder, {"print", "chart/chart.fab.json", "-o", "chart.ofr", "--draft", "2"});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Result<color::SampleTable> chart = color::read_samples(folder / "chart/chart.txt");
    ASSERT_TRUE(chart) << chart.error().text();
    const Result<color::PrintedChart> is =
        color::read_print((folder / "chart.ofr").string(), *chart, 0.5);
    ASSERT_TRUE(is) << is.error().text();
    const Result<color::InkTable> table = color::InkTable::read(kTable);
    ASSERT_TRUE(table) << table.error().text();
    double sum = 0;
    for (size_t k = 0; k < chart->samples.size(); ++k) {
        const color::Inks wanted = table->at(chart->samples[k].rgb);
        for (size_t i = 0; i < wanted.size(); ++i) {
            // 1,771 voxels: white noise would be off by 0.012 in the standard deviation, blue noise
            // is off by less.
            EXPECT_NEAR(is->patches[k][i], wanted[i], 0.02) << "patch " << k + 1;
            sum += std::abs(is->patches[k][i] - wanted[i]);
        }
    }
    EXPECT_LT(sum / static_cast<double>(4 * chart->samples.size()), 0.004);

    // The same print as a proof shows it, a millimetre a pixel: each patch of 4 mm as the profile sees
    // its inks.
    const SyntheticPrinter printer(0.2);
    const Result<color::PrinterModel> model = color::PrinterModel::fit(printer.measured(0));
    ASSERT_TRUE(model) << model.error().text();
    color::ProfileOptions options;
    options.ink_nodes = options.color_nodes = 9;
    const Result<std::string> icc = color::make_profile(*model, options);
    ASSERT_TRUE(icc) << icc.error().text();
    folder.write("printer.icc", *icc);
    const Outcome proofed = openfab(folder, {"color", "proof", "chart.ofr", "printer.icc", "-o",
                                             "proof.png", "--window", "1mm"});
    ASSERT_EQ(proofed.exit_code, 0) << proofed.err;
    const Result<color::Picture> proof = color::Picture::read(folder / "proof.png");
    ASSERT_TRUE(proof) << proof.error().text();
    EXPECT_EQ(proof->width(), 4 * chart->columns);
    const Result<color::PrinterProfile> profile =
        color::PrinterProfile::read(folder / "printer.icc");
    ASSERT_TRUE(profile);
    const Result<std::vector<color::Lab>> wanted = profile->to_lab(is->patches, false);
    ASSERT_TRUE(wanted);
    double differences = 0;
    for (size_t k = 0; k < wanted->size(); ++k) {
        const int x = static_cast<int>(k) % chart->columns,
                  y = static_cast<int>(k) / chart->columns;
        color::Rgb mean{};
        for (const int inner : {0, 1, 2, 3}) {
            const color::Rgb& pixel = proof->at(4 * x + 1 + inner % 2, 4 * y + 1 + inner / 2);
            for (size_t c = 0; c < 3; ++c)
                mean[c] += pixel[c] / 4;
        }
        // Within sRGB, whose borders the screen's picture is clamped to.
        const color::Rgb linear = color::linear_of_xyz(color::to_xyz((*wanted)[k]));
        const auto [least, most] = std::minmax_element(linear.begin(), linear.end());
        if (*least < 0 || *most > 1) continue;
        const double difference =
            color::ciede2000((*wanted)[k], color::to_lab(color::xyz_of_linear(mean)));
        // A quarter of a patch has some 160 voxels, whose means are off by 0.02 as above.
        EXPECT_LT(difference, 4) << "patch " << k + 1;
        differences += difference;
    }
    EXPECT_LT(differences / static_cast<double>(wanted->size()), 1);
    const Outcome fine = openfab(folder, {"color", "proof", "chart.ofr", "printer.icc", "-o",
                                          "p.png", "--window", "0.01mm"});
    EXPECT_EQ(fine.exit_code, 1);
    EXPECT_THAT(fine.err, testing::Says(color::messages::kWindowTooSmall, "0.01", "chart.ofr"));
    const Outcome three =
        openfab(folder, {"color", "proof", "chart.ofr", kTable, "printer.icc", "-o", "p.png"});
    EXPECT_EQ(three.exit_code, 2);
    EXPECT_THAT(three.err, testing::Says(color::messages::kProofOfPrint));
    const Outcome two = openfab(folder, {"color", "proof", "a.png", kTable, "-o", "p.png"});
    EXPECT_EQ(two.exit_code, 2);
}

TEST(ColorCommand, RefusesWhatItCannotUse) {
    const ScratchFolder folder;
    folder.write("no.icc", "this is no profile");
    folder.write("few.csv", "CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n0,0,0,0,95,0,0\n");
    folder.write("amounts.csv", "CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LCH_L,LCH_C,LCH_H\n0,0,0,0,95,0,0\n");
    struct Refused {
        std::vector<std::string> arguments;
        std::string message;
    };
    const Refused kRefused[] = {
        {{"bake", "no.icc", "-o", "inks.nrrd"},
         fmt::format(color::messages::kCannotReadBefore, "no.icc") +
             fmt::format(color::messages::kNotIcc, "{}")},
        {{"bake", "none.icc", "-o", "inks.nrrd"},
         fmt::format(color::messages::kCannotReadBefore, "none.icc")},
        {{"profile", "few.csv", "-o", "a.icc"},
         "few.csv: " + fmt::format(color::messages::kPatchCount, 1, "{}", "{}")},
        {{"measurements", "amounts.csv", "-o", "a.txt"},
         fmt::format(color::messages::kNoColours, "amounts.csv")},
        {{"simulate", "few.csv", "few.csv", "-o", "a.txt"},
         fmt::format(color::messages::kUnknownMaterial, "CMYK_C")},
        {{"read", "no.icc", "few.csv", "-o", "a.txt"}, color::messages::kPatchLayoutUnknown},
        {{"proof", "few.csv", kTable, "no.icc", "-o", "a.png"},
         tools::messages::kNotASupportedPicture},
    };
    for (const Refused& refused : kRefused) {
        std::vector<std::string> arguments = refused.arguments;
        arguments.insert(arguments.begin(), "color");
        const Outcome outcome = openfab(folder, arguments);
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, testing::Says(refused.message));
    }
    // Outputs that would replace what they are made of.
    folder.write("chart.txt", "a chart");
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"profile", "few.csv", "-o", "few.csv"},
             {"bake", "no.icc", "-o", "./no.icc"},
             {"simulate", "few.csv", "chart.txt", "-o", "chart.txt"},
             {"read", "few.csv", "chart.txt", "-o", "few.csv"},
             {"proof", "few.csv", "chart.txt", "no.icc", "-o", "no.icc"},
             {"check", "few.csv", "chart.txt", "no.icc", "-o", "chart.txt"}}) {
        std::vector<std::string> whole = arguments;
        whole.insert(whole.begin(), "color");
        const Outcome outcome = openfab(folder, whole);
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, Says(program::messages::kWhichIsAnInput)) << arguments[0];
    }
    ASSERT_EQ(openfab(folder, {"color", "chart", "-o", "chart"}).exit_code, 0);
    folder.write("small.ppm", "P3 3 2 255 " + std::string("9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9"));
    const Outcome small =
        openfab(folder, {"color", "read", "small.ppm", "chart/chart.txt", "-o", "s.ti3"});
    EXPECT_EQ(small.exit_code, 1);
    EXPECT_THAT(small.err, testing::Says(color::messages::kPatchesTooSmall, "*", "*", "4"));
    const Outcome again = openfab(folder, {"color", "chart", "-o", "chart"});
    EXPECT_EQ(again.exit_code, 1);
    EXPECT_THAT(again.err, testing::Says(color::messages::kFolderExists, "chart/chart.fab.json"));
    const Outcome unknown =
        openfab(folder, {"color", "bake", "no.icc", "-o", "a", "--intent", "x"});
    EXPECT_EQ(unknown.exit_code, 2) << unknown.err;
}

}  // namespace
}  // namespace openfab::testing
