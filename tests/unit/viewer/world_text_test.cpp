// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/world_text.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using viewer::with_uniform;

std::string changed(const std::string& text, const std::string& object, const std::string& uniform,
                    const std::string& value) {
    const Result<std::string> made = with_uniform(text, "w", object, uniform, value);
    EXPECT_TRUE(made) << made.error().text();
    if (!made) return {};
    const Result<JsonValue> read = parse_json(*made, "w");
    EXPECT_TRUE(read) << read.error().text() << "\n" << *made;
    return *made;
}

TEST(WorldText, AValueIsReplacedAndNothingElse) {
    const std::string text =
        "{\n  \"t\": \"ä\\\"}{\",\n  \"objects\": { \"ä ö\" : {\"uniforms\":{ \"x\" :\t[1, [2]] "
        ",\"y\":-3e1}}}\n}\n";
    EXPECT_EQ(changed(text, "ä ö", "x", "[4]"),
              "{\n  \"t\": \"ä\\\"}{\",\n  \"objects\": { \"ä ö\" : {\"uniforms\":{ \"x\" :\t[4] "
              ",\"y\":-3e1}}}\n}\n");
    EXPECT_EQ(changed(text, "ä ö", "y", "true"),
              "{\n  \"t\": \"ä\\\"}{\",\n  \"objects\": { \"ä ö\" : {\"uniforms\":{ \"x\" :\t[1, "
              "[2]] ,\"y\":true}}}\n}\n");
}

TEST(WorldText, AStringWithQuotesAndBracesIsReplacedWhole) {
    EXPECT_EQ(
        changed(R"({"objects":{"o":{"uniforms":{"m":"a\\\"},{","n":1}}}})", "o", "m", "\"b\""),
        R"({"objects":{"o":{"uniforms":{"m":"b","n":1}}}})");
}

TEST(WorldText, ANewValueComesFirstSpacedAsTheOthers) {
    EXPECT_EQ(changed("{\"objects\": {\"o\": {\"uniforms\": {\n    \"a\": 1\n}}}}", "o", "b", "2"),
              "{\"objects\": {\"o\": {\"uniforms\": {\n    \"b\": 2,\n    \"a\": 1\n}}}}");
    EXPECT_EQ(changed(R"({"objects": {"o": {"uniforms": { }}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}}}})");
    EXPECT_EQ(changed(R"({"objects": {"o": {"mesh": "m"}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}, "mesh": "m"}}})");
    EXPECT_EQ(changed(R"({"objects": {"o": {}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}}}})");
}

TEST(WorldText, WhatIsNoWorldOrHasNoSuchObjectIsRefused) {
    for (const char* text :
         {"", "[", "[]", "{}", R"({"objects": 1})", R"({"objects": {"p": {}}})",
          R"({"objects": {"o": 1}})", R"({"objects": {"o": {"uniforms": 1}}})"}) {
        EXPECT_FALSE(with_uniform(text, "w.fab.json", "o", "u", "1")) << text;
    }
    EXPECT_THAT(with_uniform("{}", "w.fab.json", "o", "u", "1").error().text(),
                HasSubstr("w.fab.json"));
}

}  // namespace
}  // namespace openfab::testing
