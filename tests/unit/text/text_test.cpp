// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texts as meshes and pictures: the meshes are closed, the picture and the mesh, which two libraries
// fill, cover the same area, and what cannot be drawn is told.

#include "tests/support/places/places.h"
#include "tools/text/text_shapes.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numeric>

#include "mesh/load/load_mesh.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/text/messages.h"

namespace openfab::text {
namespace {

using ::testing::HasSubstr;

constexpr const char* kFont = "DejaVu Sans";

Layout layout_of(const std::string& words, double size_mm = 10, Align align = Align::kCenter,
                 const std::string& name = kFont) {
    const Result<std::unique_ptr<Font>> font = Font::open(name, size_mm);
    EXPECT_TRUE(font) << font.error().text();
    const Result<Layout> layout = lay_out(font->get(), words, align);
    EXPECT_TRUE(layout) << layout.error().text();
    return layout ? *layout : Layout();
}

std::string refusal(const std::string& words, const std::string& name = kFont) {
    const Result<std::unique_ptr<Font>> font = Font::open(name, 10);
    if (!font) return font.error().text();
    const Result<Layout> layout = lay_out(font->get(), words, Align::kCenter);
    return layout ? "fine" : layout.error().text();
}

TEST(Text, ACapitalHasItsSize) {
    const Layout h = layout_of("H", 7);
    EXPECT_NEAR(h.size_mm.y, 7, 1e-6);
    for (const mesh::Point2& p : h.areas[0][0])
        EXPECT_LE(std::abs(p.y), 3.5 + 1e-6) << "centred";
    EXPECT_EQ(layout_of("o").areas[0].size(), 2u) << "a hole";
    EXPECT_EQ(layout_of("Ada Lovelace").areas.size(), 11u) << "a space has no outline";
}

/// By the font's own tables: an H of DejaVu Sans is 1493 units high and advances by 1540.
TEST(Text, LettersAreApartAsTheFontSays) {
    const double one = layout_of("H", 10).size_mm.x;
    EXPECT_NEAR(layout_of("HHH", 10).size_mm.x - one, 2 * 10 * 1540.0 / 1493, 1e-5);
}

/// variable.ttf was made for this test, by fontTools: its A is an upright crossed by a bar, of which the
/// axis `wght` widens both by 200 units from 400 to 900.
TEST(Text, AxesOfAVariableFontAreSet) {
    const std::string font = (testing::source_dir() / "tests/unit/text/variable.ttf").string();
    const auto width = [&](const std::string& settings) {
        return layout_of("A", 7, Align::kCenter, font + settings).size_mm.x;
    };
    ::testing::internal::CaptureStderr();
    EXPECT_NEAR(width(""), 2.5, 1e-6);
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                testing::Says(messages::kVariableFont, "*", "wght 400 (400 to 900)"));
    ::testing::internal::CaptureStderr();
    EXPECT_NEAR(width(":wght=900"), 4.5, 1e-6);
    EXPECT_NEAR(width(":wght=650"), 3.5, 1e-6);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_THAT(refusal("A", font + ":wght=901"),
                ::testing::AllOf(testing::Says(messages::kNoSetting, "wght=901", font),
                                 testing::Says(messages::kFontSettings),
                                 HasSubstr("wght 400 (400 to 900)")));
    EXPECT_THAT(refusal("A", font + ":wdth=80"), testing::Says(messages::kNoSetting, "wdth=80"));
    EXPECT_THAT(refusal("A", font + ":bold"), testing::Says(messages::kNoSetting, "bold"));
    // Its outlines overlap, as those of variable fonts do; they are united.
    EXPECT_EQ(layout_of("A", 7, Align::kCenter, font + ":wght=900").areas[0].size(), 1u);
}

TEST(Text, KerningMovesLettersTogether) {
    const double apart = layout_of("HV").size_mm.x + layout_of("HA").size_mm.x;
    const double pairs = layout_of("HVA").size_mm.x + layout_of("H").size_mm.x;
    EXPECT_LT(pairs, apart - 0.3);
}

TEST(Text, LinesAreAligned) {
    const auto ends = [](const Layout& layout, size_t glyph) {
        double lo = 1e9, hi = -1e9;
        for (const mesh::Outline& outline : layout.areas[glyph]) {
            for (const mesh::Point2& p : outline) {
                lo = std::min(lo, p.x);
                hi = std::max(hi, p.x);
            }
        }
        return std::pair(lo, hi);
    };
    const std::string words = "HHH\n\nI";
    const Layout left = layout_of(words, 10, Align::kLeft);
    EXPECT_NEAR(ends(left, 0).first, ends(left, 3).first, 1e-9);
    const Layout right = layout_of(words, 10, Align::kRight);
    EXPECT_NEAR(ends(right, 2).second, ends(right, 3).second, 1e-9);
    const Layout center = layout_of(words);
    EXPECT_NEAR(ends(center, 3).first, -ends(center, 3).second, 1e-9);
    // Three baselines apart by twice the pitch, for the empty line.
    EXPECT_GT(center.size_mm.y, 10 + 2 * 10);
}

/// What FreeType's rasteriser covers is what our triangles cover.
TEST(Text, PictureAndMeshCoverTheSameArea) {
    for (const char* words : {"OpenFab", "8@%&Bg", "Ä\xC3\xA9\xC3\xB8 \xCE\xA9\xD0\x96"}) {
        const Layout layout = layout_of(words);
        const Result<mesh::Mesh> mesh = make_text_mesh(layout, 2);
        ASSERT_TRUE(mesh) << mesh.error().text();
        const double area = testing::signed_volume(*mesh) / 2;
        const double dots = 20;
        const Result<Picture> picture = draw_text(layout, dots, 0.5);
        ASSERT_TRUE(picture) << picture.error().text();
        const testing::ScratchFolder folder;
        folder.write("text.png", std::string(picture->png.begin(), picture->png.end()));
        const testing::ReadPng read = testing::read_png(folder / "text.png");
        ASSERT_EQ(read.width, picture->width);
        EXPECT_NEAR(read.pixels_per_metre_x, dots * 1000, 1);
        double covered = 0;
        for (const std::array<uint8_t, 4>& pixel : read.rgba)
            covered += pixel[0] / 255.0;
        EXPECT_NEAR(covered / (dots * dots), area, 2e-3 * area) << words;
        EXPECT_EQ(read.at(0, 0)[0], 0) << "a margin";
    }
}

TEST(Text, LettersThatOverlapAreOneArea) {
    // Arabic: two letters that are joined, three more, and the dot of one of them.
    const Layout joined = layout_of("\u0645\u0631\u062d\u0628\u0627");
    EXPECT_EQ(joined.areas.size(), 3U);
    const Result<mesh::Mesh> mesh = make_text_mesh(joined, 2);
    ASSERT_TRUE(mesh) << mesh.error().text();
    // No hairline crosses a stroke: along its middle, from end to end, all pixels are white.
    const Result<Picture> picture = draw_text(joined, 11.8, 0);
    ASSERT_TRUE(picture) << picture.error().text();
    const testing::ScratchFolder folder;
    folder.write("text.png", std::string(picture->png.begin(), picture->png.end()));
    const testing::ReadPng read = testing::read_png(folder / "text.png");
    double covered = 0;
    for (const std::array<uint8_t, 4>& pixel : read.rgba)
        covered += pixel[0] / 255.0;
    const double area = testing::signed_volume(*mesh) / 2;
    EXPECT_NEAR(covered / (11.8 * 11.8), area, 2e-3 * area);
    const double join = 2.85;  // mm below the middle: of the base line's stroke
    const int row = static_cast<int>(std::lround(read.height / 2.0 + join * 11.8));
    for (int x = read.width / 8; x < read.width / 4; ++x)
        EXPECT_EQ(read.at(x, row)[0], 255) << x;
}

TEST(Text, ATextOfTooManyCornersIsTold) {
    std::string words;
    for (int line = 0; line < 20; ++line)
        words += std::string(300, '@') + "\n";
    const Result<mesh::Mesh> mesh = make_text_mesh(layout_of(words), 2);
    ASSERT_FALSE(mesh);
    EXPECT_THAT(mesh.error().text(),
                ::testing::AllOf(testing::Says(messages::kTooManyCorners, "*", 1000000),
                                 testing::Says(messages::kTooManyCornersHelp)));
}

TEST(Text, AMeshIsClosedAndPrintable) {
    for (const char* name : {"DejaVu Sans:bold", "DejaVu Serif", "DejaVu Sans Mono"}) {
        std::string words;
        for (char c = '!'; c <= '~'; ++c)
            words += std::string(1, c) + (c % 16 == 0 ? "\n" : "");
        const Layout layout = layout_of(words, 10, Align::kCenter, name);
        const Result<mesh::Mesh> mesh = make_text_mesh(layout, 1.5);
        ASSERT_TRUE(mesh) << mesh.error().text();
        const testing::ScratchFolder folder;
        folder.write("text.obj", obj_text(*mesh));
        const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(folder / "text.obj", {});
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_TRUE(loaded->checks.edges.fine());
        EXPECT_EQ(loaded->checks.turned, 0);
        EXPECT_NEAR(testing::signed_volume(loaded->mesh), testing::signed_volume(*mesh), 1e-2);
        ASSERT_EQ(loaded->groups.size(), 3u);
        EXPECT_EQ(loaded->groups[2].first, "side");
        const mesh::MeshAttribute* uv = loaded->mesh.find("uv");
        ASSERT_NE(uv, nullptr);
        for (const float value : uv->values)
            ASSERT_TRUE(value >= -1e-6F && value <= 1 + 1e-6F) << value;
    }
}

TEST(Text, WhatCannotBeDrawnIsTold) {
    EXPECT_EQ(refusal("fine"), "fine");
    EXPECT_THAT(refusal("a\xE6\xBC\xA2"
                        "b"),
                ::testing::AllOf(testing::Says(messages::kFontHasNo, "*", "\xE6\xBC\xA2"),
                                 testing::Says(messages::kChooseAnotherFont)));
    EXPECT_THAT(refusal(" \n "), testing::Says(messages::kNoLetters));
    EXPECT_THAT(refusal("a\xFF"), testing::Says(messages::kNotUtf8));
    EXPECT_THAT(refusal("a", "./none.ttf"), testing::Says(messages::kNoFontFile));
    const testing::ScratchFolder folder;
    folder.write("not.ttf", "not a font");
    EXPECT_THAT(refusal("a", (folder / "not.ttf").string()), testing::Says(messages::kNotAFont));
    EXPECT_THAT(refusal("a", "No Such Family:bold"),
                testing::Says(messages::kNoFontFamily, "No Such Family"));
    EXPECT_THAT(refusal("a", "sans-serif:blod"), testing::Says(messages::kNoStyle, "blod"));
    EXPECT_TRUE(Font::open("Sans:bold", 5));
    const Result<Picture> large = draw_text(layout_of("wide"), 4000, 0);
    ASSERT_FALSE(large);
    EXPECT_THAT(large.error().text(), testing::Says(messages::kPictureTooLarge, "*", "*", "16000"));
}

TEST(Text, IsACommandOfTheTool) {
    const testing::ScratchFolder folder;
    const auto text = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {testing::program("openfab"), "text"});
        testing::RunOptions options;
        options.folder = folder.path();
        return testing::run(arguments, options);
    };
    const testing::Outcome made = text({"Ada", "-o", "a.obj", "--font", kFont, "--size", "5mm"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    EXPECT_THAT(made.out, HasSubstr("a.obj: "));
    EXPECT_THAT(made.out, HasSubstr("x 5."));  // the d is taller than the A
    EXPECT_EQ(text({"Ada", "-o", "a.png", "--margin", "1mm"}).exit_code, 0);
    for (const std::vector<std::string>& wrong : {std::vector<std::string>{"Ada", "-o", "a.pdf"},
                                                  {"Ada", "-o", "a.obj", "--size", "5"},
                                                  {"Ada", "-o", "a.obj", "--depth", "0mm"},
                                                  {"-o", "a.obj"},
                                                  {"Ada"}}) {
        const testing::Outcome outcome = text(wrong);
        EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
        EXPECT_THAT(outcome.err, HasSubstr("error: "));
    }
}

}  // namespace
}  // namespace openfab::text
