// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a machine asks of a world before it is printed: `--check` of a print, `openfab split` and `openfab arrange`.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class MachineCommands : public ::testing::Test {
  protected:
    MachineCommands() {
        scratch_.write("plain.fl", R"(fablet Plain {
    @uniform { Material body; float dots = 0; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 1);
        return mc;
    }
}
)");
        scratch_.write("p.printer.json", R"({"name": "p", "pitch_mm": [0.1, 0.1, 0.1],
            "build_volume_mm": [20, 10, 8], "native_format": "ofr",
            "process": {"checks": {"wall_mm": 0.35}}})");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    void write_world(const std::string& name, const std::string& meshes, const std::string& objects,
                     const std::string& build) {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json",
  "fablets": {{"plain": {{"source": "plain.fl", "fablet": "Plain", "uniforms": {{"body": "resin"}}}}}},
  "materials": {{"resin": {{"key": "#ffffff"}}, "hard": {{"key": "#204080"}}}},
  "meshes": {{{}}},
  "objects": {{{}}},
  "build": [{}]
}})",
                                         meshes, objects, build));
    }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    rapidjson::Document world(const std::string& name) const {
        rapidjson::Document out;
        out.Parse(read_file(path(name)).c_str());
        EXPECT_TRUE(out.IsObject()) << name;
        return out;
    }

    static bool says_like(const std::string& text, int draft) {
        return is_like(text,
                       pattern_of(tools::messages::kCheckTakesHelp, {"*", std::to_string(draft)}));
    }

    ScratchFolder scratch_;
};

TEST_F(MachineCommands, APrintIsCheckedBeforeItIsMade) {
    write_world(
        "thin.fab.json", R"("plate": {"box": [0.2, 3, 3]}, "cube": {"box": [2, 2, 2]})",
        R"("plate": {"mesh": "plate", "fablet": "plain"}, "cube": {"mesh": "cube", "fablet": "plain"})",
        R"({"object": "plate", "rotate_deg": [0, 0, 20]}, {"object": "cube", "translate_mm": [4, 0, 0]})");
    const Outcome bad = openfab({"print", path("thin.fab.json"), "-o", path("a.ofr"), "--check",
                                 "--check-picture", path("a.png")});
    EXPECT_EQ(bad.exit_code, 1) << bad.err;
    EXPECT_THAT(bad.err, testing::Says(tools::messages::kFindingLine, "wall*", "0.19*", "mm",
                                       " (limit 0.35)"));
    EXPECT_THAT(bad.err, testing::Says(tools::messages::kPlacesNotAllowed, "1", " that"));
    EXPECT_THAT(bad.err, testing::Says(tools::messages::kNothingPrintedAfterCheck));
    EXPECT_EQ(bad.out, "");
    EXPECT_FALSE(fs::exists(path("a.ofr")));
    EXPECT_GT(fs::file_size(path("a.png")), 500u);
    // It is the print that is looked at: its pitch, its limits.
    scratch_.write("loose.json", R"({"checks": {"wall_mm": 0.1}})");
    const Outcome fine = openfab({"print", path("thin.fab.json"), "-o", path("b.ofr"), "--check",
                                  "--process", path("loose.json")});
    EXPECT_EQ(fine.exit_code, 0) << fine.err;
    const Outcome without = openfab(
        {"print", path("thin.fab.json"), "-o", path("c.ofr"), "--process", path("loose.json")});
    EXPECT_EQ(without.exit_code, 0) << without.err;
    EXPECT_TRUE(read_file(path("b.ofr")) == read_file(path("c.ofr")));
    const Outcome itself = openfab({"print", path("thin.fab.json"), "-o", path("d.ofr"),
                                    "--check-picture", path("thin.fab.json")});
    EXPECT_EQ(itself.exit_code, 1);
    EXPECT_THAT(itself.err, HasSubstr("--check-picture"));
    EXPECT_THAT(read_file(path("thin.fab.json")), HasSubstr("\"openfab\": 1"));
}

