// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Kinds of pictures, their bits and what their files say of colours: texels against closed forms. PNG and
// TIFF files are made here byte by byte, as no writer makes all of them.

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "texture/pyramid.h"
#include "tools/texture/convert.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using texture::Pyramid;
using Bytes = std::string;
using Curve = std::function<double(double)>;

Bytes big(uint64_t value, int bytes) {
    Bytes out;
    for (int k = bytes; k-- > 0;)
        out += static_cast<char>(value >> 8 * k & 0xff);
    return out;
}

Bytes little(uint64_t value, int bytes) {
    const Bytes reversed = big(value, bytes);
    return {reversed.rbegin(), reversed.rend()};
}

Bytes chunk(const Bytes& type, const Bytes& data) {
    const Bytes body = type + data;
    const auto sum = ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), body.size());
    return big(data.size(), 4) + body + big(sum, 4);
}

Bytes deflated(const Bytes& data) {
    uLongf size = compressBound(data.size());
    Bytes out(size, '\0');
    compress(reinterpret_cast<Bytef*>(out.data()), &size,
             reinterpret_cast<const Bytef*>(data.data()), data.size());
    return out.substr(0, size);
}

/// One row of values of `bits`.
Bytes packed(const std::vector<int>& values, int bits) {
    Bytes out;
    int have = 0;
    uint64_t pending = 0;
    for (const int value : values) {
        pending = pending << bits | static_cast<uint64_t>(value);
        for (have += bits; have >= 8; have -= 8)
            out += static_cast<char>(pending >> (have - 8) & 0xff);
    }
    if (have > 0) out += static_cast<char>(pending << (8 - have) & 0xff);
    return out;
}

Bytes png(int width, int type, int bits, const std::vector<int>& values, const Bytes& chunks = {}) {
    Bytes head = big(static_cast<uint64_t>(width), 4) + big(1, 4);
    head += static_cast<char>(bits);
    head += static_cast<char>(type);
    head += Bytes(3, '\0');
    return "\x89PNG\r\n\x1a\n" + chunk("IHDR", head) + chunks +
           chunk("IDAT", deflated(Bytes(1, '\0') + packed(values, bits))) + chunk("IEND", "");
}

Bytes gamma_chunk(double gamma) {
    return chunk("gAMA", big(static_cast<uint64_t>(std::lround(gamma * 1e5)), 4));
}

/// Red, green, blue, white.
Bytes corners_chunk(const std::array<double, 8>& c) {
    Bytes data;
    for (const size_t k : {6, 7, 0, 1, 2, 3, 4, 5})
        data += big(static_cast<uint64_t>(std::lround(c[k] * 1e5)), 4);
    return chunk("cHRM", data);
}

constexpr std::array<double, 8> kSrgbCorners = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
constexpr std::array<double, 8> kP3Corners = {0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.3290};

Bytes saved(cmsHPROFILE profile) {
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(profile, nullptr, &size);
    Bytes out(size, '\0');
    cmsSaveProfileToMem(profile, out.data(), &size);
    cmsCloseProfile(profile);
    return out;
}

Bytes grey_profile(double gamma) {
    cmsToneCurve* const curve = cmsBuildGamma(nullptr, gamma);
    cmsHPROFILE profile = cmsCreateGrayProfile(cmsD50_xyY(), curve);
    cmsFreeToneCurve(curve);
    return saved(profile);
}

Bytes profile_chunk(const Bytes& profile) {
    return chunk("iCCP", Bytes("p\0\0", 3) + deflated(profile));
}

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

