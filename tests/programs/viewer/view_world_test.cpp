// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view` of a world: what the page can change, and what it cannot.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <thread>

#include "runtime/part/messages.h"
#include "tests/programs/viewer/view_world.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "tools/viewer/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(ViewWorld, AValueOfThePageIsPrintedAndWrittenBackAndFilesAreWatched) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    EXPECT_NEAR(share(state), 0.5, 0.02);
    // What the page builds its controls from.
    const JsonValue details = viewer.get("/api/live").json();
    const JsonValue& uniform =
        member(member(details, "objects").items.at(0), "uniforms").items.at(0);
    EXPECT_EQ(member(uniform, "name").text, "share");
    EXPECT_EQ(member(member(uniform, "annotations"), "max").text, "1");
    EXPECT_EQ(member(member(details, "fablets").items.at(0), "file").text, "halves.fl");

    const auto generation = [&] { return member(state, "generation").number; };
    ASSERT_EQ(
        viewer.post("/api/set", R"({"object": "cube", "uniform": "share", "value": 0.25})").status,
        200);
    double before = generation();
    state = viewer.wait_for([&](const JsonValue& s) { return has_done(s, before + 1); });
    EXPECT_NEAR(share(state), 0.25, 0.02);
    EXPECT_THAT(read_file(world()), ::testing::StrEq(world_text()));

    ASSERT_EQ(viewer.post("/api/write", "{}").status, 200);
    EXPECT_THAT(read_file(world()),
                HasSubstr(R"("uniforms": {"share": 0.25, "a": "white", "b": "black"})"));
    before = generation();
    state = viewer.wait_for([&](const JsonValue& s) { return has_done(s, before + 1); });
    EXPECT_NEAR(share(state), 0.25, 0.02);

    // Somebody else changes the world.
    before = generation();
    scratch_.write("cube.fab.json", world_text());
    state = viewer.wait_for([&](const JsonValue& s) { return has_done(s, before + 1); });
    EXPECT_NEAR(share(state), 0.5, 0.02);

    // A part is named; between the cubes there is none.
    const std::string pick =
        fmt::format("/api/pick?generation={}&print=0&y=5&z=5&x=", generation());
    EXPECT_EQ(member(viewer.get(pick + "45").json(), "part").text,
              fmt::format(viewer::messages::kPlacementOf, "cube", 2, 2));
    EXPECT_EQ(member(viewer.get(pick + "25").json(), "part").text, "");
    // What the dither was given is asked for apart.
    const auto amounts = [&](const std::string& x) {
        const HttpAnswer answer = viewer.get(
            fmt::format("/api/amounts?generation={}&print=0&y=5&z=5&x={}", generation(), x));
        EXPECT_EQ(answer.status, 200) << answer.body;
        return member(answer.json(), "fractions");
    };
    EXPECT_NEAR(amounts("45").items.at(0).number, 0.5, 1e-5);
    EXPECT_NEAR(amounts("45").items.at(1).number, 0.5, 1e-5);
    EXPECT_EQ(amounts("25").items.at(0).number, 0);
}

TEST_F(ViewWorld, AStateThatIsKnownIsAnsweredOnceThereIsAnother) {
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    const auto change_of = [](const JsonValue& state) {
        return static_cast<int64_t>(member(member(state, "live"), "change").number);
    };
    const int64_t known =
        change_of(viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); }));
    const std::string path = fmt::format("/api/state?known={}", known);
    std::future<JsonValue> next =
        std::async(std::launch::async, [&] { return viewer.get(path).json(); });
    EXPECT_EQ(next.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
    const HttpAnswer set =
        viewer.post("/api/set", R"({"object": "cube", "uniform": "share", "value": 0.25})");
    ASSERT_EQ(next.wait_for(std::chrono::seconds(5)), std::future_status::ready);
    EXPECT_GT(change_of(next.get()), known);
    EXPECT_GT(change_of(viewer.get(path).json()), known) << "there is another already";
    // The print has the value from the state on that the answer names.
    const double from = member(set.json(), "change").number;
    const JsonValue state = viewer.wait_for([&](const JsonValue& s) {
        return is_done(s) && member(member(s, "live"), "change").number >= from;
    });
    EXPECT_NEAR(share(state), 0.25, 0.02);
    EXPECT_EQ(viewer.get("/api/state?known=-7").status, 400);
    // Many that wait take no thread from the others.
    std::vector<std::future<HttpAnswer>> many;
    const std::string now = fmt::format("/api/state?known={}", change_of(state));
    for (int i = 0; i < 20; ++i)
        many.push_back(std::async(std::launch::async, [&] { return viewer.get(now); }));
    EXPECT_EQ(viewer.get("/api/live").status, 200);
    viewer.post("/api/revert", "{}");
    for (std::future<HttpAnswer>& one : many)
        EXPECT_EQ(one.get().status, 200);
}

