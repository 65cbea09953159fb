// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` and the files of a world's folder: what is dropped on the page, the whole print, and
// templates.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "runtime/pipeline/messages.h"
#include "tests/programs/viewer/view_fixtures.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

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

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

class ViewFiles : public WorldFixture {
  protected:
    ViewFiles() : WorldFixture("ramp", "Ramp", kFablet) {}
};

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
    // What is said of its unit, without the options of another program.
    EXPECT_THAT(member(used.json(), "notes").text, HasSubstr("part.obj`"));
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
    const JsonValue& full = member(member(state, "live"), "full_print");
    EXPECT_EQ(member(full, "file").text, "cube-2.ofr");
    EXPECT_EQ(member(full, "path").text, (scratch_ / "cube-2.ofr").string());
    // It is in view, at full pitch, until the draft is wanted again.
    const auto shows = [&](const std::string& name, bool is_full) {
        const JsonValue now = viewer.wait_for([&](const JsonValue& s) {
            return member(member(s, "live"), "shows_full").boolean == is_full;
        });
        const JsonValue& print = member(now, "prints").items.at(0);
        EXPECT_EQ(member(print, "name").text, name);
        return member(print, "size").items.at(0).number;
    };
    const double whole = shows("cube-2.ofr", true);
    ASSERT_EQ(viewer.post("/api/show", R"({"full": 0})").status, 200);
    const double draft = shows("cube.fab.json", false);
    EXPECT_GT(whole, 3 * draft);
    ASSERT_EQ(viewer.post("/api/show", R"({"full": 1})").status, 200);
    shows("cube-2.ofr", true);
    // A change is seen at once, as a draft.
    ASSERT_EQ(viewer.post("/api/draft", R"({"draft": 5})").status, 200);
    shows("cube.fab.json", false);
    EXPECT_EQ(read_file((scratch_ / "cube.ofr").string()), "mine");
    EXPECT_GT(std::filesystem::file_size((scratch_ / "cube-2.ofr").string()), 500U);
    EXPECT_EQ(viewer.post("/api/template", R"({"name": "shell"})").status, 422);
    EXPECT_EQ(read_file(world()), world_text());
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

/// Two windows, or two viewers of one folder: of several changes of one text one is made, and the others are told.
TEST_F(ViewFiles, NoChangeIsLostBesideAnother) {
    const Viewer one({world(), "--watch", "--draft", "4"}, cache());
    const Viewer two({world(), "--watch", "--draft", "4"}, cache());
    one.wait_for(is_done);
    two.wait_for(is_done);
    const auto at_once = [&](const std::function<void(const Viewer&, int)>& ask) {
        std::vector<std::thread> threads;
        for (int i = 0; i < 8; ++i)
            threads.emplace_back([&, i] { ask(i % 2 == 0 ? one : two, i); });
        for (std::thread& thread : threads)
            thread.join();
    };
    const JsonValue source = one.get("/api/source?fablet=0").json();
    std::atomic<int> saved{0}, refused{0}, winner{-1};
    at_once([&](const Viewer& viewer, int i) {
        JsonText body;
        body.begin_object().member("fablet", 0);
        body.member("text", member(source, "text").text + fmt::format("// window {}\n", i));
        body.member("stamp", member(source, "stamp").text).end_object();
        const int status = viewer.post("/api/source", body.take()).status;
        (status == 200 ? saved : refused)++;
        if (status == 200) winner = i;
    });
    EXPECT_EQ(saved, 1);
    EXPECT_EQ(refused, 7);
    EXPECT_THAT(member(one.get("/api/source?fablet=0").json(), "text").text,
                ::testing::EndsWith(fmt::format("// window {}\n", winner.load())));

    // Each is a picture of one pixel; a byte behind its end tells them apart.
    const std::string pixel(
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\2\0\0\0\x90wS\xde\0\0\0\x0cIDAT"
        "x\x9c"
        "c\xf8\xcf\xc0\0\0\3\1\1\0\xc9\xfe\x92\xef\0\0\0\0IEND\xae"
        "B`\x82",
        69);
    std::mutex mutex;
    std::vector<std::string> used;
    at_once([&](const Viewer& viewer, int i) {
        const std::string name = fmt::format("p{}", i);
        EXPECT_EQ(
            viewer
                .post("/api/upload?name=" + name + ".png&at=0", pixel + static_cast<char>('a' + i))
                .status,
            200);
        const HttpAnswer answer =
            viewer.post("/api/use", R"({"name": ")" + name + R"(.png", "object": "cube"})");
        const std::lock_guard lock(mutex);
        if (answer.status == 200) used.push_back(name);
    });
    EXPECT_GE(used.size(), 4u);
    const std::string text = read_file(world());
    for (const std::string& name : used)
        EXPECT_THAT(text, HasSubstr('"' + name + R"(": {"file")"));
}

/// What the viewer starts gets what is left of its memory, and says where that is too little.
TEST_F(ViewFiles, ItsProgramsKeepToItsMemory) {
    const Viewer viewer({world(), "--watch", "--draft", "4", "--memory", "60MB"}, cache());
    const JsonValue state = viewer.wait_for(
        [](const JsonValue& s) { return member(member(s, "live"), "phase").text == "failed"; });
    EXPECT_THAT(member(member(state, "live"), "message").text,
                Says(pipeline::messages::kBudgetTooSmall));
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
                    "--preview cup.png,view=model:30:30,cut=xy\n",
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
