// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of kinds of pictures share: bytes of files, profiles, and the texels that become of them.

#include <gtest/gtest.h>
#include <lcms2.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "texture/pyramid.h"
#include "tools/texture/convert.h"

namespace openfab::tools {

using texture::Pyramid;
using Bytes = std::string;

inline Bytes big(uint64_t value, int bytes) {
    Bytes out;
    for (int k = bytes; k-- > 0;)
        out += static_cast<char>(value >> 8 * k & 0xff);
    return out;
}

inline Bytes little(uint64_t value, int bytes) {
    const Bytes reversed = big(value, bytes);
    return {reversed.rbegin(), reversed.rend()};
}

inline Bytes saved(cmsHPROFILE profile) {
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(profile, nullptr, &size);
    Bytes out(size, '\0');
    cmsSaveProfileToMem(profile, out.data(), &size);
    cmsCloseProfile(profile);
    return out;
}

inline Bytes grey_profile(double gamma) {
    cmsToneCurve* const curve = cmsBuildGamma(nullptr, gamma);
    cmsHPROFILE profile = cmsCreateGrayProfile(cmsD50_xyY(), curve);
    cmsFreeToneCurve(curve);
    return saved(profile);
}

inline double srgb(double v) {
    return srgb_to_linear(v);
}

class PictureKinds : public ::testing::Test {
  protected:
    /// The texels of level 0, after checking how many channels there are.
    std::vector<float> texels(const Bytes& file, int channels, const std::string& space = "auto") {
        return texels_of(folder_.write("picture", file), channels, space);
    }

    std::vector<float> texels_of(const std::filesystem::path& file, int channels,
                                 const std::string& space = "auto") {
        const std::filesystem::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_pyramid_file(file, out, {space, false});
        EXPECT_TRUE(made) << made.error().text();
        const auto opened = Pyramid::open(out, 0, 0);
        if (!made || !opened) return std::vector<float>(64, NAN);
        EXPECT_EQ((*opened)->channels(), channels);
        has_alpha_ = (*opened)->info()[texture::kInfoAlpha] != 0;
        return {(*opened)->texels().begin(), (*opened)->texels().end()};
    }

    void expect_colors(const Bytes& file, const std::array<double, 3>& want,
                       double tolerance = 2e-5) {
        const std::vector<float> got = texels(file, 3);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(got[c], want[c], tolerance) << "channel " << c;
    }

    testing::TempFolder folder_;
    bool has_alpha_ = false;
};

}  // namespace openfab::tools