TEST_F(ViewWorld, OfAPrintTheWorldTellsPartsAndWhatTheDitherWasGiven) {
    const std::string file = (scratch_ / "cube.ofr").string();
    const Outcome printed = run({program("openfab"), "print", world(), "-o", file, "--set",
                                 "cube.share=0.125", "--draft", "2"},
                                {{{"OPENFAB_CACHE", cache()}}, {}, {}});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const std::string voxel = "?generation=1&print=0&x=5&y=5&z=5";
    {
        const Viewer viewer({file, "--world", world(), "--set", "cube.share=0.125"}, cache());
        const JsonValue pick = viewer.get("/api/pick" + voxel).json();
        EXPECT_EQ(member(pick, "part").text,
                  fmt::format(viewer::messages::kPlacementOf, "cube", 1, 2));
        const JsonValue amounts = viewer.get("/api/amounts" + voxel).json();
        EXPECT_NEAR(member(amounts, "fractions").items.at(0).number, 0.125, 1e-5);
        EXPECT_NEAR(member(amounts, "fractions").items.at(1).number, 0.875, 1e-5);
    }
    // Of another world, or none.
    const Viewer other({file, "--world", world()}, cache());
    const HttpAnswer refused = other.get("/api/amounts" + voxel);
    EXPECT_EQ(refused.status, 422);
    EXPECT_THAT(refused.body, Says(viewer::messages::kWorldChanged, "uniforms"));
    const Viewer alone({file});
    EXPECT_EQ(alone.get("/api/amounts" + voxel).status, 404);
}

TEST_F(ViewWorld, OfAMeshThatWasPrintedAloneItsFabletTellsWhatTheDitherWasGiven) {
    scratch_.write("corner.obj",
                   "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    const std::string mesh = (scratch_ / "corner.obj").string();
    const std::string fablet = (scratch_ / "halves.fl").string();
    const std::string file = (scratch_ / "corner.ofr").string();
    const Outcome printed = run({program("openfab"), "print", mesh, "--fablet", fablet, "-o", file,
                                 "--draft", "2", "--set", "corner.share=0.125"},
                                {{{"OPENFAB_CACHE", cache()}}, {}, {}});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const std::string voxel = "?generation=1&print=0&x=2&y=2&z=2";
    const auto view = [&](const std::string& setting) {
        const Viewer viewer({file, "--world", mesh, "--fablet", fablet, "--set", setting}, cache());
        return viewer.get("/api/amounts" + voxel);
    };
    const JsonValue amounts = view("corner.share=0.125").json();
    EXPECT_NEAR(member(amounts, "fractions").items.at(0).number, 0.125, 1e-5);
    EXPECT_NEAR(member(amounts, "fractions").items.at(1).number, 0.875, 1e-5);
    const HttpAnswer refused = view("corner.share=0.25");
    EXPECT_EQ(refused.status, 422);
    EXPECT_THAT(refused.body, Says(viewer::messages::kWorldChanged, "uniforms"));
}

TEST_F(ViewWorld, AMeshIsShownAsTheWorldThatAnImportMakesOfIt) {
    const auto box = [](int x) {
        std::string text;
        for (int i = 0; i < 8; ++i)
            text += fmt::format("v {} {} {}\n", x + 2 * (i & 1), i & 2, (i & 4) / 2);
        return text;
    };
    const auto faces = [](int first) {
        std::string text;
        for (const auto& f : {std::array{0, 2, 3, 1},
                              {4, 5, 7, 6},
                              {0, 1, 5, 4},
                              {2, 6, 7, 3},
                              {0, 4, 6, 2},
                              {1, 3, 7, 5}})
            text += fmt::format("f {} {} {} {}\n", first + f[0], first + f[1], first + f[2],
                                first + f[3]);
        return text;
    };
    scratch_.write("two.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    scratch_.write("two.obj", "mtllib two.mtl\n" + box(0) + box(2) + "o left\nusemtl red\n" +
                                  faces(1) + "o right\nusemtl blue\n" + faces(9));
    const std::filesystem::path kept = scratch_ / "kept";
    std::filesystem::create_directory(kept);
    ASSERT_EQ(setenv("TMPDIR", kept.c_str(), 1), 0);
    {
        Viewer viewer({(scratch_ / "two.obj").string(), "--draft", "1"}, cache());
        viewer.says(tools::messages::kWorldOfViewer);
        const JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
        const JsonValue& materials = member(member(state, "prints").items.at(0), "materials");
        ASSERT_EQ(materials.items.size(), 2u);
        EXPECT_EQ(member(materials.items[0], "name").text, "red");
        EXPECT_EQ(member(materials.items[0], "voxels").number,
                  member(materials.items[1], "voxels").number);
        EXPECT_EQ(
            member(member(viewer.get("/api/live").json(), "objects").items.at(1), "name").text,
            "right");
        EXPECT_FALSE(std::filesystem::is_empty(kept));
    }
    // The world goes with the viewer, and nothing is left beside the mesh.
    EXPECT_TRUE(std::filesystem::is_empty(kept));
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "two.fab.json"));
    unsetenv("TMPDIR");
}

