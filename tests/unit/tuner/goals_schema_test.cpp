// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The schema of goals, and their page, against the reader's tables.

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "base/json.h"
#include "tests/support/places/places.h"
#include "tools/fit/goal_keys.h"

namespace openfab::fit {
namespace {

TEST(GoalsSchema, KnowsTheKeysOfTheReader) {
    const std::filesystem::path file = testing::source_dir() / "tools/fit/fab_fit.schema.json";
    const Result<std::string> text = read_text_file(file, 1'000'000);
    ASSERT_TRUE(text);
    const Result<JsonValue> root = parse_json(*text, file.string());
    ASSERT_TRUE(root) << root.error().text();
    for (const world::KeySet* set : {&kFileKeys, &kUnknownKeys, &kGoalKeys}) {
        const JsonValue& kind =
            set == &kFileKeys ? *root : root->find("$defs")->value.find(set->kind)->value;
        std::set<std::string> keys, required;
        for (const JsonMember& member : kind.find("properties")->value.members)
            keys.insert(member.key);
        EXPECT_EQ(keys, std::set<std::string>(set->keys.begin(), set->keys.end())) << set->kind;
        if (const JsonMember* list = kind.find("required")) {
            for (const JsonValue& item : list->value.items)
                required.insert(item.text);
        }
        EXPECT_EQ(required, std::set<std::string>(set->required.begin(), set->required.end()));
        EXPECT_FALSE(kind.find("additionalProperties")->value.boolean) << set->kind;
    }
}

TEST(GoalsSchema, ThePageHasAllKeysOfGoals) {
    const Result<std::string> page =
        read_text_file(testing::source_dir() / "docs/how-to/fit.md", 1'000'000);
    ASSERT_TRUE(page);
    for (const std::string_view key : kGoalKeys.keys)
        EXPECT_NE(page->find("`" + std::string(key) + "`"), std::string::npos) << key;
}

}  // namespace
}  // namespace openfab::fit