TEST_F(MachineCommands, ChecksFindHolesPostsAndPartsThatTouchAlongAnEdge) {
    write_world(
        "small.fab.json",
        R"("plate": {"extrusion": {"polygons": [[[-2, -2], [2, -2], [2, 2], [-2, 2]],
            [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]], "height": 1}},
           "post": {"box": [0.2, 0.2, 3]}, "cube": {"box": [2, 2, 2]}, "small": {"box": [1, 1, 1]})",
        R"("plate": {"mesh": "plate", "fablet": "plain"}, "post": {"mesh": "post", "fablet": "plain"},
           "cube": {"mesh": "cube", "fablet": "plain"}, "small": {"mesh": "small", "fablet": "plain"})",
        R"({"object": "plate", "translate_mm": [3, 3, 1]}, {"object": "post", "translate_mm": [6.53, 3.27, 2]},
           {"object": "cube", "translate_mm": [9, 3, 2]}, {"object": "small", "translate_mm": [10.5, 4.5, 2]})");
    const auto check = [&](std::vector<std::string> limits) {
        limits.insert(limits.begin(), {"check", path("small.fab.json")});
        // Other limits than those given are as good as none.
        for (const auto& [option, least] : {std::pair{"--wall", "0.01mm"},
                                            {"--gap", "0.01mm"},
                                            {"--hole", "0.01mm"},
                                            {"--island", "0mm3"}}) {
            if (std::find(limits.begin(), limits.end(), option) == limits.end()) {
                limits.emplace_back(option);
                limits.emplace_back(least);
            }
        }
        return openfab(limits);
    };
    const auto finds = [&](const std::vector<std::string>& limits, const char* what,
                           const char* how_much, const char* limit) {
        const Outcome found = check(limits);
        EXPECT_EQ(found.exit_code, 1) << found.out << found.err;
        EXPECT_THAT(found.out,
                    testing::Says(tools::messages::kFindingLine, fmt::format("{}*", what), how_much,
                                  "*", fmt::format(" (limit {})", limit)));
    };
    const auto finds_nothing = [&](const std::vector<std::string>& limits) {
        const Outcome found = check(limits);
        EXPECT_EQ(found.exit_code, 0) << found.out << found.err;
    };
    finds({"--hole", "0.5mm"}, "hole", "0.4", "0.5");
    finds({"--hole", "1.2mm"}, "hole", "0.4", "1.2");
    finds({"--gap", "0.6mm"}, "gap", "0.4", "0.6");
    finds({"--hole", "0.6mm", "--gap", "0.7mm"}, "hole", "0.4", "0.6");
    finds_nothing({"--hole", "0.4mm", "--gap", "0.4mm"});
    finds({"--wall", "0.3mm"}, "wall", "0.2*", "0.3");
    finds({"--wall", "0.8mm"}, "wall", "0.2*", "0.8");
    // Two cubes that touch along an edge are joined by nothing.
    finds({"--wall", "0.2mm"}, "wall", "0.0*", "0.2");
    finds({"--island", "1.5mm3"}, "island", "1", "1.5");
}

TEST_F(MachineCommands, ALengthWithoutAUnitIsShownWithOne) {
    write_world("post.fab.json", R"("post": {"box": [1, 1, 6]})",
                R"("post": {"mesh": "post", "fablet": "plain"})", R"({"object": "post"})");
    const std::string world = path("post.fab.json");
    const std::pair<std::string, std::vector<std::string>> commands[] = {
        {"--wall", {"check", world, "--wall", "0.3"}},
        {"--gap", {"check", world, "--gap", "0.3"}},
        {"--hole", {"check", world, "--hole", "0.3"}},
        {"--gap", {"arrange", world, "-o", path("t.fab.json"), "--gap", "0.3"}},
    };
    for (const auto& [option, words] : commands) {
        const Outcome told = openfab(words);
        EXPECT_EQ(told.exit_code, 2) << told.err;
        EXPECT_THAT(told.err, HasSubstr("`" + option + "`: "));
        EXPECT_THAT(told.err, Says(messages::kNoUnit, "0.3", "0.3mm"));
    }
}