TEST_F(ViewWorld, AFabletIsCheckedAsItIsTypedAndSavedAsItIsOnDisk) {
    const Viewer viewer({world(), "--watch"}, cache());
    JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    const JsonValue source = viewer.get("/api/source?fablet=0").json();
    EXPECT_EQ(member(source, "text").text, kFablet);
    const std::string stamp = member(source, "stamp").text;
    const auto body = [&](const std::string& text, const std::string& with) {
        std::string quoted;
        for (const char c : text)
            quoted += c == '\n' ? "\\n" : std::string(1, c);
        return R"({"fablet": 0, "text": ")" + quoted + R"(", "stamp": ")" + with + "\"}";
    };
    std::string wrong = kFablet;
    wrong.replace(wrong.find("1 - share"), 9, "1 - shame");
    const JsonValue checked = viewer.post("/api/check", body(wrong, "")).json();
    const JsonValue& error = member(checked, "diagnostics").items.at(0);
    EXPECT_EQ(member(error, "fablet").number, 0);
    EXPECT_EQ(member(error, "line").number, 9);
    EXPECT_EQ(member(error, "column").number, 23);
    EXPECT_EQ(member(error, "end_column").number, 28);
    EXPECT_THAT(member(error, "message").text, HasSubstr("shame"));
    EXPECT_EQ(read_file(scratch_ / "halves.fl"), kFablet);
    EXPECT_TRUE(
        member(viewer.post("/api/check", body(kFablet, "")).json(), "diagnostics").items.empty());

    // Saved with a mistake: it is told, and the last print stays.
    EXPECT_EQ(viewer.post("/api/source", body(wrong, "0000000000000000")).status, 422);
    const HttpAnswer saved = viewer.post("/api/source", body(wrong, stamp));
    ASSERT_EQ(saved.status, 200);
    EXPECT_EQ(read_file(scratch_ / "halves.fl"), wrong);
    state = viewer.wait_for(
        [](const JsonValue& s) { return member(member(s, "live"), "phase").text == "failed"; });
    EXPECT_EQ(member(state, "prints").items.size(), 1u);
    EXPECT_EQ(member(viewer.get("/api/live").json(), "diagnostics").items.size(), 1u);

    std::string other = kFablet;
    other.replace(other.find("share = 0.5"), 11, "share = 0.75");
    const std::string now = member(saved.json(), "stamp").text;
    ASSERT_EQ(viewer.post("/api/source", body(other, now)).status, 200);
    const double before = member(state, "generation").number;
    state = viewer.wait_for([&](const JsonValue& s) { return has_done(s, before + 1); });
    EXPECT_NEAR(share(state), 0.75, 0.1);  // at the draft's pitch: 250 voxels
}

