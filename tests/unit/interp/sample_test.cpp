// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

using interp::sample;
using interp::SampleArgs;

constexpr int32_t kClamp = 0, kRepeat = 1, kMirror = 2, kBlack = 3;
constexpr int32_t kOwn = ir::kOwnColor;
constexpr int32_t kTrilinear = 0, kAnisotropic = 1, kNearest = 2;

SampleArgs at(float u, float v, float width = 0) {
    SampleArgs args;
    args.u = u;
    args.v = v;
    args.width = width;
    return args;
}

/// 4 x 1: values 0, 1, 2, 3.
Picture ramp(int32_t wrap, int32_t filter = kTrilinear) {
    return {4, 1, 1, {0, 1, 2, 3}, wrap, filter};
}

TEST(Sample, TexelCentresGiveTexels) {
    const Picture p(2, 2, 1, {1, 2, 3, 4}, kClamp, kTrilinear);
    EXPECT_EQ(sample(p.view(), 0, at(0.25f, 0.25f)), 1);  // v = 0 is the bottom row, the first
    EXPECT_EQ(sample(p.view(), 0, at(0.75f, 0.25f)), 2);
    EXPECT_EQ(sample(p.view(), 0, at(0.25f, 0.75f)), 3);
    EXPECT_EQ(sample(p.view(), 0, at(0.5f, 0.5f)), 2.5f);
}

TEST(Sample, WrapModes) {
    EXPECT_EQ(sample(ramp(kClamp).view(), 0, at(-5, 0.5f)), 0);
    EXPECT_EQ(sample(ramp(kClamp).view(), 0, at(5, 0.5f)), 3);
    EXPECT_EQ(sample(ramp(kRepeat).view(), 0, at(0, 0.5f)), 1.5f);  // half of 3, half of 0
    EXPECT_EQ(sample(ramp(kRepeat).view(), 0, at(1.375f, 0.5f)), 1);
    EXPECT_EQ(sample(ramp(kRepeat).view(), 0, at(-0.625f, 0.5f)), 1);
    EXPECT_EQ(sample(ramp(kMirror).view(), 0, at(-0.375f, 0.5f)), 1);
    EXPECT_EQ(sample(ramp(kMirror).view(), 0, at(1.125f, 0.5f)), 3);
    EXPECT_EQ(sample(ramp(kMirror).view(), 0, at(2.375f, 0.5f)), 1);
    EXPECT_EQ(sample(ramp(kMirror).view(), 0, at(1, 0.5f)), 3);
    EXPECT_EQ(sample(ramp(kBlack).view(), 0, at(1, 0.5f)), 1.5f);
    EXPECT_EQ(sample(ramp(kBlack).view(), 0, at(1.5f, 0.5f)), 0);
}

TEST(Sample, EachAxisHasItsOwnWrap) {
    Picture p(2, 2, 1, {1, 2, 3, 4}, kRepeat, kTrilinear);
    p.info[5] = kClamp;
    EXPECT_EQ(sample(p.view(), 0, at(1.25f, -3)), 1);
    EXPECT_EQ(sample(p.view(), 0, at(-0.25f, 7)), 4);
    p.info[5] = kBlack;
    EXPECT_EQ(sample(p.view(), 0, at(1.25f, 0)), 0.5f);
    EXPECT_EQ(sample(p.view(), 0, at(1.25f, -3)), 0);
}

// Opaque red beside half of green, as they look on white: the colour itself is that of premultiplied
// ones.
TEST(Sample, AlphaWeighsColors) {
    Picture p(2, 1, 4, {1, 0, 0, 1, 0.5f, 1, 0.5f, 0.5f}, kClamp, kTrilinear);
    p.info[6] = 1;
    const auto look = [&](int32_t channel, float u) {
        return sample(p.view(), channel, at(u, 0.5f));
    };
    EXPECT_EQ(look(0, 0.75f), 0.5f);
    EXPECT_EQ(look(kOwn, 0.75f), 0);
    EXPECT_EQ(look(kOwn + 1, 0.75f), 1);
    EXPECT_EQ(look(3, 0.5f), 0.75f);
    EXPECT_EQ(look(0, 0.5f), 0.75f);
    EXPECT_FLOAT_EQ(look(kOwn, 0.5f), 2.0f / 3);
    EXPECT_FLOAT_EQ(look(kOwn + 1, 0.5f), 1.0f / 3);
    EXPECT_EQ(look(kOwn + 2, 0.5f), 0);
    // Beyond, nothing is there.
    p.info[2] = p.info[5] = kBlack;
    for (const int32_t channel : {kOwn, kOwn + 1, kOwn + 2, 3})
        EXPECT_EQ(look(channel, 5), 0);
    EXPECT_EQ(look(0, 5), 1) << "nothing looks white";
    EXPECT_EQ(look(3, 0), 0.5f);
    EXPECT_EQ(look(kOwn, 0), 1) << "no dark fringe";
}