double srgb(double v) {
    return srgb_to_linear(v);
}
double straight(double v) {
    return v;
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

TEST_F(PictureKinds, GreyPngOfAllBitsByAllChunks) {
    struct Says {
        const char* name;
        Bytes chunks;
        Curve curve;
        double tolerance;
    };
    const double power = 1 / 0.45455;
    const Says all[] = {
        {"nothing", "", srgb, 1e-6},
        {"sRGB", chunk("sRGB", Bytes(1, '\0')), srgb, 1e-6},
        {"linear gamma", gamma_chunk(1), straight, 1e-6},
        {"gamma 2.2", gamma_chunk(0.45455), [&](double v) { return std::pow(v, power); }, 2e-6},
        {"sRGB before gamma", gamma_chunk(1) + chunk("sRGB", Bytes(1, '\0')), srgb, 1e-6},
        {"a grey profile", profile_chunk(grey_profile(1.8)),
         [](double v) { return std::pow(v, 1.8); }, 3e-5},
        {"a profile before sRGB", profile_chunk(grey_profile(1)) + chunk("sRGB", Bytes(1, '\0')),
         straight, 3e-5},
        {"code points before a profile",
         chunk("cICP", {"\1\x08\0\1", 4}) + profile_chunk(grey_profile(1.8)), straight, 1e-6},
        {"code points that are not read", chunk("cICP", {"\x09\x10\0\1", 4}) + gamma_chunk(1),
         straight, 1e-6},
    };
    for (const Says& says : all) {
        for (const int bits : {1, 2, 4, 8, 16}) {
            SCOPED_TRACE(std::string(says.name) + ", " + std::to_string(bits) + " bits");
            const int most = (1 << bits) - 1;
            const std::vector<int> values = {0, most, most / 3, most - most / 5};
            const std::vector<float> got = texels(png(4, 0, bits, values, says.chunks), 1);
            for (size_t k = 0; k < values.size(); ++k)
                EXPECT_NEAR(got[k], says.curve(static_cast<double>(values[k]) / most),
                            says.tolerance);
        }
    }
}

TEST_F(PictureKinds, DataAreTheirNumbersWhateverTheFileSays) {
    for (const int bits : {8, 16}) {
        const int most = (1 << bits) - 1, half = (most + 1) / 2;
        for (const Bytes& chunks : {Bytes(), chunk("sRGB", Bytes(1, '\0')), gamma_chunk(0.45455)})
            EXPECT_FLOAT_EQ(texels(png(1, 0, bits, {half}, chunks), 1, "data")[0],
                            static_cast<float>(half) / static_cast<float>(most));
    }
}

TEST_F(PictureKinds, ColoursOfEachTypeAndOfPalettes) {
    for (const int bits : {8, 16}) {
        const int unit = bits == 8 ? 1 : 257;
        const std::array<double, 3> want = {srgb(200 / 255.0), srgb(100 / 255.0), srgb(50 / 255.0)};
        expect_colors(png(1, 2, bits, {200 * unit, 100 * unit, 50 * unit}), want, 1e-6);
    }
    const Bytes palette = chunk("PLTE", {"\x0a\x14\x1e\xc8\x64\x32", 6});
    for (const int bits : {1, 2, 4, 8}) {
        const std::vector<float> got = texels(png(2, 3, bits, {1, 0}, palette), 3);
        EXPECT_NEAR(got[0], srgb(200 / 255.0), 1e-6);
        EXPECT_NEAR(got[5], srgb(30 / 255.0), 1e-6);
    }
}

TEST_F(PictureKinds, PrimariesBecomeThoseOfSrgb) {
    // The red of Display P3 in linear sRGB.
    const std::array<double, 3> red = {1.2249402, -0.0420570, -0.0196376};
    const std::vector<int> value = {255, 0, 0};
    expect_colors(png(1, 2, 8, value, chunk("cICP", {"\x0c\x0d\0\1", 4})), red);
    expect_colors(png(1, 2, 8, value, corners_chunk(kP3Corners) + gamma_chunk(0.45455)), red);
    expect_colors(png(1, 2, 8, value, corners_chunk(kSrgbCorners) + gamma_chunk(0.45455)),
                  {1, 0, 0});
    expect_colors(png(1, 2, 8, {255, 255, 255}, corners_chunk(kP3Corners)), {1, 1, 1});
    // ITU-R BT.2020, with its curve.
    expect_colors(png(1, 2, 8, {0, 255, 0}, chunk("cICP", {"\x09\x01\0\1", 4})),
                  {-0.5876411, 1.1328999, -0.1005789});
}

TEST_F(PictureKinds, ChromaticitiesOfOpenExr) {
    const auto exr = [&](const std::array<float, 8>& corners) {
        const std::filesystem::path file = folder_.path() / "c.exr";
        OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
        spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), corners.data());
        const auto out = OIIO::ImageOutput::create(file.string());
        const std::array<float, 3> pixel = {0.5f, 0.25f, 2.0f};
        EXPECT_TRUE(out->open(file.string(), spec));
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixel.data()));
        out->close();
        return texels_of(file, 3);
    };
    const std::vector<float> same = exr({0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f});
    EXPECT_EQ(std::vector<float>(same.begin(), same.begin() + 3),
              (std::vector<float>{0.5f, 0.25f, 2}));
    // ACES 2065-1 (AP0) to sRGB, with Bradford's adaptation of its white to D65.
    const std::vector<float> aces =
        exr({0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f});
    const std::array<std::array<double, 3>, 3> matrix = {{{2.5216862, -1.1341310, -0.3875552},
                                                          {-0.2764799, 1.3727191, -0.0962392},
                                                          {-0.0153781, -0.1529753, 1.1683534}}};
    const std::array<double, 3> pixel = {0.5, 0.25, 2};
    for (size_t row = 0; row < 3; ++row) {
        double want = 0;
        for (size_t k = 0; k < 3; ++k)
            want += matrix[row][k] * pixel[k];
        EXPECT_NEAR(aces[row], want, 2e-4);
    }
}

