// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Measurements that are in the wrong place, and those that are not.

#include "tools/color/patch_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/says/says.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/messages.h"

namespace openfab::color {
namespace {

using openfab::testing::SyntheticPrinter;

std::vector<std::string> warnings(const SampleTable& table) {
    const Result<PrinterModel> model = PrinterModel::fit(table);
    EXPECT_TRUE(model) << model.error().text();
    return format_patches(check_patches(table, *model), model->patches());
}

TEST(PatchCheck, NothingIsSaidOfWhatIsInLine) {
    for (const auto& [gain, noise] : {std::pair(0.0, 0.0), {0.2, 0.3}, {0.2, 0.8}})
        EXPECT_THAT(warnings(SyntheticPrinter(gain).measured(noise)), ::testing::IsEmpty())
            << gain << ", " << noise;
}

TEST(PatchCheck, WhatWasMeasuredBesideAPatchIsNamed) {
    for (const size_t at : {60u, 200u, 311u}) {
        SampleTable table = SyntheticPrinter(0.1).measured(0.2);
        const Lab right = table.samples[at].lab;
        table.samples[at].lab = {95, 0, 0};
        const Result<PrinterModel> model = PrinterModel::fit(table);
        ASSERT_TRUE(model);
        const PatchCheck check = check_patches(table, *model);
        ASSERT_EQ(check.out_of_line.size(), 1u) << at;
        EXPECT_EQ(check.out_of_line[0].id, std::to_string(at + 1));
        EXPECT_LT(ciede2000(check.out_of_line[0].predicted, right), 6);
        const std::vector<std::string> lines = format_patches(check, 355);
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_THAT(lines[0], testing::Says(messages::kPatchOutOfLine, std::to_string(at + 1),
                                            "95.0", "0.0", "0.0", "*", "*", "*", "*"));
    }
}

TEST(PatchCheck, ExchangedPatchesAndRowsAreNamed) {
    SampleTable two = SyntheticPrinter(0.1).measured(0.2);
    std::swap(two.samples[150].lab, two.samples[200].lab);
    EXPECT_THAT(warnings(two),
                ::testing::Contains(testing::Says(messages::kPatchesExchanged, "`151` and `201`")));
    // Two rows of the chart, of 20 patches.
    SampleTable rows = SyntheticPrinter(0.1).measured(0.2);
    for (size_t k = 0; k < 20; ++k)
        std::swap(rows.samples[180 + k].lab, rows.samples[200 + k].lab);
    const Result<PrinterModel> model = PrinterModel::fit(rows);
    ASSERT_TRUE(model);
    const PatchCheck check = check_patches(rows, *model);
    size_t right = 0;
    for (const auto& [a, b] : check.exchanged)
        right += std::stoi(b.id) - std::stoi(a.id) == 20 ? 1 : 0;
    // Others of the row have neighbours of their colour, or are not told from noise.
    EXPECT_GE(right, 5u);
    EXPECT_GT(2 * right, check.exchanged.size());
}

TEST(PatchCheck, ATableInAnotherOrderIsTold) {
    for (const bool reversed : {false, true}) {
        SampleTable table = SyntheticPrinter(0.1).measured(0.2);
        const SampleTable right = table;
        // From the last to the first, but for what a model needs; or one was skipped.
        for (size_t k = 40; k < 359; ++k)
            table.samples[k].lab = right.samples[reversed ? 399 - k : k + 1].lab;
        EXPECT_THAT(warnings(table), ::testing::ElementsAre(
                                         testing::Says(messages::kPatchesDisordered, "*", "355")));
    }
}

/// Measures one patch as something else; returns the warnings.
std::vector<std::string> with_one_wrong(size_t at, const Lab& measured) {
    SampleTable table = SyntheticPrinter(0.1).measured(0.2);
    table.samples[at].lab = measured;
    return warnings(table);
}

TEST(PatchCheck, PureInksRepeatedPatchesAndMixturesAreNamedAlone) {
    const SampleTable right = SyntheticPrinter(0.1).measured(0.2);
    // Cyan, magenta, yellow and black, their steps beside them, white and its repetitions, and mixtures where others are near.
    for (const size_t at : {8u, 15u, 16u, 24u, 31u, 32u, 0u, 59u, 179u, 99u, 108u, 243u, 279u}) {
        const Lab is = right.samples[at].lab;
        const bool dark = is.l < 75;
        const Lab beside = dark ? Lab{95, 0, 0} : Lab{is.l - 25, is.a + 15, is.b - 40};
        const std::vector<std::string> lines = with_one_wrong(at, beside);
        ASSERT_EQ(lines.size(), 1u) << at + 1 << ": " << (lines.empty() ? "" : lines[0]);
        EXPECT_THAT(lines[0], testing::Says(messages::kPatchOutOfLine, std::to_string(at + 1), "*",
                                            "*", "*", "*", "*", "*", "*"));
    }
    // A mixture that is off by less than where inks change fastest, but has many near it.
    const Lab grey = right.samples[99].lab;
    EXPECT_EQ(with_one_wrong(99, {grey.l, grey.a + 15, grey.b - 10}).size(), 1u);
}

TEST(PatchCheck, AWhiteOfAnotherLightIsTold) {
    SampleTable table = SyntheticPrinter(0.1).measured(0);
    for (Sample& sample : table.samples) {
        // XYZ of D65 as if they were of D50.
        const Xyz xyz = to_xyz(sample.lab);
        sample.lab = to_lab({xyz.x * 0.95047 / kD50.x, xyz.y, xyz.z * 1.08883 / kD50.z});
    }
    EXPECT_THAT(warnings(table), ::testing::Contains(testing::Says(messages::kWhiteIsTinted)));
}

}  // namespace
}  // namespace openfab::color
