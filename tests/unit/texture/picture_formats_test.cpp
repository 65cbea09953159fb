// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pictures in other formats than PNG, made here byte by byte where no writer makes all kinds: texels against closed
// forms, and what a file holds besides.

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/says/says.h"
#include "tests/unit/texture/picture_kinds.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

Bytes tiff(int width, int channels, int bits, int photometric, const Bytes& pixels, int extra = -1,
           const Bytes& profile = {}) {
    struct Tag {
        int number, type;
        std::vector<uint64_t> values;
    };
    std::vector<Tag> tags = {
        {256, 4, {static_cast<uint64_t>(width)}},
        {257, 4, {1}},
        {258, 3, std::vector<uint64_t>(static_cast<size_t>(channels), static_cast<uint64_t>(bits))},
        {259, 3, {1}},
        {262, 3, {static_cast<uint64_t>(photometric)}},
        {273, 4, {0}},
        {277, 3, {static_cast<uint64_t>(channels)}},
        {278, 4, {1}},
        {279, 4, {pixels.size()}}};
    if (extra >= 0) tags.push_back({338, 3, {static_cast<uint64_t>(extra)}});
    if (!profile.empty()) {
        Tag tag{34675, 7, {}};
        for (const char c : profile)
            tag.values.push_back(static_cast<uint8_t>(c));
        tags.push_back(tag);
    }
    const size_t behind = 8 + 2 + 12 * tags.size() + 4;
    size_t end = behind;
    const auto width_of = [](const Tag& tag) { return tag.type == 3 ? 2 : tag.type == 4 ? 4 : 1; };
    for (const Tag& tag : tags) {
        const size_t bytes = tag.values.size() * static_cast<size_t>(width_of(tag));
        if (bytes > 4) end += bytes;
    }
    Bytes directory = little(tags.size(), 2), rest;
    for (Tag& tag : tags) {
        if (tag.number == 273) tag.values = {end};
        Bytes data;
        for (const uint64_t value : tag.values)
            data += little(value, width_of(tag));
        directory += little(static_cast<uint64_t>(tag.number), 2) +
                     little(static_cast<uint64_t>(tag.type), 2) + little(tag.values.size(), 4);
        if (data.size() > 4) {
            directory += little(behind + rest.size(), 4);
            rest += data;
        } else {
            directory += data + Bytes(4 - data.size(), '\0');
        }
    }
    return Bytes("II*\0", 4) + little(8, 4) + directory + little(0, 4) + rest + pixels;
}

TEST_F(PictureKinds, Tiff) {
    EXPECT_NEAR(texels(tiff(1, 1, 8, 1, "\xc8"), 1)[0], srgb(200 / 255.0), 1e-6);
    EXPECT_NEAR(texels(tiff(1, 1, 8, 0, "\xc8"), 1)[0], srgb(55 / 255.0), 1e-6);
    EXPECT_NEAR(texels(tiff(1, 1, 16, 1, little(32768, 2)), 1)[0], 32768.0 / 65535, 1e-6);
    EXPECT_NEAR(texels(tiff(1, 1, 16, 1, little(32768, 2), -1, grey_profile(1.8)), 1)[0],
                std::pow(32768.0 / 65535, 1.8), 3e-5);
    // A grey picture that kept the profile of colours.
    EXPECT_NEAR(
        texels(tiff(1, 1, 16, 1, little(32768, 2), -1, saved(cmsCreate_sRGBProfile())), 1)[0],
        srgb(32768.0 / 65535), 1e-6);
    // Alpha by itself (2) and multiplied already (1): the same light.
    for (const int kind : {1, 2}) {
        const Bytes pixel = kind == 2 ? "\xc8\x64\x32\x80" : "\x64\x32\x19\x80";
        const std::vector<float> got = texels(tiff(1, 4, 8, 2, pixel, kind), 4);
        EXPECT_TRUE(has_alpha_);
        const double a = 128 / 255.0;
        EXPECT_NEAR(got[0], a * srgb(200 / 255.0) + 1 - a, 4e-3);
        EXPECT_NEAR(got[3], a, 1e-6);
    }
}