TEST(Sample, GreyWithAlphaIsGrey) {
    Picture p(1, 1, 2, {0.75f, 0.5f}, kClamp, kTrilinear);
    p.info[6] = 1;
    for (int32_t c : {0, 1, 2}) {
        EXPECT_EQ(sample(p.view(), c, at(0, 0)), 0.75f);
        EXPECT_EQ(sample(p.view(), kOwn + c, at(0, 0)), 0.5f);
    }
    EXPECT_EQ(sample(p.view(), 3, at(0, 0)), 0.5f);
}

TEST(Sample, BlackIsNothingToWhoReadsAlpha) {
    const Picture p = {2, 1, 3, {0.5f, 0.25f, 1, 0.5f, 0.25f, 1}, kBlack, kTrilinear};
    const auto look = [&](int32_t channel, float u) {
        return sample(p.view(), channel, at(u, 0.5f));
    };
    EXPECT_EQ(look(3, 0.5f), 1);
    EXPECT_EQ(look(kOwn + 1, 0.5f), 0.25f);
    EXPECT_EQ(look(3, 1), 0.5f);
    EXPECT_EQ(look(kOwn + 1, 1), 0.25f);
    EXPECT_EQ(look(1, 1), 0.125f);
    for (const int32_t channel : {kOwn, kOwn + 1, kOwn + 2, 0, 1, 2, 3})
        EXPECT_EQ(look(channel, 1.5f), 0);
}

TEST(Sample, NearestFilterTakesTheTexelItIsIn) {
    EXPECT_EQ(sample(ramp(kClamp, kNearest).view(), 0, at(0.49f, 0.5f)), 1);
    EXPECT_EQ(sample(ramp(kClamp, kNearest).view(), 0, at(0.51f, 0.5f)), 2);
    EXPECT_EQ(sample(ramp(kClamp, kNearest).view(), 0, at(1, 0.5f)), 3);
    EXPECT_EQ(sample(ramp(kRepeat, kNearest).view(), 0, at(-0.01f, 0.5f)), 3);
    EXPECT_EQ(sample(ramp(kBlack, kNearest).view(), 0, at(-0.01f, 0.5f)), 0);
}

TEST(Sample, ChannelsThatAreNotThere) {
    const Picture grey(1, 1, 1, {0.5f}, kClamp, kTrilinear);
    for (int32_t c : {0, 1, 2})
        EXPECT_EQ(sample(grey.view(), c, at(0, 0)), 0.5f);
    EXPECT_EQ(sample(grey.view(), 3, at(0, 0)), 1);
    EXPECT_EQ(sample(grey.view(), 4, at(0, 0)), 0);
    const Picture rgb(1, 1, 3, {0.1f, 0.2f, 0.3f}, kClamp, kTrilinear);
    EXPECT_EQ(sample(rgb.view(), 2, at(0, 0)), 0.3f);
    EXPECT_EQ(sample(rgb.view(), 3, at(0, 0)), 1);
}

