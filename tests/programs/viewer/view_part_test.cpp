// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The panel "Part" of `openfab view`: what it changes of a world, what it must not, and what is dropped on the page.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "program/messages.h"
#include "tests/programs/viewer/view_fixtures.h"
#include "tests/support/says/says.h"
#include "tools/viewer/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kFablet = R"(fablet Half {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter.x < 0 ? a : b, 1);
        return mc;
    }
}
)";

class ViewPart : public WorldFixture {
  protected:
    ViewPart() : WorldFixture("half", "Half", kFablet) {}

    static int edit(const Viewer& viewer, const std::string& edits) {
        return viewer.post("/api/part", R"({"edits": )" + edits + "}").status;
    }
    std::string text() const { return read_file(world()); }
    /// The size of the first item of the build, once its longest side is that.
    static std::vector<double> size_when(const Viewer& viewer, double longest) {
        std::vector<double> size;
        viewer.wait_for([&](const JsonValue& state) {
            if (!is_done(state)) return false;
            const JsonValue live = viewer.get("/api/live").json();
            size.clear();
            for (const JsonValue& v : member(member(live, "part"), "sizes_mm").items.at(0).items)
                size.push_back(v.number);
            return std::abs(*std::max_element(size.begin(), size.end()) - longest) < 1e-9;
        });
        return size;
    }
};

TEST_F(ViewPart, TheWorldIsChangedAndAllElseOfItStays) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    EXPECT_EQ(size_when(viewer, 2), (std::vector<double>{2, 2, 2}));
    std::string wanted = text();
    const auto replace = [&](const std::string& from, const std::string& to) {
        const size_t at = wanted.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        wanted.replace(at, from.size(), to);
    };
    ASSERT_EQ(edit(viewer, R"([{"path": ["build", 0, "scale"], "value": [1, 2, 3]}])"), 200);
    replace(R"({"object": "cube"})", R"({"scale": [1, 2, 3], "object": "cube"})");
    EXPECT_EQ(text(), wanted);
    EXPECT_EQ(size_when(viewer, 6), (std::vector<double>{2, 4, 6}));
    ASSERT_EQ(edit(viewer, R"([{"path": ["build", 0, "rotate_deg"], "value": [90, 0, 0]},
                               {"path": ["build", 0, "grid"], "value": {"count": [2, 1], "spacing_mm": 3}}])"),
              200);
    replace(R"({"scale")",
            R"({"grid": {"count": [2, 1], "spacing_mm": 3}, "rotate_deg": [90, 0, 0], "scale")");
    EXPECT_EQ(text(), wanted);
    const std::vector<double> turned = size_when(viewer, 6);
    EXPECT_NEAR(turned[1], 6, 1e-9);
    EXPECT_NEAR(turned[2], 4, 1e-9);
    ASSERT_EQ(edit(viewer, R"([{"path": ["printer"], "value": "j850"}])"), 200);
    EXPECT_THAT(text(), HasSubstr("\"printer\": \"j850\""));
    // Back to the first text, step by step, and forward again.
    const std::string last = text();
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(viewer.post("/api/unpart", "{}").status, 200);
    EXPECT_EQ(text(), world_text());
    EXPECT_EQ(viewer.post("/api/unpart", "{}").status, 422);
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(viewer.post("/api/repart", "{}").status, 200);
    EXPECT_EQ(text(), last);
    // What another program writes is not undone.
    scratch_.write("cube.fab.json", last + "\n");
    EXPECT_EQ(viewer.post("/api/unpart", "{}").status, 422);
    EXPECT_EQ(text(), last + "\n");
}

TEST_F(ViewPart, EveryPrinterOfTheListIsShown) {
    // Makers of some publish no pitch.
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    ASSERT_EQ(edit(viewer, R"([{"path": ["printer"], "value": "inkjet_kit"}])"), 200);
    const JsonValue state = viewer.wait_for([](const JsonValue& s) {
        return is_done(s) && !member(member(s, "live"), "message").text.empty();
    });
    EXPECT_THAT(member(member(state, "live"), "message").text,
                Says(program::messages::kPitchStandsIn, "*", "inkjet_kit", "are", 0.4, 0.4, 0.4));
    ASSERT_EQ(viewer.post("/api/print", "{}").status, 200);
    const JsonValue whole = viewer.wait_for([](const JsonValue& s) {
        const std::string phase = member(member(member(s, "live"), "full_print"), "phase").text;
        return phase == "done" || phase == "failed";
    });
    const JsonValue& full = member(member(whole, "live"), "full_print");
    EXPECT_EQ(member(full, "phase").text, "done");
    EXPECT_THAT(member(full, "message").text,
                Says(program::messages::kPitchStandsIn, "*", "inkjet_kit", "are", 0.1, 0.1, 0.1));
}

