// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` and the files of a world's folder: what is dropped on the page, what nodes of a graph are, the whole
// print, and templates.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "base/json_text.h"
#include "tests/programs/viewer/viewer_client.h"
#include "tests/support/places/places.h"

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

constexpr const char* kWorld = R"({
    "openfab": 1, "printer": "generic",
    "fablets": {"ramp": {"source": "ramp.fl", "fablet": "Ramp"}},
    "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
    "meshes": {"cube": {"box": [2, 2, 2]}},
    "objects": {"cube": {"mesh": "cube", "fablet": "ramp", "uniforms": {"a": "white", "b": "black"}}},
    "build": [{"object": "cube"}]
}
)";

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

class ViewFiles : public ::testing::Test {
  protected:
    ViewFiles() {
        scratch_.write("ramp.fl", kFablet);
        scratch_.write("cube.fab.json", kWorld);
    }
    std::string world() const { return (scratch_ / "cube.fab.json").string(); }
    std::string cache() const { return (scratch_ / "cache").string(); }
    static bool is_done(const JsonValue& state) {
        return member(member(state, "live"), "phase").text == "done";
    }
    static HttpAnswer post(const Viewer& viewer, const std::string& path,
                           const std::string& action) {
        JsonText body;
        body.begin_object().member("fablet", 0).member("text", kFablet).end_object();
        std::string text = body.take();
        text.pop_back();
        return viewer.post(path, text + ", \"action\": " + action + "}");
    }