// Lightness 0 to 100 and differences of 0 are greys; a and b of D50, adapted.
TEST_F(PictureKinds, LabOfTiff) {
    const auto light = [](double lightness) {
        const double f = (lightness + 16) / 116;
        return f * f * f;
    };
    const auto expect_grey = [&](const Bytes& file, double want) {
        expect_colors(file, {want, want, want});
    };
    expect_grey(tiff(1, 3, 8, 8, {"\xff\0\0", 3}), 1);
    expect_grey(tiff(1, 3, 8, 8, {"\x80\0\0", 3}), light(100 * 128 / 255.0));
    expect_grey(tiff(1, 3, 16, 8, little(32768, 2) + Bytes(4, '\0')), light(100 * 32768 / 65535.0));
    expect_grey(tiff(1, 3, 8, 9, "\x80\x80\x80"), light(100 * 128 / 255.0));
    expect_grey(tiff(1, 3, 16, 9, little(0x8000, 2) + little(0x8000, 2) + little(0x8000, 2)),
                light(100 * 0x8000 / double{0xff00}));
    // The red of sRGB under D50.
    expect_colors(
        tiff(1, 3, 16, 8,
             little(std::lround(54.2917 / 100 * 65535), 2) + little(std::lround(80.8125 * 256), 2) +
                 little(std::lround(69.8851 * 256), 2)),
        {1, 0, 0}, 2e-3);
    expect_colors(tiff(1, 3, 8, 8, {"\x80\xd0\x20", 3}),
                  {texels(tiff(1, 3, 8, 9, "\x80\x50\xa0"), 3)[0],
                   texels(tiff(1, 3, 8, 9, "\x80\x50\xa0"), 3)[1],
                   texels(tiff(1, 3, 8, 9, "\x80\x50\xa0"), 3)[2]});
}

Bytes bmp(int bits, const Bytes& palette, const Bytes& rows, int height = 2) {
    const size_t at = 54 + palette.size();
    return "BM" + little(at + rows.size(), 4) + little(0, 4) + little(at, 4) + little(40, 4) +
           little(2, 4) + little(static_cast<uint32_t>(height), 4) + little(1, 2) +
           little(static_cast<uint64_t>(bits), 2) + little(0, 4) + little(rows.size(), 4) +
           little(0, 8) + little(palette.size() / 4, 4) + little(0, 4) + palette + rows;
}

Bytes tga(int type, int bits, int descriptor, const Bytes& rows) {
    return Bytes("\0\0", 2) + static_cast<char>(type) + Bytes(9, '\0') + little(2, 2) +
           little(2, 2) + static_cast<char>(bits) + static_cast<char>(descriptor) + rows;
}

