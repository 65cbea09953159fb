// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pictures by their own profiles, as textures and for proofs.

#include "tools/texture/embedded_profile.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <vector>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/saved_profile.h"
#include "tools/color/picture.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using openfab::testing::saved;

/// Adobe RGB (1998): its primaries, D65, a power of 563 / 256.
std::vector<uint8_t> adobe_rgb() {
    const cmsCIExyY white{0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1}, {0.21, 0.71, 1}, {0.15, 0.06, 1}};
    cmsToneCurve* const power = cmsBuildGamma(nullptr, 563.0 / 256);
    const std::array<cmsToneCurve*, 3> curves = {power, power, power};
    cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves.data());
    cmsFreeToneCurve(power);
    return saved(profile);
}

TEST(EmbeddedProfile, SrgbIsTakenByItsFormula) {
    const EmbeddedProfile::Found found = EmbeddedProfile::find(saved(cmsCreate_sRGBProfile()));
    EXPECT_TRUE(found.is_srgb);
    EXPECT_EQ(found.other, nullptr);
}

TEST(EmbeddedProfile, WiderPrimariesGoBeyondSrgb) {
    const EmbeddedProfile::Found found = EmbeddedProfile::find(adobe_rgb());
    ASSERT_NE(found.other, nullptr);
    const std::array<float, 3> green = {0, 1, 0}, grey = {0.5f, 0.5f, 0.5f};
    std::array<float, 3> out{};
    found.other->decode(green.data(), out.data());
    // Its green in linear sRGB, from the two sets of primaries: (-0.3984, 1, -0.0429).
    EXPECT_NEAR(out[0], -0.3984, 2e-3);
    EXPECT_NEAR(out[1], 1.0, 2e-3);
    EXPECT_NEAR(out[2], -0.0429, 2e-3);
    found.other->decode(grey.data(), out.data());
    for (const float channel : out) {
        EXPECT_NEAR(channel, std::pow(0.5, 563.0 / 256), 1e-3);
        EXPECT_EQ(channel * 65536, std::round(channel * 65536));
    }
}

TEST(EmbeddedProfile, WhatIsDamagedOrOfOtherSpacesSaysNothing) {
    std::vector<uint8_t> bytes = adobe_rgb();
    for (const auto& wrong : {std::vector<uint8_t>{}, std::vector<uint8_t>(100, 7),
                              std::vector<uint8_t>(bytes.begin(), bytes.begin() + 200),
                              saved(cmsCreateLab4Profile(nullptr))}) {
        const EmbeddedProfile::Found found = EmbeddedProfile::find(wrong);
        EXPECT_FALSE(found.is_srgb);
        EXPECT_EQ(found.other, nullptr);
    }
}

TEST(EmbeddedProfile, PicturesAreReadByTheirs) {
    const openfab::testing::TempFolder folder;
    const std::string file = (folder.path() / "green.png").string();
    const auto write = [&](const std::vector<uint8_t>& icc) {
        OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::UINT8);
        if (!icc.empty()) {
            spec.attribute("ICCProfile",
                           OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                           icc.data());
        }
        const std::array<uint8_t, 6> pixels = {0, 255, 0, 128, 128, 128};
        auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(out->open(file, spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
        ASSERT_TRUE(out->close());
    };
    write({});
    const Result<color::Picture> plain = color::Picture::read(file);
    ASSERT_TRUE(plain) << plain.error().text();
    EXPECT_NEAR(plain->at(1, 0)[0], srgb_to_linear(128.0 / 255), 1e-6);
    EXPECT_EQ(plain->at(0, 0)[0], 0);
    write(adobe_rgb());
    const Result<color::Picture> wide = color::Picture::read(file);
    ASSERT_TRUE(wide) << wide.error().text();
    EXPECT_NEAR(wide->at(0, 0)[0], -0.3984, 2e-3);
    EXPECT_NEAR(wide->at(1, 0)[0], std::pow(128.0 / 255, 563.0 / 256), 1e-3);
    EXPECT_EQ(wide->note(), "");
}

// `color read` takes photographs and scans as they are without a profile that is of other colours than theirs.
TEST(EmbeddedProfile, OneThatIsNotUsedIsTold) {
    const openfab::testing::TempFolder folder;
    for (const std::string name : {"a.tif", "a.jpg"}) {
        const std::string file = (folder.path() / name).string();
        const std::vector<uint8_t> icc = saved(cmsCreateInkLimitingDeviceLink(cmsSigCmykData, 300));
        OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT8);
        spec.attribute("ICCProfile",
                       OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                       icc.data());
        const std::array<uint8_t, 3> pixel = {128, 128, 128};
        auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(out->open(file, spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixel.data()));
        ASSERT_TRUE(out->close());
        const Result<color::Picture> picture = color::Picture::read(file);
        ASSERT_TRUE(picture) << picture.error().text();
        EXPECT_THAT(picture->note(), openfab::testing::Says(messages::kProfileUnused)) << name;
    }
}

}  // namespace
}  // namespace openfab::tools
