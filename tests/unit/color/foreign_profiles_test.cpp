// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Profiles that other programs make, and those that are none.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/color.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/saved_profile.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/messages.h"
#include "tools/color/profile.h"

namespace openfab::color {
namespace {

using openfab::testing::random_inks;
using openfab::testing::saved;

std::vector<uint8_t> bytes_of_text(const std::string& text) {
    return {text.begin(), text.end()};
}

/// A printer whose black makes it dark, down to L = 20, and whose other inks are the axes of Lab: what it
/// prints is linear in its inks, so that tables are exact but for their bits.
namespace axes_printer {
constexpr double kDarkest = 20;
Lab print(const Inks& inks) {
    return {100 - (100 - kDarkest) * inks[3], 100 * (inks[1] - inks[0]), 100 * inks[2]};
}
/// Of a table with Lab in the encoding of its type: lut16 has that of version 2, lut8 the later one.
template <bool kEight>
int to_colour(const cmsUInt16Number in[], cmsUInt16Number out[], void*) {
    Inks inks;
    for (size_t i = 0; i < inks.size(); ++i)
        inks[i] = in[i] / 65535.0;
    const Lab lab = print(inks);
    const cmsCIELab encoded{lab.l, lab.a, lab.b};
    (kEight ? cmsFloat2LabEncoded : cmsFloat2LabEncodedV2)(out, &encoded);
    return 1;
}
template <bool kEight>
int to_inks(const cmsUInt16Number in[], cmsUInt16Number out[], void*) {
    cmsCIELab lab;
    (kEight ? cmsLabEncoded2Float : cmsLabEncoded2FloatV2)(&lab, in);
    const Inks inks{-lab.a / 100, lab.a / 100, lab.b / 100, (100 - lab.L) / (100 - kDarkest)};
    for (size_t i = 0; i < inks.size(); ++i)
        out[i] = static_cast<cmsUInt16Number>(std::lround(std::clamp(inks[i], 0.0, 1.0) * 65535));
    return 1;
}
void add_table(cmsHPROFILE profile, cmsTagSignature tag, bool eight, int in, int out, int nodes,
               cmsSAMPLER16 sampler) {
    cmsPipeline* table = cmsPipelineAlloc(nullptr, static_cast<cmsUInt32Number>(in),
                                          static_cast<cmsUInt32Number>(out));
    cmsStage* clut = cmsStageAllocCLut16bit(nullptr, static_cast<cmsUInt32Number>(nodes),
                                            static_cast<cmsUInt32Number>(in),
                                            static_cast<cmsUInt32Number>(out), nullptr);
    EXPECT_TRUE(cmsStageSampleCLut16bit(clut, sampler, nullptr, 0));
    // Straight curves around it, which the library does not write by itself for 8 bits.
    const auto curves = [](int count) {
        return cmsStageAllocToneCurves(nullptr, static_cast<cmsUInt32Number>(count), nullptr);
    };
    EXPECT_TRUE(cmsPipelineInsertStage(table, cmsAT_END, curves(in)));
    EXPECT_TRUE(cmsPipelineInsertStage(table, cmsAT_END, clut));
    EXPECT_TRUE(cmsPipelineInsertStage(table, cmsAT_END, curves(out)));
    cmsPipelineSetSaveAs8bitsFlag(table, eight);
    EXPECT_TRUE(cmsWriteTag(profile, tag, table));
    cmsPipelineFree(table);
}
/// Version 2, with one table each way, as older programs make profiles.
template <bool kEight>
std::vector<uint8_t> profile() {
    cmsHPROFILE out = cmsCreateProfilePlaceholder(nullptr);
    cmsSetProfileVersion(out, 2.1);
    cmsSetDeviceClass(out, cmsSigOutputClass);
    cmsSetColorSpace(out, cmsSigCmykData);
    cmsSetPCS(out, cmsSigLabData);
    EXPECT_TRUE(cmsWriteTag(out, cmsSigMediaWhitePointTag, cmsD50_XYZ()));
    add_table(out, cmsSigAToB0Tag, kEight, 4, 3, 5, to_colour<kEight>);
    add_table(out, cmsSigBToA0Tag, kEight, 3, 4, 33, to_inks<kEight>);
    return saved(out);
}
}  // namespace axes_printer

TEST(ForeignProfiles, OfVersionTwoWithTablesOfEightAndSixteenBitsAreRead) {
    for (const bool eight : {false, true}) {
        SCOPED_TRACE(eight);
        const std::vector<uint8_t> bytes =
            eight ? axes_printer::profile<true>() : axes_printer::profile<false>();
        const std::string text(bytes.begin(), bytes.end());
        EXPECT_EQ(text.find("mft1") != std::string::npos, eight) << "it is lut8Type";
        EXPECT_EQ(text.find("mft2") != std::string::npos, !eight) << "it is lut16Type";
        const Result<PrinterProfile> profile = PrinterProfile::parse(bytes);
        ASSERT_TRUE(profile) << profile.error().text();
        // 8 bits are steps of 0.4 in L and 1 in a and b, of inks and of colours.
        const double near = eight ? 1.5 : 0.05;
        std::mt19937 random(5);
        std::vector<Inks> inks;
        for (int i = 0; i < 200; ++i)
            inks.push_back(random_inks(&random));
        const Result<std::vector<Lab>> labs = profile->to_lab(inks, false);
        ASSERT_TRUE(labs);
        for (size_t i = 0; i < inks.size(); ++i) {
            const Lab wanted = axes_printer::print(inks[i]);
            EXPECT_NEAR((*labs)[i].l, wanted.l, near);
            EXPECT_NEAR((*labs)[i].a, wanted.a, near);
            EXPECT_NEAR((*labs)[i].b, wanted.b, near);
        }
        // Colours that it can print come back, by the one table that there is for all intents.
        const std::vector<Rgb> colours = {{1, 1, 1},       {0.5, 0.5, 0.5}, {0.8, 0.6, 0.3},
                                          {0.4, 0.7, 0.2}, {0.9, 0.4, 0.4}, {0.3, 0.3, 0.3}};
        for (const Intent intent : {Intent::kPerceptual, Intent::kRelative, Intent::kSaturation}) {
            const Result<std::vector<Inks>> separated = profile->to_inks(colours, intent, false);
            ASSERT_TRUE(separated) << separated.error().text();
            for (size_t i = 0; i < colours.size(); ++i) {
                Rgb linear;
                for (size_t c = 0; c < 3; ++c)
                    linear[c] = srgb_to_linear(colours[i][c]);
                const Lab wanted = to_lab(xyz_of_linear(linear));
                const Lab is = axes_printer::print((*separated)[i]);
                EXPECT_LT(std::hypot(is.l - wanted.l, is.a - wanted.a, is.b - wanted.b),
                          eight ? 2 : 0.5)  // white is clamped between two nodes
                    << "colour " << i;
            }
        }
    }
}

TEST(ForeignProfiles, BlackPointCompensationScalesLight) {
    const Result<PrinterProfile> profile = PrinterProfile::parse(axes_printer::profile<false>());
    ASSERT_TRUE(profile);
    const auto y_of = [](double l) { return std::pow((l + 16) / 116, 3); };
    const std::vector<Rgb> greys = {
        {0, 0, 0}, {0.2, 0.2, 0.2}, {0.28, 0.28, 0.28}, {0.6, 0.6, 0.6}};
    for (const bool black_point : {false, true}) {
        const Result<std::vector<Inks>> inks =
            profile->to_inks(greys, Intent::kRelative, black_point);
        ASSERT_TRUE(inks);
        for (size_t i = 0; i < greys.size(); ++i) {
            // Linear between the darkest that the printer has and white; else what is darker is clipped.
            const double light = srgb_to_linear(greys[i][0]),
                         darkest = y_of(axes_printer::kDarkest);
            const double wanted =
                black_point ? darkest + (1 - darkest) * light : std::max(light, darkest);
            EXPECT_NEAR(y_of(axes_printer::print((*inks)[i]).l), wanted, 0.004) << "grey " << i;
        }
    }
}

TEST(ForeignProfiles, AreRefusedWithWhatTheyAre) {
    const auto message = [](cmsHPROFILE profile) {
        const Result<PrinterProfile> parsed = PrinterProfile::parse(saved(profile));
        return parsed ? std::string("it was taken") : parsed.error().text();
    };
    EXPECT_THAT(message(cmsCreate_sRGBProfile()),
                testing::Says(messages::kProfileIs, messages::kDisplayProfile));
    EXPECT_THAT(message(cmsCreateLab4Profile(nullptr)),
                testing::Says(messages::kProfileIs, messages::kAbstractProfile));
    EXPECT_THAT(message(cmsCreateInkLimitingDeviceLink(cmsSigCmykData, 200)),
                testing::Says(messages::kProfileIs, messages::kDeviceLink));
    EXPECT_THAT(message(cmsCreateLab2Profile(nullptr)),
                testing::Says(messages::kProfileIs, messages::kAbstractProfile));
    cmsHPROFILE named = cmsCreateProfilePlaceholder(nullptr);
    cmsSetDeviceClass(named, cmsSigNamedColorClass);
    cmsSetColorSpace(named, cmsSigCmykData);
    cmsSetPCS(named, cmsSigLabData);
    EXPECT_THAT(message(named), testing::Says(messages::kProfileIs, messages::kNamedColours));
    cmsHPROFILE rgb = cmsCreateProfilePlaceholder(nullptr);
    cmsSetDeviceClass(rgb, cmsSigOutputClass);
    cmsSetColorSpace(rgb, cmsSigRgbData);
    cmsSetPCS(rgb, cmsSigLabData);
    EXPECT_THAT(message(rgb), testing::Says(messages::kPrinterOfSpace, "RGB"));
    cmsHPROFILE empty = cmsCreateProfilePlaceholder(nullptr);
    cmsSetDeviceClass(empty, cmsSigOutputClass);
    cmsSetColorSpace(empty, cmsSigCmykData);
    cmsSetPCS(empty, cmsSigLabData);
    EXPECT_THAT(message(empty), testing::Says(messages::kNoTables));
    EXPECT_THAT(PrinterProfile::parse({}).error().text(), testing::Says(messages::kNotIcc));
    EXPECT_THAT(PrinterProfile::parse(bytes_of_text(std::string(500, 'x'))).error().text(),
                testing::Says(messages::kNotIcc));
    EXPECT_THAT(PrinterProfile::read("/nowhere/a.icc").error().text(),
                testing::Says(messages::kCannotReadBefore, "/nowhere/a.icc"));
}

}  // namespace
}  // namespace openfab::color