// Red and green below, blue and white above; the bottom row comes first in a pyramid.
TEST_F(PictureKinds, BmpAndTga) {
    const std::vector<float> want = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    const auto expect = [&](const Bytes& file) {
        std::vector<float> got = texels(file, 3);
        got.resize(12);
        EXPECT_EQ(got, want);
    };
    const Bytes low = {"\0\0\xff\0\xff\0", 6}, high = {"\xff\0\0\xff\xff\xff", 6}, pad(2, '\0');
    expect(bmp(24, "", low + pad + high + pad));
    expect(bmp(24, "", high + pad + low + pad, -2));
    // Of 32 bits the last eight say nothing.
    expect(bmp(32, "", {"\0\0\xff\0\0\xff\0\0\xff\0\0\0\xff\xff\xff\0", 16}));
    const Bytes palette = {"\0\0\xff\0\0\xff\0\0\xff\0\0\0\xff\xff\xff\0", 16};
    expect(bmp(8, palette, {"\0\1\0\0\2\3\0\0", 8}));
    expect(bmp(4, palette, {"\x01\0\0\0\x23\0\0\0", 8}));
    // Of version 4 on they may: with a mask for alpha.
    const Bytes colors = little(0xff0000, 4) + little(0xff00, 4) + little(0xff, 4);
    const Bytes late = "BM" + little(122 + 16, 4) + little(0, 4) + little(122, 4) + little(108, 4) +
                       little(2, 4) + little(2, 4) + little(1, 2) + little(32, 2) + little(3, 4) +
                       little(16, 4) + Bytes(16, '\0') + colors + little(0xff000000, 4) +
                       Bytes(52, '\0');
    const std::vector<float> masked =
        texels(late + Bytes("\0\0\xff\xff\0\xff\0\x66\xff\0\0\0\xff\xff\xff\xff", 16), 4);
    EXPECT_NEAR(masked[4], 0.6, 1e-6);
    EXPECT_NEAR(masked[5], 1, 1e-6);
    expect(tga(2, 24, 0, low + high));
    expect(tga(2, 24, 0x20, high + low));
    expect(tga(2, 32, 0, {"\0\0\xff\0\0\xff\0\0\xff\0\0\0\xff\xff\xff\0", 16}));
    expect(tga(10, 24, 0, "\1" + low + "\1" + high));
    const std::vector<float> alpha =
        texels(tga(2, 32, 8, {"\0\0\xff\xff\0\xff\0\x66\xff\0\0\0\xff\xff\xff\xff", 16}), 4);
    EXPECT_TRUE(has_alpha_);
    EXPECT_NEAR(alpha[5], 1, 1e-6);
    EXPECT_NEAR(alpha[4], 0.6, 1e-6);
    EXPECT_EQ(alpha[11], 0);
    const std::vector<float> grey = texels(tga(3, 8, 0x20, {"\0\x40\x80\xff", 4}), 1);
    EXPECT_NEAR(grey[0], srgb(128 / 255.0), 1e-6);
}