TEST_F(PictureKinds, AlphaOfPng) {
    for (const int bits : {8, 16}) {
        SCOPED_TRACE(bits);
        const int unit = bits == 8 ? 1 : 257;
        const double a = 102 / 255.0;
        const auto on_white = [&](int v) { return a * srgb(v / 255.0) + 1 - a; };
        const std::vector<float> grey =
            texels(png(2, 4, bits, {200 * unit, 102 * unit, 77 * unit, 0}), 2);
        EXPECT_TRUE(has_alpha_);
        EXPECT_NEAR(grey[0], on_white(200), 1e-6);
        EXPECT_NEAR(grey[1], a, 1e-6);
        EXPECT_EQ(grey[2], 1);
        EXPECT_EQ(grey[3], 0);
        const std::vector<float> color =
            texels(png(1, 6, bits, {200 * unit, 100 * unit, 50 * unit, 102 * unit}), 4);
        EXPECT_TRUE(has_alpha_);
        EXPECT_NEAR(color[1], on_white(100), 1e-6);
        EXPECT_NEAR(color[3], a, 1e-6);
    }
    // A colour that is transparent, and a palette's.
    const std::vector<float> key =
        texels(png(2, 2, 8, {1, 2, 3, 200, 100, 50}, chunk("tRNS", {"\0\1\0\2\0\3", 6})), 4);
    EXPECT_EQ(std::vector<float>(key.begin(), key.begin() + 4), (std::vector<float>{1, 1, 1, 0}));
    EXPECT_NEAR(key[4], srgb(200 / 255.0), 1e-6);
    EXPECT_EQ(key[7], 1);
    const Bytes palette =
        chunk("PLTE", {"\x0a\x14\x1e\xc8\x64\x32", 6}) + chunk("tRNS", {"\0\x66", 2});
    const std::vector<float> some = texels(png(2, 3, 8, {0, 1}, palette), 4);
    EXPECT_EQ(some[0], 1);
    EXPECT_NEAR(some[7], 0.4, 1e-6);
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
