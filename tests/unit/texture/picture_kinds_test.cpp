// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The bits of pictures and what their files say of colours: texels against closed forms. PNG files are made here
// byte by byte, as no writer makes all of them.

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/says/says.h"
#include "tests/unit/texture/picture_kinds.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using Curve = std::function<double(double)>;

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

Bytes profile_chunk(const Bytes& profile) {
    return chunk("iCCP", Bytes("p\0\0", 3) + deflated(profile));
}

double straight(double v) {
    return v;
}

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

/// Programs that render write the data that are not black, and say where they lie in the picture.
TEST_F(PictureKinds, TheFrameOfOpenExrIsItsDisplayWindow) {
    constexpr int kWide = 7, kHigh = 5;
    struct Window {
        int x, y, width, height;
    };
    // Inside, with overscan on two sides, beside the frame, and one whose frame does not begin at 0.
    const std::vector<std::pair<Window, std::array<int, 2>>> windows = {
        {{2, 1, 3, 2}, {0, 0}}, {{-2, -1, 6, 4}, {0, 0}},    {{3, 2, 9, 8}, {0, 0}},
        {{8, 1, 2, 2}, {0, 0}}, {{-9, 11, 3, 3}, {-10, 10}}, {{0, 0, kWide, kHigh}, {0, 0}}};
    for (const auto& [data, frame] : windows) {
        for (const int tile : {0, 16}) {
            const std::filesystem::path file = folder_.path() / "w.exr";
            OIIO::ImageSpec spec(data.width, data.height, 1, OIIO::TypeDesc::FLOAT);
            spec.x = data.x, spec.y = data.y;
            spec.full_x = frame[0], spec.full_y = frame[1];
            spec.full_width = kWide, spec.full_height = kHigh;
            spec.tile_width = spec.tile_height = tile;
            const auto value = [](int x, int y) { return static_cast<float>(1 + x + 100 * y); };
            std::vector<float> pixels, want;
            for (int y = data.y; y < data.y + data.height; ++y) {
                for (int x = data.x; x < data.x + data.width; ++x)
                    pixels.push_back(value(x, y));
            }
            // Rows of a texture go up.
            for (int y = frame[1] + kHigh - 1; y >= frame[1]; --y) {
                for (int x = frame[0]; x < frame[0] + kWide; ++x) {
                    const bool in = x >= data.x && x < data.x + data.width && y >= data.y &&
                                    y < data.y + data.height;
                    want.push_back(in ? value(x, y) : 0);
                }
            }
            const auto out = OIIO::ImageOutput::create(file.string());
            ASSERT_TRUE(out->open(file.string(), spec)) << out->geterror();
            ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
            out->close();
            std::vector<float> found = texels_of(file, 1);
            found.resize(want.size());  // level 0
            EXPECT_EQ(found, want) << data.x << " " << data.y << " tile " << tile;
        }
    }
}

TEST_F(PictureKinds, WholeNumbersOfOpenExrAreNoLight) {
    const std::filesystem::path file = folder_.path() / "ids.exr";
    for (const bool has_colours : {false, true}) {
        OIIO::ImageSpec spec(1, 1, has_colours ? 5 : 1, OIIO::TypeDesc::FLOAT);
        spec.channelnames = has_colours ? std::vector<std::string>{"R", "G", "B", "A", "id"}
                                        : std::vector<std::string>{"Y"};
        spec.channelformats.assign(spec.channelnames.size(), OIIO::TypeDesc::FLOAT);
        spec.channelformats.back() = OIIO::TypeDesc::UINT;
        const auto out = OIIO::ImageOutput::create(file.string());
        ASSERT_TRUE(out->open(file.string(), spec)) << out->geterror();
        const std::vector<float> pixel(spec.channelnames.size(), 1.0F);
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixel.data()));
        out->close();
        if (has_colours) {
            EXPECT_EQ(texels_of(file, 4)[0], 1.0F);
            continue;
        }
        const Result<void> made =
            make_pyramid_file(file, folder_.path() / "ids.oftx", {"auto", false});
        ASSERT_FALSE(made);
        EXPECT_TRUE(testing::says(made.error().text(), messages::kExrWholeNumbers));
    }
}

