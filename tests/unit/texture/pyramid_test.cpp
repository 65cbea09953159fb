// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/pyramid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "texture/messages.h"
#include "texture/pyramid_file.h"

namespace openfab::texture {
namespace {

std::vector<float> random_texels(size_t count) {
    std::mt19937 random(7);
    std::vector<float> out(count);
    for (float& v : out)
        v = static_cast<float>(random() % 1000) / 999.0f;
    return out;
}

TEST(Pyramid, HalvesPowersOfTwoByPlainMeans) {
    const std::vector<float> level0 = {0, 1, 2, 3, 4, 5, 6, 7};  // 4 x 2, bottom row first
    const auto p = Pyramid::from_texels(4, 2, 1, level0, 1, 0);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(p->levels(), 3);
    const std::span<const int32_t> info = p->info();
    const std::vector<int32_t> want = {1, 3, 1,      0, 0, 1,  0,       0, /**/ 0, 4,
                                       2, 0, /**/ 8, 2, 1, 16, /**/ 10, 1, 1,      20};
    EXPECT_EQ(std::vector<int32_t>(info.begin(), info.end()), want);
    const std::span<const float> t = p->texels();
    EXPECT_EQ(t[8], 2.5f);
    EXPECT_EQ(t[9], 4.5f);
    EXPECT_EQ(t[10], 3.5f);
    const std::span<const float> m = p->minmax();
    EXPECT_EQ(m[2], 1);
    EXPECT_EQ(m[3], 1);
    EXPECT_EQ(m[16], 0);
    EXPECT_EQ(m[17], 5);
    EXPECT_EQ(m[18], 2);
    EXPECT_EQ(m[19], 7);
    EXPECT_EQ(m[20], 0);
    EXPECT_EQ(m[21], 7);
}

TEST(Pyramid, KeepsMeansAndBoundsForOddSizes) {
    for (const auto& [width, height, channels] : {std::array<int32_t, 3>{1, 1, 1},
                                                  {3, 1, 1},
                                                  {5, 7, 3},
                                                  {13, 6, 4},
                                                  {127, 65, 2},
                                                  {1, 9, 3}}) {
        const auto texels = static_cast<size_t>(width) * static_cast<size_t>(height);
        const std::vector<float> level0 = random_texels(texels * static_cast<size_t>(channels));
        const auto p = Pyramid::from_texels(width, height, channels, level0, 0, 0);
        ASSERT_NE(p, nullptr);
        const int32_t* last =
            &p->info()[static_cast<size_t>(kInfoHeader + kInfoPerLevel * (p->levels() - 1))];
        EXPECT_EQ(last[1], 1);
        EXPECT_EQ(last[2], 1);
        for (int32_t c = 0; c < channels; ++c) {
            double sum = 0;
            float least = 1e9f;
            float greatest = -1e9f;
            for (size_t i = 0; i < texels; ++i) {
                const float v = level0[i * static_cast<size_t>(channels) + static_cast<size_t>(c)];
                sum += static_cast<double>(v);
                least = std::min(least, v);
                greatest = std::max(greatest, v);
            }
            EXPECT_NEAR(p->texels()[static_cast<size_t>(last[0] + c)],
                        sum / static_cast<double>(texels), 1e-6);
            EXPECT_EQ(p->minmax()[static_cast<size_t>(last[3] + 2 * c)], least);
            EXPECT_EQ(p->minmax()[static_cast<size_t>(last[3] + 2 * c + 1)], greatest);
        }
        // Each filtered texel lies between its bounds.
        for (size_t i = 0; i < p->texels().size(); ++i) {
            EXPECT_LE(p->minmax()[2 * i], p->texels()[i] + 1e-6f);
            EXPECT_GE(p->minmax()[2 * i + 1], p->texels()[i] - 1e-6f);
        }
    }
}

TEST(Pyramid, RefusesWhatCannotBe) {
    const std::vector<float> four(4);
    EXPECT_EQ(Pyramid::from_texels(2, 2, 2, four, 0, 0), nullptr);
    EXPECT_EQ(Pyramid::from_texels(0, 2, 2, {}, 0, 0), nullptr);
    EXPECT_FALSE(pyramid_layout(16385, 1, 1));
    EXPECT_FALSE(pyramid_layout(4, 4, 5));
    EXPECT_TRUE(pyramid_layout(16384, 16384, 3));
    EXPECT_FALSE(pyramid_layout(16384, 16384, 4));
    EXPECT_TRUE(pyramid_layout(8192, 8192, 4));
}

class PyramidFile : public ::testing::Test {
  protected:
    PyramidFile() : file_(folder_.path() / "p.oftx"), level0_(random_texels(9 * 5 * 3)) {
        auto writer = PyramidWriter::create(file_, *pyramid_layout(9, 5, 3), 42);
        EXPECT_TRUE(writer);
        std::copy(level0_.begin(), level0_.end(), (*writer)->level0());
        EXPECT_TRUE((*writer)->finish());
        std::ifstream in(file_, std::ios::binary);
        bytes_.assign(std::istreambuf_iterator<char>(in), {});
    }
    std::string error_of(const std::string& bytes) {
        const auto opened = Pyramid::open(folder_.write("q.oftx", bytes), 0, 0);
        return opened ? "no error" : opened.error().text();
    }

