// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/edit/world_edit.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using world::WorldEdit;

std::string changed(const std::string& text, const std::string& object, const std::string& uniform,
                    const std::string& value) {
    Result<WorldEdit> edit = WorldEdit::of_text(text, "w");
    EXPECT_TRUE(edit) << edit.error().text();
    if (!edit) return {};
    const Result<void> set = edit->set_uniform(object, uniform, value);
    EXPECT_TRUE(set) << set.error().text();
    return edit->text();
}

TEST(WorldEdit, AValueIsReplacedAndNothingElse) {
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

TEST(WorldEdit, AStringWithQuotesAndBracesIsReplacedWhole) {
    EXPECT_EQ(
        changed(R"({"objects":{"o":{"uniforms":{"m":"a\\\"},{","n":1}}}})", "o", "m", "\"b\""),
        R"({"objects":{"o":{"uniforms":{"m":"b","n":1}}}})");
}

TEST(WorldEdit, ANewValueComesFirstSpacedAsTheOthers) {
    EXPECT_EQ(changed("{\"objects\": {\"o\": {\"uniforms\": {\n    \"a\": 1\n}}}}", "o", "b", "2"),
              "{\"objects\": {\"o\": {\"uniforms\": {\n    \"b\": 2,\n    \"a\": 1\n}}}}");
    EXPECT_EQ(changed(R"({"objects": {"o": {"uniforms": { }}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}}}})");
    EXPECT_EQ(changed(R"({"objects": {"o": {"mesh": "m"}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}, "mesh": "m"}}})");
    EXPECT_EQ(changed(R"({"objects": {"o": {}}})", "o", "b", "2"),
              R"({"objects": {"o": {"uniforms": {"b": 2}}}})");
}

TEST(WorldEdit, WhatIsNoWorldOrHasNoSuchObjectIsRefused) {
    for (const char* text :
         {"", "[", "[]", "{}", R"({"objects": 1})", R"({"objects": {"p": {}}})",
          R"({"objects": {"o": 1}})", R"({"objects": {"o": {"uniforms": 1}}})"}) {
        Result<WorldEdit> edit = WorldEdit::of_text(text, "w.fab.json");
        if (!edit) continue;
        const Result<void> set = edit->set_uniform("o", "u", "1");
        ASSERT_FALSE(set) << text;
        EXPECT_THAT(set.error().text(), HasSubstr("w.fab.json"));
        EXPECT_EQ(edit->text(), text);
    }
    EXPECT_THAT(WorldEdit::of_text("[]", "w.fab.json").error().text(), HasSubstr("w.fab.json"));
}

TEST(WorldEdit, AValueThatIsNoJsonChangesNothing) {
    const std::string text = R"({"objects": {"o": {}}, "meshes": {"m": 1}})";
    Result<WorldEdit> edit = WorldEdit::of_text(text, "w");
    ASSERT_TRUE(edit);
    EXPECT_FALSE(edit->set_entry("meshes", "n", "{"));
    EXPECT_EQ(edit->text(), text);
    ASSERT_TRUE(edit->set_entry("meshes", "n", "2"));
    EXPECT_EQ(edit->text(), R"({"objects": {"o": {}}, "meshes": {"n": 2, "m": 1}})");
}

TEST(WorldEdit, EntriesMeshesAndNamesOfUniforms) {
    Result<WorldEdit> edit = WorldEdit::of_text(
        R"({"objects": {"o": {"mesh":"a", "uniforms": {"from" : 3, "mid": "from"}}}})", "w");
    ASSERT_TRUE(edit);
    ASSERT_TRUE(edit->set_of_object("o", "mesh", "\"b\""));
    ASSERT_TRUE(edit->set_entry("textures", "t", R"({"file": "a.png"})"));
    ASSERT_TRUE(edit->rename_uniform("objects", "o", "from", "to"));
    ASSERT_TRUE(edit->rename_uniform("objects", "o", "none", "to"));
    EXPECT_EQ(
        edit->text(),
        R"({"textures": {"t": {"file": "a.png"}}, "objects": {"o": {"mesh":"b", "uniforms": {"to" : 3, "mid": "from"}}}})");
    EXPECT_FALSE(edit->set_of_object("p", "mesh", "\"b\""));
    EXPECT_FALSE(edit->set_entry("objects", "o", ""));
}

// All paths of worlds, and nothing that looks like one.
TEST(WorldEdit, PathsCountFromAnotherFolder) {
    Result<WorldEdit> edit = WorldEdit::of_text(R"({
  "openfab": 1, "printer": "own.printer.json",
  "fablets": {"file": {"source": "a.fl", "fablet": "file", "uniforms": {"source": "file"}}},
  "dither": {"source": "d.fl", "rule": "a.fl"},
  "materials": {"source": {"key": "#102030"}},
  "textures": {"t": {"file": "p ä/\"q\".png"}, "abs": {"file": "/tmp/x.nrrd", "field": "a.vtu"}},
  "meshes": {"m": {"file": "../m.obj"}, "b": {"beams": "b.txt"}, "c": {"box": [1, 2, 3]}},
  "objects": {"o": {"mesh": "file", "fablet": "file", "pieces": "o.cuts.json", "uniforms": {"file": "source"}},
    "p": {"mesh": "c", "fablet": "file", "pieces": {"normal": [1, 0, 0], "at_mm": 0}}},
  "groups": {"g": [{"object": "o", "transforms": "g.txt"}]},
  "build": [{"group": "g", "transforms": "b.txt"}]
})",
                                                "w");
    ASSERT_TRUE(edit) << edit.error().text();
    const std::string before = edit->text();
    ASSERT_TRUE(edit->relocate("/a/b", "/a/b/"));
    EXPECT_EQ(edit->text(), before);
    ASSERT_TRUE(edit->relocate("/a/b", "/a/c"));
    EXPECT_EQ(edit->text(), R"({
  "openfab": 1, "printer": "../b/own.printer.json",
  "fablets": {"file": {"source": "../b/a.fl", "fablet": "file", "uniforms": {"source": "file"}}},
  "dither": {"source": "../b/d.fl", "rule": "a.fl"},
  "materials": {"source": {"key": "#102030"}},
  "textures": {"t": {"file": "../b/p ä/\"q\".png"}, "abs": {"file": "/tmp/x.nrrd", "field": "a.vtu"}},
  "meshes": {"m": {"file": "../m.obj"}, "b": {"beams": "../b/b.txt"}, "c": {"box": [1, 2, 3]}},
  "objects": {"o": {"mesh": "file", "fablet": "file", "pieces": "../b/o.cuts.json", "uniforms": {"file": "source"}},
    "p": {"mesh": "c", "fablet": "file", "pieces": {"normal": [1, 0, 0], "at_mm": 0}}},
  "groups": {"g": [{"object": "o", "transforms": "../b/g.txt"}]},
  "build": [{"group": "g", "transforms": "../b/b.txt"}]
})");
    // And back.
    ASSERT_TRUE(edit->relocate("/a/c", "/a/b"));
    EXPECT_EQ(edit->text(), before);
}

