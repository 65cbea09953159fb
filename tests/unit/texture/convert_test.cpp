// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert.h"
#include "tests/support/places/places.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cmath>
#include <set>

#include "base/color.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

using texture::ImageOptions;
using texture::Pyramid;

class ConvertTest : public ::testing::Test {
  protected:
    ConvertTest() {
        ::setenv("OPENFAB_CACHE", (folder_.path() / "cache" / "deep").c_str(), 1);
        ::setenv("OPENFAB_HELPER", testing::test_program("texture_test_helper").c_str(), 1);
        ::setenv("PATH", "/nonexistent", 1);
    }

    /// Writes rows from the top, as image files have them.
    template <typename T>
    std::filesystem::path image(const std::string& name, int width, int height, int channels,
                                const std::vector<T>& data, int orientation = 1, int tile = 0) {
        const std::filesystem::path file = folder_.path() / name;
        const auto out = OIIO::ImageOutput::create(file.string());
        OIIO::ImageSpec spec(width, height, channels, OIIO::BaseTypeFromC<T>::value);
        if (orientation != 1) spec.attribute("Orientation", orientation);
        spec.attribute("oiio:UnassociatedAlpha", 1);
        if (tile > 0) spec.tile_width = spec.tile_height = tile;
        EXPECT_TRUE(out->open(file.string(), spec)) << out->geterror();
        EXPECT_TRUE(out->write_image(OIIO::BaseTypeFromC<T>::value, data.data()));
        out->close();
        return file;
    }
    std::shared_ptr<const Pyramid> converted(const std::filesystem::path& file,
                                             const ImageOptions& options = {}) {
        const std::filesystem::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_pyramid_file(file, out, options);
        EXPECT_TRUE(made) << made.error().text();
        const auto opened = Pyramid::open(out, 0, 0);
        EXPECT_TRUE(opened);
        return opened ? *opened : nullptr;
    }
    static std::vector<float> level0(const Pyramid& p) {
        const size_t n = static_cast<size_t>(p.info()[9]) * static_cast<size_t>(p.info()[10]) *
                         static_cast<size_t>(p.channels());
        return {p.texels().begin(), p.texels().begin() + static_cast<std::ptrdiff_t>(n)};
    }
    static float decoded(int value) { return static_cast<float>(srgb_to_linear(value / 255.0)); }

    testing::TempFolder folder_;
};

TEST_F(ConvertTest, PutsTheBottomRowFirstAndDecodesBeforeFiltering) {
    const std::vector<uint8_t> grey = {0, 64, 128, 255};  // top row 0 64, bottom row 128 255
    const auto p = converted(image<uint8_t>("grey.png", 2, 2, 1, grey));
    EXPECT_EQ(level0(*p),
              (std::vector<float>{decoded(128), decoded(255), decoded(0), decoded(64)}));
    const double mean =
        (static_cast<double>(decoded(0)) + decoded(64) + decoded(128) + decoded(255)) / 4;
    EXPECT_FLOAT_EQ(p->texels()[4], static_cast<float>(mean));
    const auto data = converted(folder_.path() / "grey.png", {"data", false});
    EXPECT_FLOAT_EQ(data->texels()[0], 128.0f / 255);
}

TEST_F(ConvertTest, DecodesEveryByteExactly) {
    std::vector<uint8_t> all(256);
    for (size_t i = 0; i < 256; ++i)
        all[i] = static_cast<uint8_t>(i);
    const auto p = converted(image<uint8_t>("all.png", 256, 1, 1, all));
    for (int i = 0; i < 256; ++i)
        EXPECT_EQ(p->texels()[i], decoded(i));
}

TEST_F(ConvertTest, ReadsSixteenBitsAndFloatAsLinear) {
    const auto sixteen = converted(image<uint16_t>("s.tif", 2, 1, 1, {0, 32768}));
    EXPECT_FLOAT_EQ(sixteen->texels()[1], 32768.0f / 65535);
    const auto real = converted(image<float>("f.exr", 2, 1, 1, {-1.5f, 7.25f}));
    EXPECT_EQ(level0(*real), (std::vector<float>{-1.5f, 7.25f}));
    const auto forced = converted(folder_.path() / "f.exr", {"srgb", false});
    EXPECT_FLOAT_EQ(forced->texels()[1], static_cast<float>(srgb_to_linear(7.25)));
}

TEST_F(ConvertTest, MakesLuminanceAfterLinearising) {
    const auto file = image<uint8_t>("c.png", 1, 1, 3, {200, 100, 50});
    const auto p = converted(file, {"auto", true});
    EXPECT_EQ(p->channels(), 1);
    EXPECT_EQ(p->texels()[0], luminance(decoded(200), decoded(100), decoded(50)));
    EXPECT_EQ(converted(file)->channels(), 3);
}

