// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The schema and the page of worlds against the loader's tables.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/input_file.h"
#include "base/json.h"
#include "tests/support/places/places.h"
#include "world/primitive_reader.h"
#include "world/world_keys.h"

namespace openfab::world {
namespace {

Result<JsonValue> schema() {
    const std::filesystem::path file = testing::source_dir() / "world/fab_world.schema.json";
    const Result<std::string> text = read_text_file(file, 1'000'000);
    if (!text) return text.error();
    return parse_json(*text, file.string());
}

std::set<std::string> keys_of(const JsonValue& value) {
    std::set<std::string> keys;
    for (const JsonMember& m : value.members)
        keys.insert(m.key);
    return keys;
}

TEST(WorldSchema, KnowsTheKeysOfTheLoader) {
    const Result<JsonValue> root = schema();
    ASSERT_TRUE(root) << root.error().text();
    for (const KeySet& set : world_key_sets()) {
        const JsonValue* kind = &*root;
        if (set.kind != "world") {
            const JsonMember* found = root->find("$defs")->value.find(set.kind);
            ASSERT_NE(found, nullptr) << set.kind;
            kind = &found->value;
        }
        EXPECT_EQ(keys_of(kind->find("properties")->value),
                  std::set<std::string>(set.keys.begin(), set.keys.end()))
            << set.kind;
        std::set<std::string> required;
        if (const JsonMember* list = kind->find("required")) {
            for (const JsonValue& item : list->value.items)
                required.insert(item.text);
        }
        EXPECT_EQ(required, std::set<std::string>(set.required.begin(), set.required.end()))
            << set.kind;
        EXPECT_FALSE(kind->find("additionalProperties")->value.boolean) << set.kind;
    }
}

/// Whether a value may be a path.
bool is_path(const JsonValue& property) {
    if (const JsonMember* format = property.find("format")) return format->value.text == "path";
    const JsonMember* any = property.find("anyOf");
    return any != nullptr && std::ranges::any_of(any->value.items, is_path);
}

/// What WorldEdit::relocate changes. A new key that is a path is one in both, or this fails.
TEST(WorldSchema, KnowsThePathsOfTheTable) {
    const Result<JsonValue> root = schema();
    ASSERT_TRUE(root) << root.error().text();
    const std::map<std::string_view, std::string_view> kinds = {
        {"fablets", "fablet"}, {"dither", "dither"},    {"textures", "texture"}, {"meshes", "mesh"},
        {"objects", "object"}, {"groups", "placement"}, {"build", "placement"}};
    std::set<std::pair<std::string, std::string>> expected, found;
    for (const WorldPath& path : world_paths()) {
        const bool of_root = path.keys.size() == 1;
        expected.emplace(of_root ? "world" : kinds.at(path.keys.front()), path.keys.back());
    }
    for (const KeySet& set : world_key_sets()) {
        const JsonValue& kind =
            set.kind == "world" ? *root : root->find("$defs")->value.find(set.kind)->value;
        for (const JsonMember& property : kind.find("properties")->value.members) {
            if (is_path(property.value)) found.emplace(set.kind, property.key);
        }
    }
    EXPECT_EQ(found, expected);
}

/// Else an editor marks a mesh of that primitive as wrong.
TEST(WorldSchema, AMeshHasOneSource) {
    const Result<JsonValue> root = schema();
    ASSERT_TRUE(root) << root.error().text();
    std::set<std::string> expected(primitive_keys().begin(), primitive_keys().end());
    expected.insert({"file", "beams", "shape", "grow", "program"});
    std::set<std::string> sources;
    for (const JsonValue& one :
         root->find("$defs")->value.find("mesh")->value.find("oneOf")->value.items)
        sources.insert(one.find("required")->value.items.at(0).text);
    EXPECT_EQ(sources, expected);
}

TEST(WorldsPage, NamesThePrimitives) {
    const Result<std::string> page =
        read_text_file(testing::source_dir() / "world/WORLDS.md", 1'000'000);
    ASSERT_TRUE(page);
    for (const std::string& key : primitive_keys())
        EXPECT_NE(page->find("`" + key), std::string::npos) << key;
}

}  // namespace
}  // namespace openfab::world