TEST_F(ViewPart, MaterialsComeAndGo) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    ASSERT_EQ(
        edit(viewer,
             R"([{"path": ["materials", "red"], "value": {"key": "#e01010", "preview": "#c8281e"}},
                               {"path": ["objects", "cube", "uniforms", "a"], "value": "red"}])"),
        200);
    const JsonValue state = viewer.wait_for([](const JsonValue& s) {
        return is_done(s) && member(member(s, "prints").items.at(0), "materials").items.size() > 2;
    });
    EXPECT_EQ(member(member(state, "prints").items.at(0), "materials").items.size(), 3u);
    ASSERT_EQ(edit(viewer, R"([{"path": ["materials", "white"]}])"), 200);
    EXPECT_THAT(text(), Not(HasSubstr("white\": {")));
    viewer.wait_for([](const JsonValue& s) {
        return is_done(s) && member(member(s, "prints").items.at(0), "materials").items.size() == 2;
    });
}

TEST_F(ViewPart, NothingElseIsChanged) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    const std::string before = text();
    for (const char* edits :
         {R"([{"path": ["meshes", "cube", "file"], "value": "/etc/passwd"}])",
          R"([{"path": ["fablets", "half", "source"], "value": "/etc/passwd"}])",
          R"([{"path": ["meshes", "cube"], "value": {"file": "../x.obj"}}])",
          R"([{"path": ["build", "x", "scale"], "value": 2}])",
          R"([{"path": ["build", 7, "scale"], "value": 2}])",
          R"([{"path": ["build", 0, "transforms"], "value": "../x.txt"}])",
          R"([{"path": ["printer"], "value": "../mine.json"}])", R"([{"path": ["printer"]}])",
          R"([{"path": [], "value": 1}])",
          R"([{"path": ["build", 0, "scale"], "value": 2}, {"path": ["build"]}])", "[]", "{}",
          R"("x")"})
        EXPECT_EQ(edit(viewer, edits), 422) << edits;
    EXPECT_EQ(viewer.post("/api/part", "{}").status, 400);
    EXPECT_EQ(text(), before);
    const Viewer looked_at({world(), "--draft", "4"}, cache());
    looked_at.wait_for(is_done);
    for (const char* path : {"/api/part", "/api/unpart", "/api/show"})
        EXPECT_EQ(looked_at.post(path, R"({"edits": []})").status, 403) << path;
}

/// The page puts it in words of its own (tools/viewer/page/page_words.js).
TEST_F(ViewPart, WhatIsDroppedIsTold) {
    const Viewer viewer({world(), "--watch", "--draft", "4"}, cache());
    viewer.wait_for(is_done);
    const auto drop = [&](const std::string& name, const std::string& content,
                          const std::string& more = "") {
        EXPECT_EQ(viewer.post("/api/upload?name=" + name + "&at=0", content).status, 200);
        return viewer.post("/api/use",
                           fmt::format(R"({{"name": "{}", "object": "cube"{}}})", name, more));
    };
    const HttpAnswer notes = drop("notes.txt", "hello");
    EXPECT_EQ(notes.status, 422);
    EXPECT_THAT(notes.body, Says(viewer::messages::kNeitherMeshNorPicture, "notes.txt"));
    EXPECT_THAT(drop("a.STEP", "ISO-10303-21;\n").body,
                Says(viewer::messages::kStepIsDropped, "a.STEP"));
    EXPECT_THAT(drop("a.fbx", "x").body, Says(viewer::messages::kOtherIsDropped, "a.fbx", "FBX*"));
    const std::string open =
        "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";  // without its slope
    const HttpAnswer refused = drop("open.obj", open);
    EXPECT_EQ(refused.status, 422) << refused.body;
    EXPECT_THAT(refused.body, HasSubstr("Repair"));
    const HttpAnswer repaired = drop("open.obj", open, R"(, "repair": true)");
    EXPECT_EQ(repaired.status, 200) << repaired.body;
    EXPECT_THAT(text(), HasSubstr(R"("repair": "winding")"));
    viewer.wait_for(is_done);
    const HttpAnswer closed = drop("closed.obj", open + "f 2 3 4\n");
    EXPECT_EQ(closed.status, 200) << closed.body;
    EXPECT_THAT(text(), Not(HasSubstr("repair"))) << "nor the mesh that needed it";
    EXPECT_THAT(text(), Not(HasSubstr("open.obj")));
    // Its unit is a choice of the panel.
    ASSERT_EQ(edit(viewer, R"([{"path": ["meshes", "closed", "unit"], "value": "cm"}])"), 200);
    EXPECT_EQ(size_when(viewer, 90).size(), 3u);
}

}  // namespace
}  // namespace openfab::testing