TEST_F(ConvertTest, PutsColorsWithAlphaOnWhite) {
    const float a = 128.0f / 255;
    const auto on_white = [&](float color) { return a * color + (1 - a); };
    const auto rgba = image<uint8_t>("a.png", 2, 1, 4, {200, 100, 50, 128, 9, 99, 199, 0});
    const auto p = converted(rgba);
    EXPECT_EQ(p->info()[texture::kInfoAlpha], 1);
    const std::vector<float> texels = level0(*p);
    for (size_t c = 0; c < 3; ++c)
        EXPECT_FLOAT_EQ(texels[c], on_white(decoded(std::array{200, 100, 50}[c])));
    EXPECT_FLOAT_EQ(texels[3], a) << "alpha is not decoded";
    EXPECT_EQ(std::vector<float>(texels.begin() + 4, texels.end()),
              (std::vector<float>{1, 1, 1, 0}))
        << "what is under full transparency is not there";
    const float grey = luminance(decoded(200), decoded(100), decoded(50));
    const auto one = converted(rgba, {"auto", true});
    EXPECT_EQ(one->info()[texture::kInfoAlpha], 0);
    EXPECT_FLOAT_EQ(one->texels()[0], on_white(grey));
    EXPECT_EQ(one->texels()[1], 1);
    // Data are numbers; a height is 0 where nothing is.
    const auto data = converted(rgba, {"data", false});
    EXPECT_EQ(data->info()[texture::kInfoAlpha], 0);
    EXPECT_FLOAT_EQ(data->texels()[6], 199.0f / 255);
    const auto height = converted(rgba, {"data", true});
    EXPECT_FLOAT_EQ(height->texels()[0], luminance(200.0f / 255, 100.0f / 255, 50.0f / 255) * a);
    EXPECT_EQ(height->texels()[1], 0);
    const auto grey_alpha = converted(image<uint8_t>("ga.png", 1, 1, 2, {200, 128}));
    EXPECT_EQ(grey_alpha->channels(), 2);
    EXPECT_EQ(grey_alpha->info()[texture::kInfoAlpha], 1);
    EXPECT_FLOAT_EQ(grey_alpha->texels()[0], on_white(decoded(200)));
}

TEST_F(ConvertTest, TakesPremultipliedColorsAsTheyAre) {
    const auto exr = converted(image<float>("p.exr", 1, 1, 4, {0.25f, 0.125f, 0, 0.5f}));
    EXPECT_EQ(level0(*exr), (std::vector<float>{0.75f, 0.625f, 0.5f, 0.5f}));
}

TEST_F(ConvertTest, ObeysExifOrientation) {
    // Upright picture, from the top: 1 2 3 / 4 5 6, stored turned in each of the eight ways.
    const std::vector<std::pair<int, std::vector<uint8_t>>> stored = {
        {1, {1, 2, 3, 4, 5, 6}}, {2, {3, 2, 1, 6, 5, 4}}, {3, {6, 5, 4, 3, 2, 1}},
        {4, {4, 5, 6, 1, 2, 3}}, {5, {1, 4, 2, 5, 3, 6}}, {6, {3, 6, 2, 5, 1, 4}},
        {7, {6, 3, 5, 2, 4, 1}}, {8, {4, 1, 5, 2, 6, 3}}};
    for (const auto& [orientation, bytes] : stored) {
        const bool turned = orientation >= 5;
        const auto file =
            image<uint8_t>("o.tif", turned ? 2 : 3, turned ? 3 : 2, 1, bytes, orientation);
        const auto p = converted(file, {"data", false});
        std::vector<int> got;
        for (float v : level0(*p))
            got.push_back(static_cast<int>(std::lround(v * 255)));
        EXPECT_EQ(got, (std::vector<int>{4, 5, 6, 1, 2, 3})) << orientation;
        EXPECT_EQ(p->info()[9], 3);
    }
}