TEST(WorldEdit, PathsAreMadeAbsolute) {
    Result<WorldEdit> edit = WorldEdit::of_text(
        R"({"printer": "generic", "meshes": {"m": {"file": "../m.obj"}}, "build": [{"transforms": "/x/b.txt"}]})",
        "w");
    ASSERT_TRUE(edit) << edit.error().text();
    ASSERT_TRUE(edit->make_absolute("/a/b"));
    EXPECT_EQ(
        edit->text(),
        R"({"printer": "generic", "meshes": {"m": {"file": "/a/m.obj"}}, "build": [{"transforms": "/x/b.txt"}]})");
    EXPECT_EQ(edit->paths(), (std::vector<std::filesystem::path>{"/a/m.obj", "/x/b.txt"}));
}

TEST(WorldEdit, MembersOfTheWorld) {
    const std::string text = "{\n  \"a\": [1, 2],\n  \"b\": {\"c\": 1},\n\n  \"d\": 3 }\n";
    const auto after = [&](auto&& change) {
        Result<WorldEdit> edit = WorldEdit::of_text(text, "w");
        EXPECT_TRUE(change(*edit));
        return edit->text();
    };
    EXPECT_EQ(after([](WorldEdit& w) { return w.remove("a"); }),
              "{\n  \"b\": {\"c\": 1},\n\n  \"d\": 3 }\n");
    EXPECT_EQ(after([](WorldEdit& w) { return w.remove("b"); }),
              "{\n  \"a\": [1, 2],\n  \"d\": 3 }\n");
    EXPECT_EQ(after([](WorldEdit& w) { return w.remove("d"); }),
              "{\n  \"a\": [1, 2],\n  \"b\": {\"c\": 1} }\n");
    EXPECT_EQ(after([](WorldEdit& w) { return w.remove("c"); }), text);
    EXPECT_EQ(after([](WorldEdit& w) { return w.set("b", "[]"); }),
              "{\n  \"a\": [1, 2],\n  \"b\": [],\n\n  \"d\": 3 }\n");
    EXPECT_EQ(after([](WorldEdit& w) { return w.set("e", "5"); }),
              "{\n  \"e\": 5,\n  \"a\": [1, 2],\n  \"b\": {\"c\": 1},\n\n  \"d\": 3 }\n");
    Result<WorldEdit> alone = WorldEdit::of_text(R"({ "a": 1 })", "w");
    ASSERT_TRUE(alone->remove("a"));
    EXPECT_EQ(alone->text(), "{  }");
}

