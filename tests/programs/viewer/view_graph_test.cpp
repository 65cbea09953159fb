// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The graph of `openfab view`: what is drawn and edited, and what its nodes are.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

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

TEST_F(ViewGraph, ATextIsTriedWithAValueAndTheFileStays) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    const auto share = [](const JsonValue& state) {
        const JsonValue& print = member(state, "prints").items.at(0);
        return member(member(print, "materials").items.at(0), "voxels").number /
               member(print, "solid").number;
    };
    const auto done_from = [&](double change) {
        return viewer.wait_for([&](const JsonValue& s) {
            return is_done(s) && member(member(s, "live"), "change").number >= change;
        });
    };
    const JsonValue first = viewer.wait_for(is_done);
    EXPECT_NEAR(share(first), 0.5, 0.02);
    // As the page makes it: a uniform in place of the 2.
    std::string tried = kFablet;
    tried.replace(tried.find("Material a"), 0, "float amount = 2; ");
    tried.replace(tried.find("x / 2"), 5, "amount * x");
    const auto attempt = [&](const std::string& uniform, const std::string& value) {
        JsonText body;
        body.begin_object().member("fablet", 0).member("text", tried).member("name", "Ramp");
        body.member("uniform", uniform).end_object();
        std::string json = body.take();
        json.pop_back();
        return viewer.post("/api/try", json + ", \"value\": " + value + "}");
    };
    tried.replace(tried.find("half_of(float x)"), 16, "half_of(float x, float amount)");
    tried.replace(tried.find("Center.x + 1)"), 13, "Center.x + 1, amount)");
    for (const double value : {0.25, 0.125}) {
        const HttpAnswer answer = attempt("amount", fmt::format("{}", value));
        ASSERT_EQ(answer.status, 200) << answer.body;
        EXPECT_NEAR(share(done_from(member(answer.json(), "change").number)), value, 0.02);
    }
    EXPECT_EQ(read_file(source()), kFablet);
    // What the last draft cost is told of texts that stay.
    const auto number = [&](const JsonValue& state) {
        return member(member(state, "live"), "print").number;
    };
    const JsonValue last = viewer.get("/api/state").json();
    EXPECT_EQ(number(last), number(first));
    EXPECT_EQ(attempt("a=white --set x", "1").status, 422);
    EXPECT_EQ(attempt("amount", "{}").status, 422);
    ASSERT_EQ(viewer.post("/api/untry", "{}").status, 200);
    EXPECT_NEAR(share(done_from(member(member(last, "live"), "change").number + 1)), 0.5, 0.02);
}