TEST_F(PictureKinds, ColourAndDepthOfOpenExrIsThePictureAlone) {
    const auto write = [&](std::vector<std::string> names) {
        const std::filesystem::path file = folder_.path() / "d.exr";
        OIIO::ImageSpec spec(1, 1, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
        std::vector<float> pixel;
        for (const std::string& name : names)
            pixel.push_back(name == "R"   ? 0.25F
                            : name == "G" ? 0.5F
                            : name == "B" ? 0.75F
                            : name == "A" ? 1
                                          : 9);
        spec.channelnames = std::move(names);
        const auto out = OIIO::ImageOutput::create(file.string());
        EXPECT_TRUE(out->open(file.string(), spec)) << out->geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixel.data()));
        out->close();
        return file;
    };
    const auto begins = [](std::vector<float> texels, size_t count) {
        texels.resize(count);
        return texels;
    };
    EXPECT_EQ(begins(texels_of(write({"R", "G", "B", "A", "Z"}), 4), 4),
              (std::vector<float>{0.25F, 0.5F, 0.75F, 1}));
    EXPECT_EQ(begins(texels_of(write({"B", "G", "N.X", "N.Y", "N.Z", "R"}), 3), 3),
              (std::vector<float>{0.25F, 0.5F, 0.75F}));
}

/// A reader gives the first of six faces alone.
TEST_F(PictureKinds, SixFacesAroundAPointAreNoPicture) {
    const std::filesystem::path file = folder_.path() / "faces.exr";
    constexpr size_t kHigh = 96;
    OIIO::ImageSpec spec(16, kHigh, 3, OIIO::TypeDesc::FLOAT);
    spec.attribute("compression", "none");
    const auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out->open(file.string(), spec)) << out->geterror();
    const std::vector<float> pixels(16 * kHigh * 3, 0.5F);
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    out->close();
    texels_of(file, 3);  // is one without the attribute
    // The attribute goes in front, and the rows, whose places the file lists, behind it.
    std::ifstream stream(file, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(stream), {});
    const std::string attribute("envmap\0envmap\0\1\0\0\0\1", 19);
    const auto place = [&](size_t at) {
        uint64_t value = 0;
        std::memcpy(&value, &bytes[at], sizeof value);
        return value;
    };
    size_t table = 8;
    while (place(table) != table + 8 * kHigh)
        ++table;
    for (size_t row = 0; row < kHigh; ++row) {
        const uint64_t moved = place(table + 8 * row) + attribute.size();
        std::memcpy(&bytes[table + 8 * row], &moved, sizeof moved);
    }
    folder_.write("faces.exr", bytes.insert(8, attribute));
    const Result<void> made = make_pyramid_file(file, folder_.path() / "out.oftx", {"auto", false});
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().text(), testing::Says(messages::kCubeOfFaces));
}

TEST_F(PictureKinds, CompressionsThatAreNewerThanTheReaderAreNamed) {
    const std::filesystem::path file = folder_.path() / "new.exr";
    const auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out->open(file.string(), OIIO::ImageSpec(16, 16, 3, OIIO::TypeDesc::FLOAT)));
    const std::vector<float> pixels(16 * 16 * 3, 0.5F);
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    out->close();
    std::ifstream stream(file, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(stream), {});
    const std::string attribute("compression\0compression\0\1\0\0\0", 28);
    const size_t at = bytes.find(attribute);
    ASSERT_NE(at, std::string::npos);
    // OpenEXR 3.4 writes 10 and 11; no version has 200.
    for (const auto& [number, name] : {std::pair(11, "HTJ2K32"), std::pair(200, "unknown")}) {
        bytes[at + attribute.size()] = static_cast<char>(number);
        folder_.write("new.exr", bytes);
        const Result<void> made =
            make_pyramid_file(file, folder_.path() / "out.oftx", {"auto", false});
        ASSERT_FALSE(made);
        EXPECT_THAT(made.error().text(),
                    testing::Says(messages::kExrCompressionNotRead, name, number));
    }
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

}  // namespace
}  // namespace openfab::tools