TEST(WorldEdit, AProgramStaysWhereItIs) {
    Result<WorldEdit> edit =
        WorldEdit::of_text(R"({"meshes": {"m": {"program": ["python3", "p.py"]}}})", "w");
    ASSERT_TRUE(edit);
    ASSERT_TRUE(edit->relocate("/a", "/a"));
    const Result<void> moved = edit->relocate("/a", "/b");
    ASSERT_FALSE(moved);
    EXPECT_THAT(moved.error().text(), HasSubstr("w:1:"));
    EXPECT_THAT(moved.error().text(), HasSubstr("/a"));
}

TEST(WorldEdit, APathLeadsToAValueAndMakesWhatIsMissing) {
    const std::string text =
        R"({"build": [{"object": "a"}, {"object": "b", "scale": 2}], "x": {}})";
    const auto set = [&](const std::vector<std::string>& path, const std::string& value) {
        Result<WorldEdit> edit = WorldEdit::of_text(text, "w");
        const Result<void> done = edit->set_at(path, value);
        return done ? edit->text() : "refused";
    };
    const auto removed = [&](const std::vector<std::string>& path) {
        Result<WorldEdit> edit = WorldEdit::of_text(text, "w");
        EXPECT_TRUE(edit->remove_at(path));
        return edit->text();
    };
    EXPECT_EQ(set({"build", "1", "scale"}, "3"),
              R"({"build": [{"object": "a"}, {"object": "b", "scale": 3}], "x": {}})");
    EXPECT_EQ(
        set({"build", "0", "scale"}, "[1, 2, 3]"),
        R"({"build": [{"scale": [1, 2, 3], "object": "a"}, {"object": "b", "scale": 2}], "x": {}})");
    EXPECT_EQ(
        set({"x", "y", "z"}, "true"),
        R"({"build": [{"object": "a"}, {"object": "b", "scale": 2}], "x": {"y": {"z": true}}})");
    for (const std::vector<std::string>& path : {std::vector<std::string>{"build", "2", "scale"},
                                                 {"build", "-1", "scale"},
                                                 {"build", "x"},
                                                 {"build", "1", "scale", "deep"}})
        EXPECT_EQ(set(path, "1"), "refused");
    EXPECT_EQ(set({"x", "y"}, "{"), "refused") << "the value is no JSON";
    EXPECT_EQ(removed({"build", "1", "scale"}),
              R"({"build": [{"object": "a"}, {"object": "b"}], "x": {}})");
    EXPECT_EQ(removed({"build", "1", "object"}),
              R"({"build": [{"object": "a"}, {"scale": 2}], "x": {}})");
    for (const std::vector<std::string>& path :
         {std::vector<std::string>{"build", "0", "scale"}, {"none", "at", "all"}, {"build", "0"}})
        EXPECT_EQ(removed(path), text);
}

}  // namespace
}  // namespace openfab::testing
