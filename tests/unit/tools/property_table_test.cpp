// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/property_table.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace openfab::tools {
namespace {

using ::testing::HasSubstr;

std::string table(const std::string& rows, const std::string& more = {}) {
    return R"({"property": "hardness", "unit": "Shore A", "materials": ["soft", "hard"],
               "measured": true, "source": "a laboratory",)" +
           more + R"("rows": [)" + rows + "]}";
}
std::string row(const std::string& mixture, const std::string& value) {
    return R"({"mixture": [)" + mixture + R"(], "value": )" + value + "}";
}

TEST(PropertyTable, IsAModuleOfConstants) {
    const Result<std::string> module = property_module(
        table(row("1, 0", "30") + "," + row("0.5, 0.5", "62.5") + "," + row("0, 1", "95")),
        "tables/shore_a.json");
    ASSERT_TRUE(module) << module.error().text();
    EXPECT_THAT(*module, HasSubstr("// Made of shore_a.json by `openfab property`"));
    EXPECT_THAT(*module,
                HasSubstr("// The hardness of mixtures of soft, hard, in Shore A, measured.\n"));
    EXPECT_THAT(*module, HasSubstr("// Source: a laboratory\n"));
    EXPECT_THAT(*module,
                HasSubstr("const PropertyTable SHORE_A = {\n    3,\n    {30, 62.5, 95, 0, "));
    EXPECT_THAT(*module, HasSubstr("{{1, 0, 0, 0}, {0.5, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0},"));
    EXPECT_THAT(*module, HasSubstr("const float SHORE_A_LOWEST = 30, SHORE_A_HIGHEST = 95;\n"));
    // Falling values are as good.
    const Result<std::string> falling =
        property_module(table(row("1, 0", "5") + "," + row("0, 1", "-3")), "x.json");
    ASSERT_TRUE(falling);
    EXPECT_THAT(*falling, HasSubstr("X_LOWEST = -3, X_HIGHEST = 5;"));
}

TEST(PropertyTable, OfTheGalleryIsWhatItsModuleSays) {
    const std::string folder = testing::source_dir() / "gallery/insole/";
    const auto contents = [&](const std::string& name) {
        std::ifstream in(folder + name);
        return std::string{std::istreambuf_iterator<char>(in), {}};
    };
    const Result<std::string> module =
        property_module(contents("modulus.json"), folder + "modulus.json");
    ASSERT_TRUE(module) << module.error().text();
    EXPECT_EQ(*module, contents("modulus.fl"));
}

TEST(PropertyTable, SaysWhereItIsWrong) {
    const auto trouble = [](const std::string& text, const std::string& file = "t.json") {
        const Result<std::string> module = property_module(text, file);
        return module ? "no error" : module.error().text();
    };
    const std::string good = row("1, 0", "1") + "," + row("0, 1", "2");
    EXPECT_EQ(trouble(table(good)), "no error");
    EXPECT_THAT(trouble("["), HasSubstr("t.json:1:"));
    EXPECT_THAT(trouble(table(good, R"("uint": "MPa",)")),
                testing::Says(messages::kNoKeyOfTable, "uint"));
    EXPECT_THAT(trouble(R"({"property": "x"})"), testing::Says(messages::kKeyMissing, "unit"));
    EXPECT_THAT(trouble(table(row("1, 0", "1"))), testing::Says(messages::kRowCount, "1", "16"));
    EXPECT_THAT(trouble(table(good + "," + row("0.5, 0.5", "1.5"))),
                testing::Says(messages::kValuesNotMonotonic, "3", "1.5", "2"));
    EXPECT_THAT(trouble(table(row("1, 0", "1") + "," + row("0, 1", "1"))),
                testing::Says(messages::kValuesNotMonotonic, "2", "1", "1"));
    EXPECT_THAT(trouble(table(row("1, 0", "1") + "," + row("0, 0.9", "2"))),
                testing::Says(messages::kFractionSum, "0.9"));
    EXPECT_THAT(trouble(table(row("1, 0", "1") + "," + row("1", "2"))),
                testing::Says(messages::kFractionCount, "1", "2"));
    EXPECT_THAT(trouble(table(row("2, -1", "1") + "," + row("0, 1", "2"))),
                testing::Says(messages::kFractionOutside));
    EXPECT_THAT(trouble(table(good), "1st.json"),
                testing::Says(messages::kCannotNameConstants, "1st"));
}

TEST(PropertyTable, OfASweepIsAFunctionOfWhatIsWanted) {
    const auto sweep = [](const std::string& rows) {
        return property_module(R"({"property": "Young's modulus along x", "unit": "MPa",
                                   "parameter": "wall", "rows": [)" +
                                   rows + "]}",
                               "gyroid.json");
    };
    const Result<std::string> module = sweep(
        R"({"at": 0.8, "value": 200}, {"at": 1.4, "value": 500, "residual": 1e-7}, {"at": 2, "value": 900})");
    ASSERT_TRUE(module) << module.error().text();
    EXPECT_THAT(*module, HasSubstr("float gyroid_wall(float value)"));
    EXPECT_THAT(*module, HasSubstr("const float GYROID_LOWEST = 200, GYROID_HIGHEST = 900;"));
    EXPECT_THAT(*module, HasSubstr("part = saturate((value - 200) / (500 - 200));\n"
                                   "    if (part > 0) at = lerp(0.8, 1.4, part);"));
    const Result<std::string> bent =
        sweep(R"({"at": 1, "value": 2}, {"at": 2, "value": 3}, {"at": 3, "value": 1})");
    ASSERT_FALSE(bent);
    EXPECT_THAT(bent.error().text(), testing::Says(messages::kValuesNotMonotonic, "3", "1", "3"));
    const Result<std::string> one = sweep(R"({"at": 1, "value": 2})");
    ASSERT_FALSE(one);
    EXPECT_THAT(one.error().text(), testing::Says(messages::kSweepRows, "64"));
}

}  // namespace
}  // namespace openfab::tools