TEST_F(ViewGraph, NodesAreWhatTheCompiledFabletSays) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    const JsonValue state = viewer.wait_for(is_done);
    const JsonValue graph = ask(viewer, "/api/graph", kFablet).json();
    const int t = node_named(graph, 0, "t");
    const JsonValue& print = member(state, "prints").items.at(0);
    const double pitch = member(print, "pitch_mm").items.at(0).number;
    const double x_mm = member(print, "origin_mm").items.at(0).number + 6.5 * pitch;
    const auto look = [&](size_t tab, int node, const std::string& where) {
        const HttpAnswer answer =
            ask(viewer, "/api/look", kFablet,
                fmt::format(R"({{"tab": {}, "nodes": [{}], {}, "point_mm": [{}, 0.1, 1.1]}})", tab,
                            node, where, x_mm));
        EXPECT_EQ(answer.status, 200) << answer.body;
        return answer.json();
    };

    const JsonValue picture = look(0, t, R"("over": "slice")");
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

    // Across x all of it is the same: the value at the voxel's own x.
    const JsonValue across = look(0, t, R"("over": "slice", "axis": 0)");
    const JsonValue& flat = member(across, "nodes").items.at(0);
    EXPECT_NEAR(member(flat, "low").number, (x_mm + 1) / 2, 1e-5);
    EXPECT_EQ(member(flat, "low").number, member(flat, "high").number);

    // Along x, all that is solid of a row: a line through 0 at -1 mm and 1 at 1 mm.
    const JsonValue line = look(0, t, R"("over": "line", "axis": 0)");
    const double from = member(line, "from_mm").number, step = member(line, "step_mm").number;
    int64_t solid = 0;
    const std::vector<JsonValue>& along = member(member(line, "nodes").items.at(0), "values").items;
    for (size_t i = 0; i < along.size(); ++i) {
        if (!along[i].is(JsonValue::Kind::kNumber)) continue;
        ++solid;
        EXPECT_NEAR(along[i].number, (from + static_cast<double>(i) * step + 1) / 2, 1e-5) << i;
    }
    EXPECT_NEAR(static_cast<double>(solid) * step, 2, 1.5 * step);

    // Over the surface: what is there has values from one end of the cube to the other, and none of its inside is seen.
    const JsonValue surface = look(0, t, R"("over": "surface")");
    const JsonValue& skin = member(surface, "nodes").items.at(0);
    EXPECT_LT(member(skin, "low").number, 0.05);
    EXPECT_GT(member(skin, "high").number, 0.95);
    EXPECT_GT(member(surface, "width").number, 20);
    EXPECT_EQ(
        ask(viewer, "/api/look", kFablet, R"({"tab": 1, "nodes": [0], "over": "surface"})").status,
        422)
        << "a function has no surface";
    EXPECT_EQ(
        ask(viewer, "/api/look", kFablet, R"({"tab": 0, "nodes": [0], "over": "all"})").status,
        422);
    EXPECT_EQ(ask(viewer, "/api/look", kFablet,
                  R"({"tab": 0, "nodes": [0], "over": "line", "axis": 7, "point_mm": [0, 0, 0]})")
                  .status,
              422);

    // In one voxel, at the print's own pitch; in a function, what it gave there.
    const auto value_at = [&](size_t tab, int number) {
        const JsonValue json = look(tab, number, R"("over": "voxel")");
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

/// Red above blue, as wide as high; the world names it.
TEST_F(ViewGraph, ATextureIsShownAsItIsSampled) {
    scratch_.write("flag.ppm", "P3 2 2 255 255 0 0 255 0 0 0 0 255 0 0 255\n");
    std::string text = world_text();
    text.insert(text.find("    \"build\""),
                "    \"textures\": {\"flag\": {\"file\": \"flag.ppm\"}},\n");
    scratch_.write("cube.fab.json", text);
    const Viewer viewer({world(), "--draft", "8"}, cache());
    viewer.wait_for(is_done);
    const HttpAnswer answer = viewer.get("/api/texture?name=flag");
    ASSERT_EQ(answer.status, 200) << answer.body;
    scratch_.write("flag.png", answer.body);
    const ReadPng png = read_png(scratch_ / "flag.png");
    ASSERT_EQ(png.width, 2);
    ASSERT_EQ(png.height, 2);
    for (int32_t x = 0; x < 2; ++x) {
        EXPECT_EQ(png.at(x, 0), (Rgba{255, 0, 0, 255}));
        EXPECT_EQ(png.at(x, 1), (Rgba{0, 0, 255, 255}));
    }
    EXPECT_EQ(viewer.get("/api/texture?name=none").status, 422);
    EXPECT_EQ(viewer.get("/api/texture").status, 400);
    EXPECT_EQ(viewer.ask("GET", "/api/texture?name=flag", {viewer.host_header()}).status, 403);
    std::filesystem::remove(scratch_ / "flag.ppm");
    EXPECT_EQ(viewer.get("/api/texture?name=flag").status, 422) << "the file is gone";
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

TEST_F(ViewGraph, PlacesOfNodesAreAFileThatMayBeLost) {
    namespace fs = std::filesystem;
    const Viewer viewer({world(), "--watch", "--draft", "8"}, cache());
    viewer.wait_for(is_done);
    const fs::path file = scratch_ / "ramp.graph.json";
    const auto places = [&] { return viewer.get("/api/places?fablet=0").body; };
    const auto keep = [&](const std::string& value) {
        return viewer.post("/api/places", R"({"fablet": 0, "places": )" + value + "}").status;
    };
    EXPECT_EQ(places(), "{}");
    EXPECT_EQ(keep(R"({"tabs": {}})"), 200);
    EXPECT_FALSE(fs::exists(file)) << "there is nothing to keep";
    const std::string value = R"({"tabs":{"@Volume":{"at":{"t":[-10,20.5]}}}})";
    EXPECT_EQ(keep(value), 200);
    EXPECT_EQ(places(), value);
    EXPECT_EQ(keep("[]"), 422);
    EXPECT_EQ(viewer.post("/api/places", R"({"fablet": 7, "places": {"tabs": {}}})").status, 422);
    EXPECT_EQ(places(), value);
    std::ofstream(file) << "{ damaged";
    EXPECT_EQ(places(), "{}");
    fs::remove(file);
    EXPECT_EQ(places(), "{}");
    EXPECT_EQ(keep(value), 200);
    EXPECT_EQ(keep(R"({"tabs": {}})"), 200);
    EXPECT_FALSE(fs::exists(file));
    // No link leads out of the folder.
    std::ofstream(scratch_ / "elsewhere") << "mine";
    fs::create_symlink(scratch_ / "elsewhere", file);
    EXPECT_EQ(keep(value), 422);
    EXPECT_EQ(read_file((scratch_ / "elsewhere").string()), "mine");
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