TEST(Sample, LevelsFollowTheFootprint) {
    // A checkerboard of single texels: from level 1 on it is 0.5 everywhere.
    std::vector<float> checks(64);
    for (int i = 0; i < 64; ++i)
        checks[i] = static_cast<float>((i + i / 8) % 2);
    const Picture p(8, 8, 1, checks, kRepeat, kTrilinear);
    SampleArgs args = at(0.0625f, 0.0625f, 1);
    EXPECT_EQ(sample(p.view(), 0, args), 0);
    args.du[0] = args.dv[1] = 1.0f / 8;  // one texel
    EXPECT_EQ(sample(p.view(), 0, args), 0);
    args.du[0] = args.dv[1] = 2.0f / 8;
    EXPECT_EQ(sample(p.view(), 0, args), 0.5f);
    args.width = 0.5f;
    EXPECT_EQ(sample(p.view(), 0, args), 0);
    args.width = 1;
    args.du[0] = args.dv[1] = 1.5f / 8;  // between the levels
    EXPECT_NEAR(sample(p.view(), 0, args), 0.5f * std::log2(1.5f), 1e-4f);
    args.du[0] = args.dv[1] = 1000;
    EXPECT_EQ(sample(p.view(), 0, args), 0.5f);
}

TEST(Sample, AnisotropyKeepsWhatLiesAcross) {
    // Stripes along u: a footprint elongated along them must not blur them; an isotropic one does.
    std::vector<float> stripes(16 * 16);
    for (size_t i = 0; i < stripes.size(); ++i)
        stripes[i] = static_cast<float>(i / 16 % 2);
    SampleArgs args = at(0.5f, 0.5f / 16, 1);
    args.du[0] = 8.0f / 16;
    args.dv[1] = 1.0f / 16;
    EXPECT_EQ(sample(Picture(16, 16, 1, stripes, kRepeat, kAnisotropic).view(), 0, args), 0);
    EXPECT_EQ(sample(Picture(16, 16, 1, stripes, kRepeat, kTrilinear).view(), 0, args), 0.5f);
}

TEST(Sample, TapsLieAlongTheMajorAxisAlsoWhereItIsOblique) {
    // A valley along one diagonal: a footprint elongated along it samples its floor; one across it
    // the slopes.
    for (const float sign : {1.0f, -1.0f}) {
        std::vector<float> valley(64 * 64);
        for (size_t i = 0; i < valley.size(); ++i) {
            const float x = static_cast<float>(i % 64) - 31.5f;
            const float y = static_cast<float>(i / 64) - 31.5f;
            valley[i] = (x - sign * y) * (x - sign * y);
        }
        const Picture p(64, 64, 1, valley, kClamp, kAnisotropic);
        SampleArgs args = at(0.5f, 0.5f, 1);
        args.du[1] = 6.0f / 64;
        args.dv[1] = sign * 6.0f / 64;
        EXPECT_LT(sample(p.view(), 0, args), 2);
        args.dv[1] = -sign * 6.0f / 64;
        EXPECT_GT(sample(p.view(), 0, args), 8);
    }
}

TEST(Sample, Log2IsExactAtPowersOfTwoAndCloseBetween) {
    for (int e = 0; e < 30; ++e)
        EXPECT_EQ(interp::log2_of(std::ldexp(1.0f, e)), static_cast<float>(e));
    for (float x = 1; x < 1000; x *= 1.001f) {
        EXPECT_NEAR(interp::log2_of(x), std::log2(static_cast<double>(x)), 6e-5) << x;
    }
    EXPECT_EQ(interp::log2_of(0.5f), 0);
    EXPECT_EQ(interp::log2_of(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Sample, AnyInputStaysInsideTheTextureAndItsRange) {
    const float odd[] = {0,
                         -0.0f,
                         1,
                         -1,
                         0.5f,
                         1e-30f,
                         1e30f,
                         -1e30f,
                         1e38f,
                         3e9f,
                         -3e9f,
                         std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity(),
                         std::numeric_limits<float>::quiet_NaN()};
    std::mt19937 random(7);
    const auto pick = [&] { return odd[random() % std::size(odd)]; };
    for (int32_t wrap = 0; wrap < 4; ++wrap) {
        for (int32_t filter = 0; filter < 3; ++filter) {
            const Picture p(5, 3, 1, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}, wrap, filter);
            for (int i = 0; i < 3000; ++i) {
                SampleArgs args = at(pick(), pick(), pick());
                for (size_t k = 0; k < 3; ++k) {
                    args.du[k] = pick();
                    args.dv[k] = pick();
                }
                const float value = sample(p.view(), 0, args);
                EXPECT_TRUE(value >= 0 && value <= 1) << value;
                if (wrap != kBlack) {
                    EXPECT_EQ(value, 1);
                }
            }
        }
    }
}

}  // namespace
}  // namespace openfab::testing