    testing::TempFolder folder_;
    std::filesystem::path file_;
    std::vector<float> level0_;
    std::string bytes_;
};

TEST_F(PyramidFile, HoldsTheSameBitsAsMemory) {
    const auto mapped = Pyramid::open(file_, 3, 2);
    ASSERT_TRUE(mapped) << mapped.error().text();
    const auto memory = Pyramid::from_texels(9, 5, 3, level0_, 3, 2);
    const auto equal = [](auto a, auto b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    };
    EXPECT_TRUE(equal((*mapped)->info(), memory->info()));
    EXPECT_TRUE(equal((*mapped)->texels(), memory->texels()));
    EXPECT_TRUE(equal((*mapped)->minmax(), memory->minmax()));
    // No temporary file is left.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(PyramidFile, IsRefusedWhenCutShortOrForeign) {
    ASSERT_EQ(error_of(bytes_), "no error");
    for (size_t n :
         {size_t{0}, size_t{1}, size_t{63}, size_t{64}, size_t{100}, bytes_.size() - 1}) {
        EXPECT_NE(error_of(bytes_.substr(0, n)), "no error") << n;
    }
    EXPECT_THAT(error_of(bytes_ + "x"), testing::Says(messages::kFileCutShort));
    EXPECT_THAT(error_of("\x89PNG\r\n\x1a\n" + std::string(100, 'x')),
                testing::Says(messages::kNotPyramid));
    EXPECT_FALSE(Pyramid::open(folder_.path(), 0, 0));
    EXPECT_FALSE(Pyramid::open(folder_.path() / "none.oftx", 0, 0));
    // Every byte is covered by the checksum, including texels.
    for (size_t i = 0; i < bytes_.size(); ++i) {
        std::string damaged = bytes_;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x15);
        EXPECT_NE(error_of(damaged), "no error") << i;
    }
}

TEST_F(PyramidFile, IsNotLeftBehindUnfinished) {
    { auto writer = PyramidWriter::create(folder_.path() / "x.oftx", *pyramid_layout(4, 4, 1), 1); }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
    EXPECT_FALSE(
        PyramidWriter::create(folder_.path() / "none" / "x.oftx", *pyramid_layout(4, 4, 1), 1));
}

TEST(Color, WeighsLuminanceAsRec709) {
    EXPECT_EQ(luminance(1, 0, 0), 0.2126f);
    EXPECT_EQ(luminance(0, 1, 0), 0.7152f);
    EXPECT_EQ(luminance(0, 0, 1), 0.0722f);
}

TEST(Color, DecodesSrgbAsTheStandardSays) {
    EXPECT_EQ(srgb_to_linear(0), 0);
    EXPECT_NEAR(srgb_to_linear(1), 1, 1e-14);
    for (int i = 0; i <= 4000; ++i) {
        const double v = i / 2000.0;
        const double want = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        EXPECT_NEAR(srgb_to_linear(v), want, 1e-14 + 1e-14 * want) << v;
        EXPECT_EQ(srgb_to_linear(-v), -srgb_to_linear(v));
    }
}

}  // namespace
}  // namespace openfab::texture
