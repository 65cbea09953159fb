// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/optics.h"
#include "tools/render/messages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "tests/support/says/says.h"
#include "tests/unit/render/render_fixture.h"

namespace openfab::testing {
namespace {

using render::MaterialOptics;
using render::Optics;
using render::OpticsTable;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Optics, ReadsNumbersForAllChannelsOrThree) {
    const Result<OpticsTable> table = render::parse_optics(R"({
        "openfab_optics": 1,
        "source": "a test",
        "surface": {"refractive_index": 1.4, "roughness": 0.25},
        "materials": {"Jelly": {"also": ["gel"], "extinction_per_mm": 2, "albedo": [0.1, 0.2, 0.3], "anisotropy": 0.5}}
    })",
                                                           "x.json");
    ASSERT_TRUE(table) << table.error().text();
    EXPECT_EQ(table->surface.refractive_index, 1.4);
    EXPECT_EQ(table->surface.roughness, 0.25);
    const MaterialOptics expected{{2, 2, 2}, {0.1, 0.2, 0.3}, 0.5};
    ASSERT_NE(table->find("jelly"), nullptr);
    EXPECT_EQ(*table->find("jelly"), expected);
    EXPECT_EQ(*table->find("GEL"), expected);
    EXPECT_EQ(table->find("water"), nullptr);
}

TEST(Optics, TellsWhatIsWrongAndWhere) {
    const auto material = [](const std::string& members) {
        return "{\"openfab_optics\": 1, \"materials\": {\"a\": {" + members + "}}}";
    };
    const std::vector<std::pair<std::string, std::string>> cases{
        {"[]", render::messages::kFileMustHoldObject},
        {"{}", render::messages::kNotOptics},
        {"{\"openfab_optics\": 1, \"colors\": 1}",
         "1:23: " + fmt::format(render::messages::kUnknownKey, "colors")},
        {"{\"openfab_optics\": 1, \"surface\": {\"refractive_index\": 0.5}}",
         fmt::format(render::messages::kNumberBetween, "{}", 1, 3)},
        {"{\"openfab_optics\": 1, \"surface\": 3}", render::messages::kSurfaceIsObject},
        {"{\"openfab_optics\": 1, \"materials\": {\"a\": 1}}",
         fmt::format(render::messages::kIsAnObject, "a")},
        {material("\"albedo\": 0.5"),
         fmt::format(render::messages::kKeyMissing, "extinction_per_mm")},
        {material("\"extinction_per_mm\": -1, \"albedo\": 0.5"), render::messages::kNumberBetween},
        {material("\"extinction_per_mm\": [1, 2], \"albedo\": 0.5"),
         render::messages::kNumberOrThree},
        {material("\"extinction_per_mm\": 1, \"albedo\": 1.5"),
         fmt::format(render::messages::kNumberBetween, "{}", 0, 1)},
        {material("\"extinction_per_mm\": 1, \"albedo\": 1, \"anisotropy\": 1"), "`anisotropy`"},
    };
    for (const auto& [text, message] : cases) {
        const Result<OpticsTable> table = render::parse_optics(text, "x.json");
        ASSERT_FALSE(table) << text;
        EXPECT_THAT(table.error().text(), testing::Says(message)) << text;
        EXPECT_THAT(table.error().text(), HasSubstr("x.json")) << text;
    }
}

TEST(Optics, LooksInTheOwnFileFirst) {
    pipeline::PrintInfo info;
    info.materials = {
        {"VeroWhite"}, {"VeroCyan"}, {"Unobtainium", {}, {255, 0, 0, 255}}, {"SUP706"}};
    info.support_code = 4;
    const Result<OpticsTable> own = render::parse_optics(
        R"({"openfab_optics": 1, "materials": {"verocyan": {"extinction_per_mm": 1, "albedo": 0}}})",
        "x.json");
    ASSERT_TRUE(own);
    const Optics optics = render::optics_of(info, &*own);
    ASSERT_EQ(optics.by_code.size(), 5u);
    EXPECT_EQ(optics.by_code[1], *render::builtin_optics().find("VeroWhite"));
    EXPECT_EQ(optics.by_code[2].extinction[0], 1);
    // Support is washed off: nothing has to be known of it.
    EXPECT_THAT(optics.guessed, ElementsAre("Unobtainium"));
    EXPECT_GT(optics.by_code[3].albedo[0], 0.99);
    EXPECT_EQ(optics.by_code[3].albedo[1], 0);
}

TEST(Optics, GuessesClearOnesAsThin) {
    const MaterialOptics clear = render::guess_optics({250, 253, 255, 5}, {1.5, 0});
    const MaterialOptics opaque = render::guess_optics({250, 253, 255, 255}, {1.5, 0});
    EXPECT_LT(clear.extinction[0], 0.03);
    EXPECT_GE(opaque.extinction[0], 10);
}

TEST(Optics, OfMixturesAreWhatLightMeetsInTheMean) {
    const MaterialOptics white{{9, 8, 6}, {1, 0.9, 0.5}, 0.3};
    const MaterialOptics black{{3, 4, 6}, {0, 0, 0.5}, -0.1};
    const Optics own = make_optics({{}, white, black});
    const Optics mixed = render::optics_of_mixtures(own, {2, 3}, {{}, {1, 2}, {0, 3}, {3, 0}});
    ASSERT_EQ(mixed.by_code.size(), 4u);
    EXPECT_EQ(mixed.by_code[0], MaterialOptics());
    EXPECT_NEAR(mixed.by_code[1].extinction[0], (9 + 2 * 3) / 3.0, 1e-12);
    EXPECT_NEAR(mixed.by_code[1].albedo[0], 9.0 / (9 + 2 * 3), 1e-12);
    EXPECT_NEAR(mixed.by_code[1].albedo[1], 0.9 * 8 / (8 + 2 * 4), 1e-12);
    EXPECT_NEAR(mixed.by_code[1].albedo[2], 0.5, 1e-12);
    const double of_white = 9 + 0.9 * 8 + 0.5 * 6;
    const double of_black = 2 * 0.5 * 6;
    EXPECT_NEAR(mixed.by_code[1].anisotropy,
                (0.3 * of_white - 0.1 * of_black) / (of_white + of_black), 1e-12);
    EXPECT_NEAR(mixed.by_code[3].albedo[1], 0.9, 1e-12);
    EXPECT_NEAR(mixed.by_code[2].anisotropy, -0.1, 1e-12);
}

}  // namespace
}  // namespace openfab::testing