    ScratchFolder scratch_;
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

TEST_F(ViewFiles, NodesAreWhatTheCompiledFabletSays) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    const JsonValue state = viewer.wait_for(is_done);
    JsonText body;
    body.begin_object().member("fablet", 0).member("text", kFablet).end_object();
    const JsonValue graph = viewer.post("/api/graph", body.take()).json();
    const int t = node_named(graph, 0, "t");
    const HttpAnswer slice =
        post(viewer, "/api/look", fmt::format(R"({{"tab": 0, "nodes": [{}], "slice": 3}})", t));
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
            post(viewer, "/api/look",
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

TEST_F(ViewFiles, WhatIsDroppedLiesBesideTheWorldAndNothingIsReplaced) {
    const std::string mine =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    scratch_.write("part.obj", mine);
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    const std::string text = kTetrahedron;
    ASSERT_EQ(viewer.post("/api/upload?name=part.obj&at=0", text.substr(0, 20)).status, 200);
    EXPECT_EQ(viewer.post("/api/upload?name=part.obj&at=30", text.substr(20)).status, 422);
    ASSERT_EQ(viewer.post("/api/upload?name=part.obj&at=20", text.substr(20)).status, 200);
    const HttpAnswer used = viewer.post("/api/use", R"({"name": "part.obj", "object": "cube"})");
    ASSERT_EQ(used.status, 200) << used.body;
    EXPECT_THAT(member(used.json(), "notes").text, HasSubstr("no unit"));
    EXPECT_EQ(read_file((scratch_ / "part.obj").string()), mine) << "the other one stays";
    EXPECT_EQ(read_file((scratch_ / "part-2.obj").string()), text);
    EXPECT_THAT(read_file(world()), HasSubstr(R"("mesh": "part")"));
    EXPECT_THAT(read_file(world()), HasSubstr(R"("file": "part-2.obj")"));
    EXPECT_THAT(read_file(world()), HasSubstr(R"("cube": {"box": [2, 2, 2]})"));
    viewer.wait_for([](const JsonValue& s) {
        return is_done(s) && member(member(s, "prints").items.at(0), "size").items.at(0).number > 8;
    });

    for (const char* name :
         {"..%2Fout.obj", "%2Ftmp%2Fout.obj", ".hidden.obj", "-o.obj", "a%0Ab.obj"})
        EXPECT_EQ(viewer.post(fmt::format("/api/upload?name={}&at=0", name), text).status, 422)
            << name;
    ASSERT_EQ(viewer.post("/api/upload?name=broken.obj&at=0", "f 1 2 3\n").status, 200);
    const std::string before = read_file(world());
    const HttpAnswer broken =
        viewer.post("/api/use", R"({"name": "broken.obj", "object": "cube"})");
    EXPECT_EQ(broken.status, 422);
    EXPECT_THAT(broken.body, HasSubstr("broken.obj"));
    EXPECT_EQ(read_file(world()), before);
    EXPECT_FALSE(std::filesystem::exists((scratch_ / "broken.obj").string()));
    EXPECT_EQ(viewer.post("/api/use", R"({"name": "part.obj", "object": "nobody"})").status, 422);
}

TEST_F(ViewFiles, ThePrintIsAFileBesideTheWorldAndTemplatesAreForNewWorldsAlone) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    scratch_.write("cube.ofr", "mine");
    ASSERT_EQ(viewer.post("/api/print", "{}").status, 200);
    const JsonValue state = viewer.wait_for([](const JsonValue& s) {
        const JsonValue& print = member(member(s, "live"), "full_print");
        return member(print, "phase").text == "done";
    });
    EXPECT_EQ(member(member(member(state, "live"), "full_print"), "file").text, "cube-2.ofr");
    EXPECT_EQ(read_file((scratch_ / "cube.ofr").string()), "mine");
    EXPECT_GT(std::filesystem::file_size((scratch_ / "cube-2.ofr").string()), 500U);
    EXPECT_EQ(viewer.post("/api/template", R"({"name": "shell"})").status, 422);
    EXPECT_EQ(read_file(world()), kWorld);
}

TEST_F(ViewFiles, AUniformThatIsRenamedIsSoInTheWorld) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    const JsonValue source = viewer.get("/api/source?fablet=0").json();
    std::string text = kFablet;
    text.replace(text.find("Material a, b"), 13, "Material left, b");
    text.replace(text.find("Set(a,"), 6, "Set(left,");
    JsonText body;
    body.begin_object().member("fablet", 0).member("text", text);
    body.member("stamp", member(source, "stamp").text).end_object();
    const HttpAnswer saved = viewer.post("/api/source", body.take());
    ASSERT_EQ(saved.status, 200) << saved.body;
    EXPECT_THAT(member(saved.json(), "notes").text, HasSubstr("`a` is called `left` now"));
    EXPECT_THAT(read_file(world()), HasSubstr(R"("uniforms": {"left": "white", "b": "black"})"));
    const JsonValue state = viewer.wait_for([](const JsonValue& s) {
        const std::string phase = member(member(s, "live"), "phase").text;
        return phase == "failed" || (phase == "done" && member(s, "generation").number >= 2);
    });
    EXPECT_TRUE(is_done(state)) << member(member(state, "live"), "message").text;
}

TEST_F(ViewFiles, WithoutWatchNothingIsWritten) {
    const Viewer viewer({world(), "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    for (const char* path :
         {"/api/upload?name=a.obj&at=0", "/api/use", "/api/print", "/api/template"})
        EXPECT_EQ(viewer.post(path, R"({"name": "a.obj", "object": "cube"})").status, 403) << path;
}

TEST_F(ViewFiles, ANewWorldTakesTemplates) {
    const std::string folder = (scratch_ / "cup").string();
    Viewer viewer({"--new", folder, "--template", "shell", "--draft", "6"}, cache());
    viewer.says(
        fmt::format("made {0}/cup.fab.json\nprint it: openfab print {0}/cup.fab.json -o cup.ofr "
                    "--preview cup.png,view=section\n",
                    folder));
    viewer.wait_for(is_done);
    EXPECT_THAT(read_file(folder + "/cup.fl"), HasSubstr("fablet Shell"));
    ASSERT_EQ(viewer.post("/api/template", R"({"name": "lattice"})").status, 200);
    EXPECT_THAT(read_file(folder + "/cup.fl"), HasSubstr("fablet Lattice"));
    EXPECT_THAT(read_file(folder + "/cup.fab.json"), HasSubstr("\"box\": [20, 20, 20]"));
    viewer.wait_for(is_done);
}

}  // namespace
}  // namespace openfab::testing