TEST_F(PictureKinds, GifAndWebp) {
    // One grey: WebP keeps colours of single pixels badly.
    std::vector<uint8_t> pixels(16, 200);
    for (size_t k = 3; k < pixels.size(); k += 4)
        pixels[k] = 255;
    for (const char* name : {"a.gif", "a.webp"}) {
        SCOPED_TRACE(name);
        const std::filesystem::path file = folder_.path() / name;
        const auto out = OIIO::ImageOutput::create(file.string());
        ASSERT_NE(out, nullptr);
        OIIO::ImageSpec spec(2, 2, 4, OIIO::TypeDesc::UINT8);
        ASSERT_TRUE(out->open(file.string(), spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
        out->close();
        const Result<void> checked = check_picture_file(file, {});
        EXPECT_TRUE(checked) << checked.error().text();
        // What is opaque everywhere has no alpha as WebP.
        const bool gif = file.extension() == ".gif";
        const std::vector<float> got = texels_of(file, gif ? 4 : 3);
        for (const size_t c : {0, 1, 2})
            EXPECT_NEAR(got[c], srgb(200 / 255.0), 0.02);
        if (gif) {
            EXPECT_EQ(got[3], 1);
        }
    }
}

TEST_F(PictureKinds, OfSeveralPicturesTheFirstIsReadAndTheOthersAreTold) {
    for (const char* name : {"a.tif", "a.exr", "a.gif"}) {
        SCOPED_TRACE(name);
        const std::filesystem::path file = folder_.path() / name;
        const auto out = OIIO::ImageOutput::create(file.string());
        ASSERT_NE(out, nullptr);
        const bool parts = file.extension() == ".exr";
        std::vector<OIIO::ImageSpec> specs(
            2, OIIO::ImageSpec(2, 2, 3, parts ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8));
        for (size_t i = 0; i < 2; ++i)
            specs[i].attribute("oiio:subimagename", i == 0 ? "front" : "back");
        const auto write = [&](int pictures) {
            ASSERT_TRUE(parts ? out->open(file.string(), pictures, specs.data())
                              : out->open(file.string(), specs[0]));
            for (int i = 0; i < pictures; ++i) {
                const std::vector<float> pixels(12, i == 0 ? 1.0F : 0.0F);
                if (i > 0) {
                    ASSERT_TRUE(
                        out->open(file.string(), specs[1], OIIO::ImageOutput::AppendSubimage));
                }
                ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
            }
            out->close();
        };
        const auto told = [&] {
            ::testing::internal::CaptureStderr();
            const Result<void> checked = check_picture_file(file, {});
            EXPECT_TRUE(checked) << checked.error().text();
            EXPECT_NEAR(texels_of(file, file.extension() == ".gif" ? 4 : 3)[0], 1, 1e-6);
            return ::testing::internal::GetCapturedStderr();
        };
        write(1);
        EXPECT_EQ(told(), "");
        write(2);
        const std::string line = "note: " + fmt::format(messages::kSeveralPictures, name) + "\n";
        EXPECT_EQ(told(), line + line);
    }
}

TEST_F(PictureKinds, AProfileThatIsNotUsedIsTold) {
    for (const auto& [name, has_profile] : std::vector<std::pair<std::string, bool>>{
             {"a.tif", false}, {"a.tif", true}, {"a.png", false}, {"a.png", true}}) {
        SCOPED_TRACE(name);
        const std::filesystem::path file = folder_.path() / name;
        OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT8);
        const std::vector<uint8_t> damaged(300, 7);
        const bool png = name == "a.png";
        if (has_profile && !png)
            spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, 300),
                           damaged.data());
        const std::array<uint8_t, 3> pixel = {255, 128, 0};
        const auto out = OIIO::ImageOutput::create(file.string());
        ASSERT_TRUE(out->open(file.string(), spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixel.data()));
        out->close();
        if (has_profile &&
            png) {  // libpng writes no such profile, and leaves it out where it reads
            constexpr size_t kBehindHead = 33;
            const Bytes chunk = Bytes("\0\0\0\x10iCCP", 8) + "inks" + Bytes(16, '\0');
            std::ifstream in(file, std::ios::binary);
            Bytes bytes(std::istreambuf_iterator<char>(in), {});
            folder_.write(name, bytes.insert(kBehindHead, chunk));
        }
        ::testing::internal::CaptureStderr();
        EXPECT_NEAR(texels_of(file, 3)[0], 1, 1e-6);
        const std::string told = ::testing::internal::GetCapturedStderr();
        EXPECT_EQ(
            told,
            has_profile
                ? "note: " + fmt::format(messages::kNoteOnColors, name, messages::kProfileUnused) +
                      "\n"
                : "");
    }
}

/// Colours of sRGB with a power as their curve.
Bytes color_profile(double gamma) {
    const cmsCIExyY white{0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};
    cmsToneCurve* const curve = cmsBuildGamma(nullptr, gamma);
    const std::array<cmsToneCurve*, 3> curves = {curve, curve, curve};
    cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves.data());
    cmsFreeToneCurve(curve);
    return saved(profile);
}

/// Bytes as zlib stores them, without compression.
Bytes stored(const Bytes& bytes) {
    constexpr uint32_t kBase = 65521;
    uint32_t low = 1, high = 0;
    for (const char c : bytes) {
        low = (low + static_cast<uint8_t>(c)) % kBase;
        high = (high + low) % kBase;
    }
    return "\x78\x01\x01" + little(bytes.size(), 2) + little(~bytes.size() & 0xffff, 2) + bytes +
           big(high << 16 | low, 4);
}

