// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/json.h"

#include <gtest/gtest.h>

#include "runtime/base/caret.h"
#include "runtime/base/near_miss.h"
#include "tests/support/meshes/temp_folder.h"

namespace openfab::scene {
namespace {

std::string error_of(std::string_view text) {
    const Result<JsonValue> parsed = parse_json(text, "f.json");
    return parsed ? "no error" : parsed.error().message;
}

TEST(Json, KnowsWhereEveryTokenStands) {
    const Result<JsonValue> root = parse_json(
        "{\n  \"a\" : [1, -2.5e1 , \"x\"],\n\t\"\xC3\xA4\":{\"b\":true},\"c\":null}\n", "f");
    ASSERT_TRUE(root) << root.error().message;
    ASSERT_EQ(root->members.size(), 3u);
    const JsonMember& a = root->members[0];
    EXPECT_EQ(a.line, 2);
    EXPECT_EQ(a.column, 3);
    EXPECT_EQ(a.value.column, 9);
    EXPECT_EQ(a.value.items[0].column, 10);
    EXPECT_EQ(a.value.items[1].column, 13);
    EXPECT_EQ(a.value.items[1].number, -25);
    EXPECT_EQ(a.value.items[2].column, 22);
    const JsonMember& umlaut = root->members[1];
    EXPECT_EQ(umlaut.line, 3);
    EXPECT_EQ(umlaut.column, 2);
    // Columns count code points: the key has three, quotes included.
    EXPECT_EQ(umlaut.value.column, 6);
    EXPECT_EQ(umlaut.value.members[0].column, 7);
    EXPECT_EQ(umlaut.value.members[0].value.column, 11);
    EXPECT_EQ(root->members[2].column, 17);
    EXPECT_EQ(root->members[2].value.column, 21);
}

TEST(Json, RefusesWhatIsNotStrict) {
    EXPECT_EQ(error_of("{\"a\": 1,\n \"b\": 2,\n \"a\": 3}"),
              "f.json:3:2: duplicate key `a`; it is first given at line 1");
    EXPECT_EQ(error_of("{\"a\": 1} x").substr(0, 29), "f.json:1:10: not valid JSON; ");
    EXPECT_EQ(error_of("{\"a\": 1, // no\n}").substr(0, 28), "f.json:1:10: not valid JSON;");
    EXPECT_EQ(error_of("{\"a\": 1,}").substr(0, 27), "f.json:1:9: not valid JSON;");
    EXPECT_NE(error_of("[1e999]").find("not valid JSON"), std::string::npos);
    EXPECT_NE(error_of("[NaN]").find("f.json:1:2: not valid JSON"), std::string::npos);
    EXPECT_NE(error_of("\"\xFF\"").find("not valid JSON"), std::string::npos);
    EXPECT_EQ(error_of(std::string_view("{\n\0}", 4)),
              "f.json:2:1: a zero byte; the file is not text");
    EXPECT_NE(error_of("").find("f.json:1:1: not valid JSON"), std::string::npos);
}

TEST(Json, LimitsDepth) {
    EXPECT_EQ(error_of(std::string(32, '[') + std::string(32, ']')), "no error");
    EXPECT_EQ(error_of(std::string(33, '[') + std::string(33, ']')),
              "f.json:1:33: nested more than 32 levels deep");
    EXPECT_EQ(error_of(std::string(10'000'000, '[')),
              "f.json:1:33: nested more than 32 levels deep");
}

TEST(Json, SurvivesEveryTruncation) {
    const std::string text =
        R"({"a": [1, 2.5, "x\u00e4y", {"b": [true, null]}], "c": {"d": -1e-3}})";
    ASSERT_EQ(error_of(text), "no error");
    for (size_t n = 0; n < text.size(); ++n) {
        EXPECT_TRUE(error_of(text.substr(0, n)).starts_with("f.json:1:")) << n;
        std::string damaged = text;
        for (char c : {'\x01', '{', ']', '"', '\xC3'}) {
            damaged[n] = c;
            (void)error_of(damaged);  // any answer but a crash
        }
    }
}

TEST(Caret, PointsAtTheToken) {
    const testing::TempFolder folder;
    const std::string file = folder.write("w.json", "{\n\t\"\xC3\xA4\": \"b c\"\n}\n").string();
    EXPECT_EQ(render_error(user_error(file + ":2:7: what is wrong; do this; and that")),
              file +
                  ":2:7: error: what is wrong\n 2 |  \"\xC3\xA4\": \"b c\"\n   |       "
                  "^~~~~\nhelp: do this; and that\n");
    EXPECT_EQ(render_error(user_error("no place: 3:4 here")), "error: no place: 3:4 here\n");
    EXPECT_EQ(render_error(user_error("/nowhere/x:1:2: oh")), "/nowhere/x:1:2: error: oh\n");
}

TEST(NearMiss, IsUniqueOrNothing) {
    EXPECT_EQ(near_miss("scael", {"scale", "matrix"}), "scale");
    EXPECT_EQ(near_miss("materail", {"material", "materials"}), "material");
    EXPECT_EQ(near_miss("ab", {"ac", "ad"}), "");
    EXPECT_EQ(near_miss("zzz", {"scale", "matrix"}), "");
    EXPECT_EQ(suggest("zzz", {"a", "b"}), "known: `a`, `b`");
    EXPECT_EQ(suggest("zzz", {}), "there are none");
}

}  // namespace
}  // namespace openfab::scene
