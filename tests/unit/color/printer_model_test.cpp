// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A model fitted to a chart against the printer that the chart came from.

#include "tools/color/printer_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/says/says.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/least_squares.h"
#include "tools/color/messages.h"

namespace openfab::color {
namespace {

using openfab::testing::random_inks;
using openfab::testing::SyntheticPrinter;
using ::testing::HasSubstr;

TEST(NominalInks, ThickAndThinLayersAreKubelkasAndMunks) {
    // Equal inks: any mixture is the same material, and white over white is as thick as light goes.
    std::string table;
    for (const char* name : {"cyan", "magenta", "yellow", "black", "white"})
        table += std::string(name) + ",0.3,0.3,0.3,2,2,2\n";
    const Result<NominalInks> inks = NominalInks::parse(table);
    ASSERT_TRUE(inks) << inks.error().text();
    // K / S = 2 0.3 / (0.75 2) = 0.4: R = 1.4 - sqrt(1.4^2 - 1) = 0.42020; Saunderson's correction:
    // 0.96 0.4 0.42020 / (1 - 0.6 0.42020) = 0.21573; L* = 116 cbrt(0.21573) - 16 = 53.57.
    EXPECT_NEAR(inks->predict({0.2, 0.1, 0.3, 0.1}, 0.5).l, 53.57, 0.01);
    EXPECT_NEAR(inks->predict({}, 3).l, 53.57, 0.01);
    EXPECT_THAT(NominalInks::parse("cyan,1,2,3,4,5\n").error().text(),
                testing::Says(messages::kNotSevenValues, "6"));
    EXPECT_THAT(NominalInks::parse("pink,1,2,3,4,5,6\n").error().text(),
                testing::Says(messages::kUnknownMaterial, "pink"));
    EXPECT_THAT(NominalInks::parse("cyan,1,2,3,4,5,0\n").error().text(),
                testing::Says(messages::kNotACoefficient, "0"));
    EXPECT_THAT(NominalInks::parse("cyan,1,2,3,4,5,6\n").error().text(), HasSubstr("no `magenta`"));
}

TEST(PrinterModel, RecoversAPrinterWithDotGain) {
    for (const double gain : {0.0, 0.2}) {
        const SyntheticPrinter printer(gain);
        const Result<PrinterModel> model = PrinterModel::fit(printer.measured(0));
        ASSERT_TRUE(model) << model.error().text();
        std::mt19937 random(7);
        double sum = 0, worst = 0;
        constexpr int kTries = 1000;
        for (int i = 0; i < kTries; ++i) {
            const Inks inks = random_inks(&random);
            const double difference = ciede2000(printer.print(inks), model->predict(inks));
            sum += difference;
            worst = std::max(worst, difference);
        }
        std::printf("gain %.1f: CIEDE2000 %.2f in the mean, %.2f at worst\n", gain, sum / kTries,
                    worst);
        // Less than an eye sees in the mean; the worst lie where a trace of one ink meets another.
        EXPECT_LT(sum / kTries, 0.6) << gain;
        EXPECT_LT(worst, 10) << gain;
        // What was left out says how good it is elsewhere.
        EXPECT_NEAR(model->left_out_mean(), sum / kTries, 0.5) << gain;
    }
}

TEST(PrinterModel, NoiseIsNotFollowed) {
    const SyntheticPrinter printer(0.15);
    constexpr double kNoise = 0.4;
    const Result<PrinterModel> model = PrinterModel::fit(printer.measured(kNoise));
    ASSERT_TRUE(model) << model.error().text();
    std::mt19937 random(8);
    double sum = 0;
    constexpr int kTries = 500;
    for (int i = 0; i < kTries; ++i) {
        const Inks inks = random_inks(&random);
        sum += ciede2000(printer.print(inks), model->predict(inks));
    }
    EXPECT_LT(sum / kTries, 0.7);
}

TEST(PrinterModel, SaysWhatATableLacks) {
    SampleTable table = SyntheticPrinter(0).measured(0);
    SampleTable few = table;
    few.samples.resize(10);
    EXPECT_THAT(PrinterModel::fit(few).error().text(), HasSubstr("10 different patches"));
    SampleTable unmeasured = table;
    unmeasured.has_lab = false;
    EXPECT_THAT(PrinterModel::fit(unmeasured).error().text(),
                testing::Says(messages::kNoMeasuredPatches));
    SampleTable no_yellow = table;
    std::erase_if(no_yellow.samples, [](const Sample& s) { return s.inks[2] == 1; });
    EXPECT_THAT(PrinterModel::fit(no_yellow).error().text(),
                testing::Says(messages::kNoPatchOf, messages::kPureYellow));
    SampleTable dark = table;
    for (Sample& s : dark.samples)
        s.lab.l /= 100;
    EXPECT_THAT(PrinterModel::fit(dark).error().text(),
                testing::Says(messages::kWhitePatch, "0.9"));
}

TEST(LeastSquares, InvertsAndMinimises) {
    Square m(3);
    const double kValues[3][3] = {{4, 1, 0.5}, {1, 3, -1}, {0.5, -1, 2}};
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j)
            m.at(i, j) = kValues[i][j];
    }
    ASSERT_TRUE(invert_positive(&m));
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            double product = 0;
            for (size_t k = 0; k < 3; ++k)
                product += kValues[i][k] * m.at(k, j);
            EXPECT_NEAR(product, i == j ? 1 : 0, 1e-12);
        }
    }
    Square indefinite(2);
    indefinite.at(0, 0) = 1;
    indefinite.at(1, 1) = -1;
    EXPECT_FALSE(invert_positive(&indefinite));
    // Rosenbrock's valley, whose minimum is 0 at (1, 1).
    std::vector<double> at = {-1.2, 1};
    const double left = minimise_squares(
        [](const std::vector<double>& v, std::vector<double>* r) {
            (*r)[0] = 10 * (v[1] - v[0] * v[0]);
            (*r)[1] = 1 - v[0];
        },
        2, &at);
    EXPECT_LT(left, 1e-8);
    EXPECT_NEAR(at[0], 1, 1e-3);
}

}  // namespace
}  // namespace openfab::color