TEST_F(ViewWorld, ACurveIsShownByItsKeysAndSetByThem) {
    std::string fablet = kFablet;
    fablet.replace(fablet.find("float share = 0.5"), 17, "Spline curve");
    const size_t body = fablet.find("MaterialComposition mc;");
    fablet.insert(body, "float share = curve.At(attr.voxelCenter.x); ");
    scratch_.write("halves.fl", fablet);
    std::string text = world_text();
    text.insert(text.find("\"a\": \"white\""), R"("curve": {"keys": [[-1, 0.5], [1, 0.5]]}, )");
    scratch_.write("cube.fab.json", text);
    const Viewer viewer({world(), "--watch", "--draft", "1"}, cache());
    JsonValue state = viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    EXPECT_NEAR(share(state), 0.5, 0.02);
    const JsonValue details = viewer.get("/api/live").json();
    const JsonValue curve = uniform_of(details, "curve");
    EXPECT_EQ(member(curve, "kind").text, "curve");
    const JsonValue& keys = member(member(curve, "value").items.at(0), "keys");
    ASSERT_EQ(keys.items.size(), 2u);
    EXPECT_EQ(keys.items[1].items.at(0).number, 1);

    const auto set = [&](const std::string& value) {
        return viewer.post("/api/set",
                           R"({"object": "cube", "uniform": "curve", "value": )" + value + "}");
    };
    EXPECT_EQ(set(R"({"keys": [[0, "a"]]})").status, 422);
    const double before = member(state, "generation").number;
    ASSERT_EQ(set(R"({"keys": [[0, 0.25], [9, 0.25]], "interpolation": "step"})").status, 200);
    state = viewer.wait_for([&](const JsonValue& s) { return has_done(s, before + 1); });
    EXPECT_NEAR(share(state), 0.25, 0.02);
    ASSERT_EQ(viewer.post("/api/write", "{}").status, 200);
    EXPECT_THAT(read_file(world()), HasSubstr(R"("step")"));
}

TEST_F(ViewWorld, WithoutADraftThePrintBecomesAsFineAsThePartNeeds) {
    const Viewer viewer({world(), "--watch"}, cache());
    const auto finest = [](const JsonValue& s) {
        return is_done(s) && member(member(s, "live"), "printed_draft").number == 1;
    };
    const JsonValue coarse = viewer.wait_for(is_done);
    const auto width = [](const JsonValue& s) {
        return member(member(s, "prints").items.at(0), "size").items.at(0).number;
    };
    const double first = member(member(coarse, "live"), "printed_draft").number;
    const JsonValue fine = viewer.wait_for(finest);
    EXPECT_EQ(member(member(fine, "live"), "draft").number, 0);
    if (first > 1) {
        EXPECT_GT(width(fine), width(coarse));
    }
    EXPECT_GT(width(fine), 20) << "the cube is of few voxels";
    ASSERT_EQ(viewer.post("/api/draft", R"({"draft": 4})").status, 200);
    const JsonValue chosen = viewer.wait_for([](const JsonValue& s) {
        return is_done(s) && member(member(s, "live"), "printed_draft").number == 4;
    });
    EXPECT_NEAR(width(fine) / width(chosen), 4, 0.6);
}

TEST_F(ViewWorld, ControlsStayWhileTheWorldOrAFabletIsWrong) {
    const Viewer viewer({world(), "--watch"}, cache());
    viewer.wait_for([](const JsonValue& s) { return has_done(s, 1); });
    const auto failed = [](const JsonValue& s) {
        return member(member(s, "live"), "phase").text == "failed";
    };
    const auto done = [](const JsonValue& s) { return has_done(s, 1); };
    for (const auto& [file, right] :
         {std::pair{"cube.fab.json", world_text()}, {"halves.fl", kFablet}}) {
        scratch_.write(file, std::string(right).substr(0, 100));
        viewer.wait_for(failed);
        const JsonValue details = viewer.get("/api/live").json();
        EXPECT_EQ(member(uniform_of(details, "share"), "type").text, "float") << file;
        EXPECT_EQ(member(uniform_of(details, "a"), "value").items.at(0).text, "white") << file;
        EXPECT_EQ(member(details, "materials").items.size(), 2u) << file;
        scratch_.write(file, right);
        viewer.wait_for(done);
    }
    // Nor does a wrong world open what lies beyond its folder.
    const ScratchFolder elsewhere;
    elsewhere.write("secret.fl", "// a secret\n");
    scratch_.write("cube.fab.json", "{");
    viewer.wait_for(failed);
    std::filesystem::remove(scratch_ / "halves.fl");
    std::filesystem::create_symlink(elsewhere / "secret.fl", scratch_ / "halves.fl");
    const HttpAnswer answer = viewer.get("/api/source?fablet=0");
    EXPECT_NE(answer.status, 200);
    EXPECT_EQ(answer.body.find("a secret"), std::string::npos);
}

}  // namespace
}  // namespace openfab::testing