TEST_F(MachineCommands, AChecksAdviceFitsTheMemory) {
    write_world("apart.fab.json", R"("post": {"box": [1, 1, 6]})",
                R"("post": {"mesh": "post", "fablet": "plain"})",
                R"({"object": "post"}, {"object": "post", "translate_mm": [17, 8, 0]})");
    for (const int draft : {1, 2}) {
        const std::string memory = draft == 1 ? "4MB" : "400kB";
        const auto check = [&](int at) {
            return openfab({"check", path("apart.fab.json"), "--wall", "0.1mm", "--memory", memory,
                            "--draft", std::to_string(at)});
        };
        const Outcome refused = check(draft);
        EXPECT_EQ(refused.exit_code, 1);
        ASSERT_THAT(refused.err, testing::Says(tools::messages::kCheckTakes));
        int advised = 0;
        for (int at = draft + 1; at < 9; ++at) {
            if (says_like(refused.err, at)) advised = at;
        }
        ASSERT_GT(advised, draft) << refused.err;
        EXPECT_THAT(check(advised).err, Not(testing::Says(tools::messages::kCheckTakes)));
    }
    // Who gives no draft gets the finest that fits, and is told so.
    const auto check = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"check", path("apart.fab.json"), "--wall", "0.1mm", "--memory",
                                   "400kB", "--report", path("report.json")});
        return openfab(more);
    };
    const Outcome coarser = check({});
    const std::string found = read_file(path("report.json"));
    int taken = 0;
    for (int draft = 2; draft < 65; ++draft) {
        if (is_like(coarser.err, pattern_of(tools::messages::kCheckedCoarser,
                                            {"*", "400 kB", std::to_string(draft)})))
            taken = draft;
    }
    ASSERT_GT(taken, 1) << coarser.err;
    const Outcome asked = check({"--draft", std::to_string(taken)});
    EXPECT_EQ(coarser.exit_code, asked.exit_code) << asked.err;
    EXPECT_EQ(found, read_file(path("report.json")));
    const Outcome finer = check({"--draft", std::to_string(taken - 1)});
    EXPECT_THAT(finer.err, testing::Says(tools::messages::kCheckTakes));
    const Outcome fewer = openfab(
        {"check", path("apart.fab.json"), "--wall", "0.1mm", "--memory", "20MB", "--parts", "3"});
    EXPECT_THAT(fewer.err, testing::Says(tools::messages::kCheckTakesPartsHelp, "*", "1"));
}

