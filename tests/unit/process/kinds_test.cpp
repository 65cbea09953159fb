// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/kinds/kinds.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "world/messages.h"

namespace openfab::process {
namespace {

using testing::Says;

Result<world::Process> process_of(const std::string& text) {
    const testing::TempFolder folder;
    return world::load_process(folder.write("machine.json", text), {});
}

TEST(Effects, HaveKeysAndOptionsOfTheirOwn) {
    std::set<std::string_view> keys, options;
    for (const std::string_view key : world::process_keys())
        keys.insert(key);
    for (const Kind* kind : kinds()) {
        EXPECT_TRUE(keys.insert(kind->key).second) << kind->key;
        const Option& option = kind->option;
        if (option.name.empty()) continue;
        EXPECT_TRUE(options.insert(option.name).second) << option.name;
        EXPECT_EQ(find_option(option.name), kind);
        for (const std::string_view usual : {option.usual, option.usual_as_built}) {
            EXPECT_EQ(option.choices.empty(), usual.empty());
            EXPECT_TRUE(usual.empty() || std::ranges::count(option.choices, usual) == 1) << usual;
        }
    }
    EXPECT_EQ(find_option(""), nullptr);
    EXPECT_EQ(find_option("--process"), nullptr);
}

TEST(Effects, AreReadWithTheirPlaces) {
    const Result<world::Process> process = process_of(R"({"scale": 1.01,
  "bled": {}})");
    ASSERT_TRUE(process) << process.error().text();
    const auto unknown = read_effects(*process);
    ASSERT_FALSE(unknown);
    EXPECT_THAT(unknown.error().text(), Says(world::messages::kUnknownKey, "bled", "`process`"));
    EXPECT_NE(unknown.error().text().find("machine.json:2:3"), std::string::npos);
    EXPECT_NE(unknown.error().text().find("`bleed`"), std::string::npos);
    const auto wrong = read_effects(*process_of("{\"bleed\": {\n \"sigma_um\": -1}}"));
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().text().find("machine.json:2:14"), std::string::npos);
    const auto fine = read_effects(*process_of(R"({"cost": {"price_ml": 1}})"));
    ASSERT_TRUE(fine);
    EXPECT_EQ(fine->size(), kinds().size());
}

// Entries of `--process` replace those of the profile, one by one.
TEST(Effects, OfAFileReplaceThoseOfTheProfile) {
    const Result<world::Process> profile = process_of(R"({"bleed": {"steps": 1}, "dead": []})");
    ASSERT_TRUE(profile);
    const testing::TempFolder folder;
    const Result<world::Process> both =
        world::load_process(folder.write("b.json", R"({"bleed": {"steps": 2}})"), *profile);
    ASSERT_TRUE(both);
    ASSERT_EQ(both->effects.size(), 2u);
    EXPECT_EQ(both->effects[0].member.key, "dead");
    EXPECT_EQ(both->effects[1].member.value.find("steps")->value.number, 2);
    EXPECT_TRUE(both->effects[1].file.ends_with("b.json"));
}

}  // namespace
}  // namespace openfab::process
