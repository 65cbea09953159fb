// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The graph of `openfab view`: what is drawn and edited, and what its nodes are.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/programs/viewer/view_fixtures.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr const char* kFablet = R"(fablet Ramp {
    @uniform { Material a, b; }
    float half_of(float x) { return x / 2; }
    @Volume(@varying { VolumeAttributes attr })
    {
        float t = half_of(attr.voxelCenter.x + 1);
        MaterialComposition mc;
        mc.Set(a, t);
        mc.Set(b, 1 - t);
        return mc;
    }
}
)";

class ViewGraph : public WorldFixture {
  protected:
    ViewGraph() : WorldFixture("ramp", "Ramp", kFablet) {}
};

/// Of a graph's answer, the number of the node whose first output has this name.
int node_named(const JsonValue& graph, size_t tab, const std::string& name) {
    for (const JsonValue& node : member(member(graph, "tabs").items.at(tab), "nodes").items) {
        const std::vector<JsonValue>& outputs = member(node, "outputs").items;
        if (!outputs.empty() && member(outputs[0], "name").text == name)
            return static_cast<int>(member(node, "id").number);
    }
    ADD_FAILURE() << "no node " << name;
    return -1;
}

TEST_F(ViewGraph, NodesAreWhatTheCompiledFabletSays) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    const JsonValue state = viewer.wait_for(is_done);
    const JsonValue graph = ask(viewer, "/api/graph", kFablet).json();
    const int t = node_named(graph, 0, "t");
    const HttpAnswer slice = ask(viewer, "/api/look", kFablet,
                                 fmt::format(R"({{"tab": 0, "nodes": [{}], "slice": 3}})", t));
    ASSERT_EQ(slice.status, 200) << slice.body;
    const JsonValue picture = slice.json();
    const auto width = static_cast<size_t>(member(picture, "width").number);
    EXPECT_EQ(width, 44U);
    EXPECT_EQ(member(picture, "height").number, 44);
    const JsonValue& node = member(picture, "nodes").items.at(0);
    // Centres of 44 voxels over two millimetres.
    EXPECT_NEAR(member(node, "low").number, 0.5 / 44, 1e-5);
    EXPECT_NEAR(member(node, "high").number, 43.5 / 44, 1e-5);
    const std::vector<JsonValue>& values = member(node, "values").items;
    ASSERT_EQ(values.size(), width * width);
    for (size_t x = 0; x < width; ++x)
        EXPECT_NEAR(values[7 * width + x].number, 255.0 * static_cast<double>(x) / 43, 1) << x;

    // In one voxel, at the print's own pitch; in a function, what it gave there.
    const JsonValue& print = member(state, "prints").items.at(0);
    const double pitch = member(print, "pitch_mm").items.at(0).number;
    const double x_mm = member(print, "origin_mm").items.at(0).number + 6.5 * pitch;
    const auto value_at = [&](size_t tab, int number) {
        const HttpAnswer answer =
            ask(viewer, "/api/look", kFablet,
                fmt::format(R"({{"tab": {}, "nodes": [{}], "point_mm": [{}, 0.1, 1.1]}})", tab,
                            number, x_mm));
        EXPECT_EQ(answer.status, 200) << answer.body;
        const JsonValue json = answer.json();
        const std::vector<JsonValue>& nodes = member(json, "nodes").items;
        return nodes.empty() ? -1 : member(nodes[0], "values").items.at(0).number;
    };
    EXPECT_NEAR(value_at(0, t), (x_mm + 1) / 2, 1e-5);
    const std::vector<JsonValue>& in_function =
        member(member(graph, "tabs").items.at(1), "nodes").items;
    for (const JsonValue& node_of : in_function) {
        if (member(node_of, "kind").text != "result") continue;
        EXPECT_NEAR(value_at(1, static_cast<int>(member(node_of, "id").number)), (x_mm + 1) / 2,
                    1e-5);
    }
}

TEST_F(ViewGraph, AFabletIsDrawnAndEdited) {
    const Viewer viewer({world(), "--watch", "--draft", "8"}, cache());
    viewer.wait_for(is_done);
    const JsonValue graph = ask(viewer, "/api/graph", kFablet).json();
    EXPECT_TRUE(member(graph, "whole").boolean);
    const JsonValue& tab = member(graph, "tabs").items.at(0);
    EXPECT_EQ(member(tab, "name").text, "@Volume");
    int set = -1;
    for (const JsonValue& node : member(tab, "nodes").items) {
        if (set < 0 && member(node, "title").text == ".Set")
            set = static_cast<int>(member(node, "id").number);
    }
    ASSERT_GE(set, 0);
    const auto edit = [&](const std::string& text) {
        return ask(viewer, "/api/edit", kFablet,
                   fmt::format(R"({{"do": "set", "tab": 0, "node": {}, "port": 2, "text": "{}"}})",
                               set, text));
    };
    const HttpAnswer edited = edit("t * 0.5");
    ASSERT_EQ(edited.status, 200) << edited.body;
    EXPECT_THAT(member(edited.json(), "text").text, HasSubstr("mc.Set(a, t * 0.5);"));
    EXPECT_EQ(member(member(edited.json(), "graph"), "tabs").items.size(), 2u);
    const HttpAnswer refused = edit("a");
    EXPECT_EQ(refused.status, 422);
    EXPECT_THAT(refused.body, HasSubstr("Material"));
    EXPECT_THAT(ask(viewer, "/api/palette", kFablet).body, HasSubstr("voronoi_edge"));
    EXPECT_EQ(ask(viewer, "/api/edit", kFablet).status, 400) << "an action is missing";
    EXPECT_EQ(viewer.post("/api/graph", R"({"fablet": 1, "text": ""})").status, 422);
    EXPECT_EQ(read_file(source()), kFablet) << "nothing is saved";
}

TEST_F(ViewGraph, WhoTypesIsTold) {
    const Viewer viewer({world(), "--watch", "--draft", "8"}, cache());
    viewer.wait_for(is_done);
    std::string text = kFablet;
    const std::string typed = "        attr.vox\n";
    text.insert(text.find("        MaterialComposition"), typed);
    const auto assist = [&](const std::string& kind, int line, int character) {
        return ask(
            viewer, "/api/assist", text,
            fmt::format(R"({{"ask": "{}", "line": {}, "character": {}}})", kind, line, character));
    };
    EXPECT_THAT(assist("complete", 6, 16).body, HasSubstr(R"("label":"voxelCenter")"));
    EXPECT_THAT(assist("hover", 5, 20).body, HasSubstr("float half_of(float x)"));
    EXPECT_THAT(assist("signature", 5, 26).body, HasSubstr(R"("activeParameter":0)"));
    EXPECT_THAT(assist("complete", 900000, -1).body, HasSubstr("label")) << "behind the end";
    EXPECT_EQ(assist("guess", 0, 0).status, 422);
    EXPECT_EQ(ask(viewer, "/api/assist", text).status, 400) << "an action is missing";
    text = "fablet A {   @uniform { float a ; } }";
    EXPECT_THAT(assist("format", 0, 0).body, HasSubstr(R"("newText":"fablet A {\n    @uniform {)"));
}

}  // namespace
}  // namespace openfab::testing