/// What a picture of one value, as OpenImageIO writes it, has as its bytes.
Bytes written(const std::filesystem::path& file, int channels) {
    constexpr int kSide = 16;
    const OIIO::ImageSpec spec(kSide, kSide, channels, OIIO::TypeDesc::UINT8);
    const std::vector<uint8_t> pixels(static_cast<size_t>(kSide * kSide * channels), 200);
    const auto out = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(out->open(file.string(), spec));
    EXPECT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    out->close();
    std::ifstream in(file, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
}

// libpng leaves out a grey picture's profile that is of colours; OpenImageIO reads none of WebP.
TEST_F(PictureKinds, ProfilesThatTheirLibrariesLeaveOutCount) {
    constexpr double kGamma = 1.4;
    const double want = std::pow(200 / 255.0, kGamma);
    const Bytes profile = color_profile(kGamma);
    for (const int channels : {1, 3}) {
        const Bytes packed = Bytes("name\0\0", 6) + stored(profile);
        const Bytes chunk = big(packed.size(), 4) + "iCCP" + packed + Bytes(4, '\0');
        constexpr size_t kBehindHead = 33;
        Bytes png = written(folder_.path() / "a.png", channels);
        EXPECT_NEAR(texels(png.insert(kBehindHead, chunk), channels)[0], want, 1e-4) << channels;
    }
    constexpr size_t kBehindKind = 12;
    const Bytes webp = written(folder_.path() / "a.webp", 3).substr(kBehindKind);
    const Bytes padded = profile + Bytes(profile.size() % 2, '\0');
    const Bytes chunks = "VP8X" + little(10, 4) + little(0x20, 4) + little(15, 3) + little(15, 3) +
                         "ICCP" + little(profile.size(), 4) + padded + webp;
    const Bytes whole = "RIFF" + little(4 + chunks.size(), 4) + "WEBP" + chunks;
    EXPECT_NEAR(texels(whole, 3)[0], want, 0.01);
    // A damaged one is told, and nothing else.
    Bytes damaged = whole;
    damaged.replace(damaged.find("acsp"), 4, "none");
    ::testing::internal::CaptureStderr();
    EXPECT_NEAR(texels(damaged, 3)[0], srgb(200 / 255.0), 0.01);
    EXPECT_THAT(::testing::internal::GetCapturedStderr(), testing::Says(messages::kProfileUnused));
}

TEST_F(PictureKinds, WhatALibraryIsNotMadeForIsAnErrorInAnyCase) {
    const std::filesystem::path out = folder_.path() / "none.oftx";
    const Bytes whole = bmp(24, "", Bytes(16, '\7'));
    std::vector<Bytes> files = {
        // 65,535 x 65,535 pixels, of nothing.
        bmp(24, "", "").replace(18, 8, little(65535, 4) + little(65535, 4)),
        tga(2, 24, 0, "").replace(12, 4, Bytes(4, '\xff')), "GIF89a" + Bytes(7, '\xff'),
        "RIFF" + little(40, 4) + "WEBPVP8X" + little(10, 4) + Bytes(4, '\0') + Bytes(6, '\xff'),
        Bytes("RIFF\x14\0\0\0WEBPVP8L", 16) + Bytes(12, '\xff')};
    for (size_t length = 14; length < whole.size(); length += 3)
        files.push_back(whole.substr(0, length));
    for (const Bytes& file : files) {
        const Result<void> made = make_pyramid_file(folder_.write("picture", file), out, {});
        EXPECT_FALSE(made) << file.size();
        EXPECT_FALSE(std::filesystem::exists(out));
    }
}

TEST_F(PictureKinds, PlainBitsWithAndWithoutBlanks) {
    for (const char* text : {"P1\n4 2\n1101\n0\n# a comment\n100", "P1\n#c\n4 2\n1 1 0 1 0 1 0 0\n",
                             "P1 4 2 11010100"}) {
        std::vector<float> got = texels(text, 1);
        got.resize(8);
        std::vector<float> read;
        for (const bool black : {false, true, false, false, true, true, false, true})
            read.push_back(black ? 0.0f : 1.0f);
        EXPECT_EQ(got, read) << text;
    }
    const auto error_of = [&](const Bytes& text) {
        const Result<void> made =
            make_pyramid_file(folder_.write("picture", text), folder_.path() / "none.oftx", {});
        return made ? "no error" : made.error().text();
    };
    EXPECT_THAT(error_of("P1\n4 2\n1101010"), testing::Says(messages::kCutShortAtPixel));
    EXPECT_THAT(error_of("P1\n4 2\n11010201"), testing::Says(messages::kPixelNotABit, 1, 1));
    EXPECT_NE(error_of("P1\n999999999 2\n1").find("size"), Bytes::npos);
}

}  // namespace
}  // namespace openfab::tools