TEST_F(ConvertTest, ReadsTiledImages) {
    std::vector<uint8_t> bytes(40 * 50);
    for (size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<uint8_t>(i * 7);
    const auto plain = converted(image<uint8_t>("p.tif", 40, 50, 1, bytes));
    const auto tiled = converted(image<uint8_t>("t.tif", 40, 50, 1, bytes, 1, 16));
    EXPECT_EQ(level0(*plain), level0(*tiled));
}

TEST_F(ConvertTest, SaysWhyAnImageCannotBeRead) {
    const std::filesystem::path out = folder_.path() / "out.oftx";
    const auto error_of = [&](const std::filesystem::path& file) {
        const Result<void> made = make_pyramid_file(file, out, {});
        EXPECT_FALSE(std::filesystem::exists(out));
        return made ? "no error" : made.error().text();
    };
    EXPECT_THAT(error_of(folder_.write("text.png", "no picture")),
                testing::Says(messages::kCannotReadBefore));
    EXPECT_THAT(error_of(folder_.write("x.unknown", "no picture")),
                testing::Says(messages::kCannotReadBefore));
    EXPECT_NE(error_of(folder_.path() / "none.png").find("none.png"), std::string::npos);
    const float nan = std::nanf("");
    EXPECT_THAT(error_of(image<float>("n.exr", 2, 1, 1, {0.0f, nan})),
                testing::Says(messages::kPixelNotFinite, "1", "0"));
    EXPECT_THAT(error_of(image<uint8_t>("five.tif", 1, 1, 5, {0, 0, 0, 0, 0})),
                testing::Says(messages::kPictureChannels, 5, "*"));
    EXPECT_THAT(error_of(image<uint8_t>("wide.tif", 16385, 1, 1, std::vector<uint8_t>(16385))),
                testing::Says(texture::messages::kPictureTooWideHelp, "16384"));
    // Truncated: the reader fails part way, and no file is left.
    const auto whole =
        image<uint8_t>("w.png", 300, 300, 3, std::vector<uint8_t>(300 * 300 * 3, 77));
    std::ifstream in(whole, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    EXPECT_NE(error_of(folder_.write("cut.png", bytes.substr(0, bytes.size() / 2))), "no error");
    EXPECT_FALSE(make_pyramid_file(whole, folder_.path() / "none" / "x.oftx", {}));
    EXPECT_FALSE(make_pyramid_file(whole, out, {"cmyk", false}));
}

TEST_F(ConvertTest, FindsThePyramidInTheCacheTheSecondTime) {
    const auto file = image<uint8_t>("g.png", 2, 2, 1, {0, 64, 128, 255});
    const auto first = texture::get_pyramid(file, {"auto", false}, 1, 0);
    ASSERT_TRUE(first) << first.error().text();
    EXPECT_EQ((*first)->texels()[0], decoded(128));
    ::unsetenv("OPENFAB_HELPER");
    EXPECT_TRUE(texture::get_pyramid(file, {"auto", false}, 2, 1)) << "must not need the helper";
    // Different options or bytes give different pyramids.
    const auto other = texture::get_pyramid(file, {"data", false}, 1, 0);
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error().text(), testing::Says(texture::messages::kNoConverter));
    ::setenv("OPENFAB_HELPER", testing::test_program("texture_test_helper").c_str(), 1);
    EXPECT_TRUE(texture::get_pyramid(file, {"data", true}, 1, 0));
    std::set<uint64_t> keys;
    for (const char* space : {"auto", "data", "srgb", "linear"}) {
        for (bool luminance : {false, true}) {
            keys.insert(*texture::content_key(file, {space, luminance}));
        }
    }
    EXPECT_EQ(keys.size(), 8u);
    // A damaged entry is regenerated.
    const std::filesystem::path entry =
        *texture::cache_folder() /
        texture::cache_name(*texture::content_key(file, {"auto", false}));
    std::filesystem::resize_file(entry, 80);
    EXPECT_TRUE(texture::get_pyramid(file, {"auto", false}, 1, 0));
}

TEST_F(ConvertTest, ChecksWithoutKeepingAnything) {
    EXPECT_TRUE(texture::check_picture(image<uint8_t>("g.png", 2, 2, 1, {0, 64, 128, 255})));
    const auto bad = folder_.write("bad.png", "no picture");
    const Result<void> checked = texture::check_picture(bad);
    ASSERT_FALSE(checked);
    EXPECT_TRUE(
        checked.error().text().starts_with(fmt::format(messages::kCannotReadBefore, bad.string())))
        << checked.error().text();
    // The header alone is right.
    const auto whole = image<uint8_t>("w.png", 300, 300, 3, std::vector<uint8_t>(270'000, 77));
    std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 2);
    EXPECT_FALSE(texture::check_picture(whole));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "cache" / "deep"));
}

TEST_F(ConvertTest, PassesTheHelpersReasonOn) {
    const auto bad = folder_.write("bad.png", "no picture");
    const auto failed = texture::get_pyramid(bad, {"auto", false}, 0, 0);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::kUserInput);
    EXPECT_TRUE(
        failed.error().text().starts_with(fmt::format(messages::kCannotReadBefore, bad.string())))
        << failed.error().text();
    EXPECT_NE(texture::get_pyramid(folder_.path() / "none.png", {}, 0, 0)
                  .error()
                  .text()
                  .find("No such file"),
              std::string::npos);
    EXPECT_FALSE(texture::get_pyramid(folder_.path(), {}, 0, 0));
    // Works without a usable cache.
    ::setenv("OPENFAB_CACHE", "/proc/nowhere", 1);
    const auto file = image<uint8_t>("g.png", 1, 1, 1, {9});
    EXPECT_TRUE(texture::get_pyramid(file, {"auto", false}, 0, 0));
}

TEST_F(ConvertTest, ReadsAPhotograph) {
    const std::filesystem::path photo =
        testing::source_dir() / "gallery/magic_postcard/foreground.jpg";
    const auto p = converted(photo, {"auto", true});
    EXPECT_EQ(p->channels(), 1);
    EXPECT_GT(p->levels(), 8);
    const float mean = p->texels().back();
    EXPECT_GT(mean, 0.02f);
    EXPECT_LT(mean, 0.98f);
}

}  // namespace
}  // namespace openfab::tools