TEST_F(MachineCommands, ArrangeTakesAsManyTraysAsItNeeds) {
    // Twelve blocks of 4 x 3 mm, 1 mm apart, on trays of 20 x 10 mm: eight on each at most.
    write_world(
        "many.fab.json", R"("block": {"box": [4, 3, 2]}, "pole": {"box": [1, 1, 12]})",
        R"("block": {"mesh": "block", "fablet": "plain"}, "pole": {"mesh": "pole", "fablet": "plain"})",
        R"({"object": "block", "grid": {"count": [12, 1, 1], "spacing_mm": 1}, "uniforms": {"dots": 3}})");
    const Outcome done =
        openfab({"arrange", path("many.fab.json"), "-o", path("t.fab.json"), "--gap", "1mm"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_FALSE(fs::exists(path("t-3.fab.json")));
    size_t count = 0;
    for (const char* name : {"t.fab.json", "t-2.fab.json"}) {
        const rapidjson::Document tray = world(name);
        std::vector<std::array<double, 4>> boxes;
        for (const auto& item : tray["build"].GetArray()) {
            EXPECT_EQ(item["uniforms"]["dots"].GetDouble(), 3);
            const bool turned = item.HasMember("matrix");
            const auto& at = turned ? item["matrix"] : item["translate_mm"];
            const double x = at[turned ? 3u : 0u].GetDouble();
            const double y = at[turned ? 7u : 1u].GetDouble();
            const double w = turned ? 1.5 : 2, h = turned ? 2 : 1.5;
            EXPECT_GE(x - w, -1e-6);
            EXPECT_LE(x + w, 20 + 1e-6);
            EXPECT_GE(y - h, -1e-6);
            EXPECT_LE(y + h, 10 + 1e-6);
            for (const auto& o : boxes) {
                EXPECT_TRUE(std::fabs(x - o[0]) >= w + o[2] + 1 - 1e-6 ||
                            std::fabs(y - o[1]) >= h + o[3] + 1 - 1e-6);
            }
            boxes.push_back({x, y, w, h});
            ++count;
        }
        const Outcome dry = openfab({"print", path(name), "--dry-run"});
        EXPECT_EQ(dry.exit_code, 0) << dry.err;
    }
    EXPECT_EQ(count, 12u);

    // What stands too high lies down if it may.
    write_world("pole.fab.json", R"("pole": {"box": [1, 1, 12]})",
                R"("pole": {"mesh": "pole", "fablet": "plain"})", R"({"object": "pole"})");
    const Outcome high = openfab({"arrange", path("pole.fab.json"), "-o", path("u.fab.json")});
    EXPECT_EQ(high.exit_code, 1);
    EXPECT_THAT(high.err,
                testing::Says(tools::messages::kDoesNotFit,
                              fmt::format(tools::messages::kTheObject, "pole"), 1, 1, 12));
    EXPECT_THAT(high.err, testing::Says(tools::messages::kCutItOrTurnIt));
    EXPECT_EQ(openfab({"arrange", path("pole.fab.json"), "-o", path("u.fab.json"), "--turn", "all"})
                  .exit_code,
              0);
    EXPECT_EQ(openfab({"arrange", path("pole.fab.json"), "-o", path("pole.fab.json")}).exit_code,
              2);
    EXPECT_EQ(
        openfab({"arrange", path("pole.fab.json"), "-o", path("u.fab.json"), "--turn", "left"})
            .exit_code,
        2);
}

TEST_F(MachineCommands, ArrangeMakesCopies) {
    write_world(
        "two.fab.json", R"("block": {"box": [4, 3, 2]}, "pole": {"box": [1, 1, 2]})",
        R"("block": {"mesh": "block", "fablet": "plain"}, "pole": {"mesh": "pole", "fablet": "plain"},
           "spare": {"mesh": "pole", "fablet": "plain"})",
        R"({"object": "block", "uniforms": {"dots": 3}}, {"object": "pole"})");
    const auto arrange = [&](std::vector<std::string> copies) {
        copies.insert(copies.begin(),
                      {"arrange", path("two.fab.json"), "-o", path("t.fab.json"), "--gap", "1mm"});
        return openfab(copies);
    };
    const auto count = [&] {
        std::map<std::string, int> out;
        for (const char* name : {"t.fab.json", "t-2.fab.json"}) {
            if (!fs::exists(path(name))) continue;
            const rapidjson::Document tray = world(name);
            for (const auto& item : tray["build"].GetArray()) {
                const std::string object = item["object"].GetString();
                ++out[object];
                EXPECT_EQ(item.HasMember("uniforms"), object == "block");
            }
            const Outcome dry = openfab({"print", path(name), "--dry-run"});
            EXPECT_EQ(dry.exit_code, 0) << dry.err;
            fs::remove(path(name));
        }
        return out;
    };
    using Counts = std::map<std::string, int>;
    ASSERT_EQ(arrange({"--copies", "3"}).exit_code, 0);
    EXPECT_EQ(count(), (Counts{{"block", 3}, {"pole", 3}}));
    ASSERT_EQ(arrange({"--copies", "2", "--copies", "block=9"}).exit_code, 0);
    EXPECT_EQ(count(), (Counts{{"block", 9}, {"pole", 2}}));
    ASSERT_EQ(arrange({"--copies=pole=5"}).exit_code, 0);
    EXPECT_EQ(count(), (Counts{{"block", 1}, {"pole", 5}}));
    for (const char* wrong : {"0", "-1", "x", "block=", "2.5", "block=100001"}) {
        const Outcome refused = arrange({std::string("--copies=") + wrong});
        EXPECT_EQ(refused.exit_code, 2) << wrong;
        EXPECT_THAT(refused.err, testing::Says(tools::messages::kBadCopies, wrong)) << wrong;
    }
    for (const char* nothing : {"blok=2", "spare=2"}) {
        const Outcome refused = arrange({std::string("--copies=") + nothing});
        EXPECT_EQ(refused.exit_code, 2) << nothing;
        EXPECT_THAT(refused.err, testing::Says(tools::messages::kCopiesOfNothing, nothing));
    }
    EXPECT_THAT(arrange({"--copies=60000"}).err, testing::Says(tools::messages::kTooManyCopies));
}

TEST_F(MachineCommands, SplitPiecesArePlacedAnewAndPrint) {
    write_world("bar.fab.json", R"("bar": {"box": [50, 6, 5]})",
                R"("bar": {"mesh": "bar", "fablet": "plain"})", R"({"object": "bar"})");
    const Outcome done = openfab({"split", path("bar.fab.json"), "--fit", path("p.printer.json"),
                                  "-o", path("cut.fab.json"), "--peg", "2mm", "--skin", "1mm",
                                  "--number", "2mm", "--gap", "1mm", "--material", "hard"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("3 pieces (its box: 3)"));
    size_t things = 0;
    std::vector<std::string> words{"arrange"};
    for (int tray = 1; tray < 9; ++tray) {
        const std::string name = tray == 1 ? "cut.fab.json" : fmt::format("cut-{}.fab.json", tray);
        if (!fs::exists(path(name))) break;
        things += world(name)["build"].Size();
        words.push_back(path(name));
        const Outcome dry = openfab({"print", path(name), "--dry-run"});
        EXPECT_EQ(dry.exit_code, 0) << dry.err;
    }
    EXPECT_GE(things, 5u);  // three pieces, and two dowels at least
    const rapidjson::Document apart = world("exploded-cut.fab.json");
    EXPECT_STREQ(apart["build"][0]["piece"].GetString(), "all");
    EXPECT_GT(apart["build"][0]["explode_mm"].GetDouble(), 1);
    const Outcome shown = openfab({"print", path("exploded-cut.fab.json"), "--dry-run"});
    EXPECT_EQ(shown.exit_code, 0) << shown.err;
    // All of them again, on a tray that holds all.
    words.insert(words.end(), {"-o", path("anew.fab.json"), "--fit", "60x40x20mm"});
    const Outcome again = openfab(words);
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(world("anew.fab.json")["build"].Size(), things);
    write_world("other.fab.json", R"("bar": {"box": [5, 6, 5]})",
                R"("bar": {"mesh": "bar", "fablet": "plain"})", R"({"object": "bar"})");
    const Outcome mixed = openfab(
        {"arrange", path("bar.fab.json"), path("other.fab.json"), "-o", path("anew.fab.json")});
    EXPECT_EQ(mixed.exit_code, 1);
    EXPECT_THAT(mixed.err, testing::Says(tools::messages::kWorldsDiffer));
}

TEST_F(MachineCommands, AnObjectInSeveralSizesIsCutAsNone) {
    const auto split = [&](const std::string& build, const std::string& fit) {
        write_world("sizes.fab.json", R"("cube": {"box": [6, 6, 6]})",
                    R"("cube": {"mesh": "cube", "fablet": "plain"})", build);
        return openfab({"split", path("sizes.fab.json"), "--fit", fit, "-o", path("cut.fab.json"),
                        "--peg", "0mm", "--number", "0mm"});
    };
    const std::string small = R"({"object": "cube", "rotate_deg": [0, 0, 90]})",
                      large = R"({"object": "cube", "scale": 2, "translate_mm": [20, 0, 0]})";
    for (const std::string& build : {small + ", " + large, large + ", " + small}) {
        const Outcome refused = split(build, "8x8x8mm");
        EXPECT_EQ(refused.exit_code, 1);
        EXPECT_THAT(refused.err, testing::Says(tools::messages::kPlacementsUnlike, "cube"));
        EXPECT_EQ(split(build, "13x13x13mm").exit_code, 0);
    }
    EXPECT_EQ(
        split(small + R"(, {"object": "cube", "translate_mm": [20, 0, 0]})", "4x8x8mm").exit_code,
        0);
}

// What the machine enlarges about a place still lies on its tray.
TEST_F(MachineCommands, TraysKnowTheMachinesScale) {
    for (const char* about : {"[0, 0, 0]", "[40, 20, 0]"}) {
        scratch_.write("s.printer.json", std::string(R"({"name": "s", "pitch_mm": [0.1, 0.1, 0.1],
            "build_volume_mm": [20, 10, 8], "native_format": "ofr",
            "process": {"scale": [1.05, 1.02, 1.01], "about_mm": )") +
                                             about + "}}");
        write_world("bars.fab.json", R"("bar": {"box": [9.4, 9.7, 7.8]})",
                    R"("bar": {"mesh": "bar", "fablet": "plain"})",
                    R"({"object": "bar"}, {"object": "bar", "translate_mm": [20, 0, 0]})");
        const Outcome done =
            openfab({"arrange", path("bars.fab.json"), "--fit", path("s.printer.json"), "-o",
                     path("tray.fab.json"), "--gap", "0.2mm"});
        ASSERT_EQ(done.exit_code, 0) << done.err;
        EXPECT_THAT(done.out, HasSubstr("a tray with 2 things, 19 x 9.7 x 7.8 mm"));
        const Outcome print = openfab({"print", path("tray.fab.json"), "--estimate"});
        EXPECT_EQ(print.exit_code, 0) << about << print.err;
        // Larger, it is on the tray before the machine's scale alone.
        write_world("bars.fab.json", R"("bar": {"box": [9.4, 9.7, 7.95]})",
                    R"("bar": {"mesh": "bar", "fablet": "plain"})", R"({"object": "bar"})");
        EXPECT_EQ(openfab({"arrange", path("bars.fab.json"), "--fit", path("s.printer.json"), "-o",
                           path("tray.fab.json")})
                      .exit_code,
                  1);
    }
}

// Dowels are longer than pieces are put apart by the machine's size, and cuts meet that move both pieces of one.
TEST_F(MachineCommands, ExplodedPiecesAndDowelsAreApart) {
    write_world("slab.fab.json", R"("slab": {"box": [30, 26, 12]})",
                R"("slab": {"mesh": "slab", "fablet": "plain"})", R"({"object": "slab"})");
    const Outcome done = openfab({"split", path("slab.fab.json"), "--fit", "18x15x15mm", "-o",
                                  path("cut.fab.json"), "--peg", "3mm", "--skin", "1mm", "--number",
                                  "0mm", "--gap", "1mm", "--material", "hard"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("4 pieces"));
    // Out of their holes, for the pieces on their two sides may move apart along the cut.
    EXPECT_GE(world("exploded-cut.fab.json")["build"][0]["explode_mm"].GetDouble(), 7.5);
    // Half in them: they move along with both pieces.
    std::string near = read_file(path("exploded-cut.fab.json"));
    const size_t gap = near.find("\"explode_mm\": ") + 14;
    near.replace(gap, near.find_first_of(",}", gap) - gap, "2.2");
    scratch_.write("near.fab.json", near);
    for (const char* name : {"exploded-cut.fab.json", "near.fab.json"}) {
        const Outcome print = openfab(
            {"print", path(name), "-o", path("e.ofr"), "--voxel", "0.25mm", "--progress", "none"});
        EXPECT_EQ(print.exit_code, 0);
        EXPECT_EQ(print.err, "") << name;
    }
}

TEST_F(MachineCommands, SeamsGoWhereColoursChangeAndAwayFromStress) {
    scratch_.write("halves.fl", R"(fablet Halves {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter.x > 3 ? a : b, 1);
        return mc;
    }
}
)");
    // Aslant, so that the print's places are not those of the mesh.
    const auto write_bar = [&](const std::string& name, const std::string& pose) {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json",
  "fablets": {{"h": {{"source": "halves.fl", "fablet": "Halves", "uniforms": {{"a": "w", "b": "r"}}}}}},
  "materials": {{"w": {{"key": "#ffffff"}}, "r": {{"key": "#a01010"}}}},
  "meshes": {{"bar": {{"box": [30, 6, 5]}}}},
  "objects": {{"bar": {{"mesh": "bar", "fablet": "h"}}}},
  "build": [{{"object": "bar"{}}}]
}})",
                                         pose));
    };
    write_bar("bar.fab.json", R"(, "rotate_deg": [0, 0, 40], "translate_mm": [7, -3, 2])");
    scratch_.write("wide.printer.json", R"({"name": "p", "pitch_mm": [0.1, 0.1, 0.1],
        "build_volume_mm": [60, 60, 20], "native_format": "ofr"})");
    const Outcome look =
        openfab({"print", path("bar.fab.json"), "--printer", path("wide.printer.json"), "--draft",
                 "3", "-o", path("look.ofr")});
    ASSERT_EQ(look.exit_code, 0) << look.err;
    const auto cut_at = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> words{
            "split", path(name), "--fit", path("p.printer.json"), "-o", path("c.fab.json"), "--peg",
            "0mm",   "--number", "0mm"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome done = openfab(words);
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return world("c.cuts.json")["at_mm"].GetDouble();
    };
    EXPECT_NEAR(cut_at("bar.fab.json", {"--look", path("look.ofr")}), 3, 0.7);

    write_bar("flat.fab.json", "");
    std::string volume =
        "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: 30 2 2\n"
        "space directions: (1,0,0) (0,10,0) (0,0,10)\nspace origin: (-14.5,-5,0)\n"
        "encoding: ascii\n\n";
    for (int i = 0; i < 30 * 4; ++i)
        volume += i % 30 == 11 ? "0.1 " : "1 ";
    scratch_.write("stress.nrrd", volume + "\n");
    EXPECT_NEAR(cut_at("flat.fab.json", {"--stress", path("stress.nrrd")}), -3.5, 0.5);
    const Outcome wrong = openfab({"split", path("flat.fab.json"), "--fit", path("p.printer.json"),
                                   "-o", path("c.fab.json"), "--look", path("stress.nrrd")});
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.err, HasSubstr("not an .ofr file"));
}

}  // namespace
}  // namespace openfab::testing
