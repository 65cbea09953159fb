// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab mechanics` as a person runs it: what it refuses, how it ends, and that it keeps its memory.

#include <gmock/gmock.h>

#include <filesystem>
#include <string>

#include "mechanics/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kFablets = R"(fablet Plain {
    @uniform { Material stuff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(stuff, 1);
        return mc;
    }
}
)";
constexpr const char* kMix = R"(fablet Mix {
    @uniform { float share = 0.3; Material soft, stiff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(soft, 1 - share);
        mc.Set(stiff, share);
        return mc;
    }
}
)";
constexpr const char* kMaterials = R"({"materials": {
    "soft": {"E_MPa": 0.6, "nu": 0.48, "strength_MPa": 1, "density_g_cm3": 1.1},
    "stiff": {"E_MPa": 2000, "nu": 0.35, "strength_MPa": 50, "density_g_cm3": 1.2}}})";
constexpr const char* kHeld = R"("held": [{"side": "-z"}])";
constexpr const char* kPush = R"("loads": [{"side": "+z", "force_N": [0, 0, -10]}])";

class Mechanics : public ::testing::Test {
  protected:
    Mechanics() {
        scratch_.write("plain.fl", kFablets);
        scratch_.write("mix.fl", kMix);
        scratch_.write("mechanics.json", kMaterials);
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    /// A world of boxes of 20 x 10 x 10 mm, where they are told to stand, with one case.
    std::string world(const std::string& one_case, const std::string& places = "[0, 0, 0]") const {
        std::string build;
        for (size_t at = 0; at < places.size(); ++at) {
            const size_t end = places.find(']', at) + 1;
            if (!build.empty()) build += ", ";
            build += R"({"object": "box", "translate_mm": )" + places.substr(at, end - at) + "}";
            at = end;
        }
        scratch_.write("world.fab.json",
                       R"({"openfab": 1, "printer": "generic",
    "fablets": {"plain": {"source": "plain.fl", "fablet": "Plain"},
                "mix": {"source": "mix.fl", "fablet": "Mix"}},
    "materials": {"soft": {"key": "#e0e0d0"}, "stiff": {"key": "#23415e"}},
    "meshes": {"box": {"box": [20, 10, 10]}},
    "objects": {"box": {"mesh": "box", "fablet": "plain", "uniforms": {"stuff": "stiff"}},
                "mixed": {"mesh": "box", "fablet": "mix", "uniforms": {"soft": "soft", "stiff": "stiff"}}},
    "build": [)" + build + "], \"cases\": {\"one\": {" +
                           one_case + "}}}");
        return path("world.fab.json");
    }
    Outcome mechanics(std::vector<std::string> arguments, RunOptions options = {}) const {
        arguments.insert(arguments.begin(), {program("openfab"), "mechanics"});
        options.environment.emplace_back("OPENFAB_CACHE", path("cache"));
        return run(arguments, options);
    }
    /// What a case is refused with.
    std::string refused(const std::string& one_case, const std::string& places = "[0, 0, 0]",
                        std::vector<std::string> more = {"--voxel", "1mm"}) const {
        more.insert(more.begin(), {"part", world(one_case, places)});
        const Outcome out = mechanics(more);
        EXPECT_EQ(out.exit_code, 1) << out.out << out.err;
        return out.err;
    }
    static std::string both(const char* a, const char* b) { return std::string(a) + ", " + b; }

    ScratchFolder scratch_;
};

TEST_F(Mechanics, WhatIsWrongIsNamedWithWhatToDo) {
    EXPECT_THAT(refused(kPush), AllOf(HasSubstr("world.fab.json:"),
                                      testing::Says(mechanics::messages::kNothingHeld),
                                      testing::Says(mechanics::messages::kNothingHeldHelp)));
    EXPECT_THAT(refused(kHeld),
                AllOf(testing::Says(mechanics::messages::kNothingLoads), HasSubstr("`loads`")));
    EXPECT_THAT(
        refused(both(kHeld, R"("loads": [{"box_mm": [[50, 0, 0], [60, 1, 1]],
                                                  "force_N": [0, 0, 1]}])")),
        AllOf(testing::Says(mechanics::messages::kLoadOnNothing), HasSubstr("world.fab.json:")));
    EXPECT_THAT(refused(both(R"("held": [{"object": "bolt"}])", kPush)), HasSubstr("`bolt`"));
    EXPECT_THAT(refused(both(R"("held": [{"side": "-z", "along": "z"}])", kPush)),
                AllOf(testing::Says(mechanics::messages::kCaseLetsMove),
                      testing::Says(mechanics::messages::kHoldMoreFaces)));
    // Two boxes, of which the second hangs in the air.
    EXPECT_THAT(
        refused(both(kHeld, kPush), "[0, 0, 0], [0, 0, 15]"),
        AllOf(testing::Says(mechanics::messages::kPieceNotHeld, "2"), HasSubstr("`--loose`")));
    EXPECT_THAT(refused(both(kHeld, kPush), "[0, 0, 0]", {"--voxel", "7mm"}),
                AllOf(testing::Says(mechanics::messages::kThinWallsHelp), HasSubstr("thin")));
    scratch_.write("mechanics.json", R"({"materials": {"stiff": {"nu": 0.3}}})");
    EXPECT_THAT(refused(both(kHeld, kPush)),
                AllOf(testing::Says(mechanics::messages::kNoModulus, "stiff"),
                      HasSubstr("mechanics.json:1:")));
    scratch_.write("mechanics.json", R"({"materials": {"soft": {"E_MPa": 1, "nu": 0.3}}})");
    EXPECT_THAT(refused(both(kHeld, kPush)),
                AllOf(testing::Says(mechanics::messages::kMaterialUnknown, "*", "stiff"),
                      HasSubstr("add")));
    fs::remove(path("mechanics.json"));
    EXPECT_THAT(refused(both(kHeld, kPush)), testing::Says(mechanics::messages::kNoMaterialsFile));
}

TEST_F(Mechanics, OptionsWithNothingToActOnAreRefused) {
    const std::string name = world(std::string(kHeld) + ", " + kPush);
    const std::pair<std::vector<std::string>, const char*> all[] = {
        {{"--law", "voigt", "--codes"}, "--law excludes --codes"},
        {{"--supersample", "2", "--codes"}, "--supersample excludes --codes"},
        {{"--dither", "majority"}, "--dither requires --codes"},
        {{"--view", "3:4"}, "--view requires --preview"},
    };
    for (const auto& [words, told] : all) {
        std::vector<std::string> argv{
            program("openfab").string(), "mechanics", "part", name, "--case", "one"};
        argv.insert(argv.end(), words.begin(), words.end());
        const Outcome refused = run(argv);
        EXPECT_EQ(refused.exit_code, 2) << told;
        EXPECT_THAT(refused.err, HasSubstr(told));
    }
}

TEST_F(Mechanics, WhatDoesNotFitIsRefusedBeforeItIsPrinted) {
    const std::string text =
        refused(both(kHeld, kPush), "[0, 0, 0]", {"--voxel", "0.01mm", "--memory", "500MB"});
    EXPECT_THAT(text, AllOf(testing::Says(mechanics::messages::kTooMuchMemory),
                            testing::Says(mechanics::messages::kTooMuchMemoryHelp)));
    // The pitch that it names does.
    const std::string help = mechanics::messages::kTooMuchMemoryHelp;
    const size_t number = help.find('{');
    const size_t at = text.find(help.substr(0, number)) + number;
    const double pitch = 0.01 * std::stod(text.substr(at));
    const Outcome fits = mechanics({"part", world(both(kHeld, kPush)), "--voxel",
                                    std::to_string(pitch) + "mm", "--memory", "500MB"});
    EXPECT_EQ(fits.exit_code, 0) << fits.err;
    EXPECT_LE(fits.peak_rss_bytes, 500 << 20);
    const Outcome cell = mechanics({"cell", path("mix.fl"), "--cell", "10mm", "--voxel", "0.01mm"});
    EXPECT_EQ(cell.exit_code, 1);
    EXPECT_THAT(cell.err, testing::Says(mechanics::messages::kTooMuchMemory));
}

// What the print says of the mesh is no part of its size.
TEST_F(Mechanics, AMeshThatIntersectsItselfIsCalculated) {
    std::string mesh;
    for (const int corner : {0, 5}) {
        for (int v = 0; v < 8; ++v)
            mesh += "v " + std::to_string(corner + 10 * (v & 1)) + " " +
                    std::to_string(corner + 10 * (v >> 1 & 1)) + " " +
                    std::to_string(corner + 10 * (v >> 2)) + "\n";
        for (const char* face : {"-8 -6 -5 -7", "-4 -3 -1 -2", "-8 -7 -3 -4", "-6 -2 -1 -5",
                                 "-8 -4 -2 -6", "-7 -5 -1 -3"})
            mesh += std::string("f ") + face + "\n";
    }
    scratch_.write("two.obj", mesh);
    const fs::path file = world(both(kHeld, kPush));
    std::string text = read_file(file);
    const std::string box = R"("box": {"box": [20, 10, 10]})";
    text.replace(text.find(box), box.size(), R"("box": {"file": "two.obj", "unit": "mm"})");
    scratch_.write("world.fab.json", text);
    const Outcome out = mechanics({"part", file, "--voxel", "1mm"});
    EXPECT_EQ(out.exit_code, 0) << out.err;
    // 2 cubes of 1000 voxels, which share 125.
    EXPECT_THAT(out.out, HasSubstr("1875 solid elements"));
}

size_t iterations_told(const Outcome& outcome) {
    size_t count = 0;
    for (size_t at = 0; (at = outcome.err.find("iteration ", at)) != std::string::npos; ++at)
        ++count;
    return count;
}

TEST_F(Mechanics, CtrlCEndsItAtTheNextIteration) {
    const fs::path temporary = path("temporary");
    fs::create_directory(temporary);
    // While it solves, and while what it starts compiles and prints.
    for (const bool solving : {true, false}) {
        RunOptions options;
        options.environment = {{"TMPDIR", temporary.string()}};
        size_t before = 0;
        options.interrupt_when = [&](int, const Outcome& so_far) {
            const bool now = solving ? so_far.err.find("iteration") != std::string::npos
                                     : !fs::is_empty(temporary);
            if (now) before = iterations_told(so_far);
            return now;
        };
        const Outcome out = mechanics({"part", world(both(kHeld, kPush)), "--voxel", "0.125mm",
                                       "--tolerance", "1e-12", "-o", path("never.vti")},
                                      options);
        EXPECT_EQ(out.exit_code, 128 + SIGINT) << out.err;
        EXPECT_LE(iterations_told(out), before + 2) << out.err;
        EXPECT_TRUE(fs::is_empty(temporary));
        EXPECT_FALSE(fs::exists(path("never.vti")));
        if (solving) {
            EXPECT_THAT(out.err, HasSubstr(" left\n"));
        }
    }
}

TEST_F(Mechanics, NumbersAreTheSameForAnyThreadsAndMemory) {
    std::string first;
    for (const char* threads : {"1", "2", "3"}) {
        const Outcome out =
            mechanics({"part", world(both(kHeld, kPush)), "--voxel", "0.5mm", "--threads", threads,
                       "--memory", std::string(threads) == "3" ? "2GB" : "300MB", "-o",
                       path("a.vti"), "-o", path("a.json")});
        ASSERT_EQ(out.exit_code, 0) << out.err;
        const std::string all = read_file(path("a.vti")) + read_file(path("a.json")) + out.out;
        if (first.empty()) first = all;
        EXPECT_TRUE(all == first) << threads;
    }
}

TEST_F(Mechanics, CodesAloneAreOneElementAVoxel) {
    // Without a law and a rule: the world's own dither, and each voxel of one material.
    const std::string file = world(both(kHeld, kPush));
    std::string text = read_file(file);
    text.replace(text.find(R"("object": "box")"), 15, R"("object": "mixed")");
    scratch_.write("world.fab.json", text);
    const Outcome out =
        mechanics({"part", file, "--codes", "--voxel", "1mm", "-o", path("codes.json")});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    EXPECT_THAT(out.out,
                AllOf(::testing::HasSubstr(std::string("2000 solid elements of 20 x 10 x 10, ") +
                                           mechanics::messages::kAsDithered),
                      HasSubstr("residual")));
    // The blocks of an export are of one material each, of both.
    const Outcome exported = mechanics(
        {"export", file, "--codes", "--voxel", "1mm", "--case", "one", "-o", path("codes.inp")});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    const std::string inp = read_file(path("codes.inp"));
    EXPECT_THAT(inp, AllOf(HasSubstr("soft"), HasSubstr("stiff"), HasSubstr("C3D8")));
}

// A block that is pushed at its own hold is not strained; a strut that is pressed far above Euler's load does
// not hold, though no stress says so; a corner's stress tends to nothing.
TEST_F(Mechanics, AVerdictIsOfWhatWasComputed) {
    const Outcome idle = mechanics(
        {"part", world(both(kHeld, R"("loads": [{"side": "-z", "force_N": [0, 0, -5]}])")),
         "--voxel", "1mm"});
    EXPECT_EQ(idle.exit_code, 0) << idle.err;
    EXPECT_THAT(idle.out, AllOf(testing::Says(mechanics::messages::kLoadOnHeld, "*"),
                                ::testing::Not(HasSubstr("it holds"))));
    const std::string file = world(both(R"("held": [{"side": "-x"}])",
                                        R"("loads": [{"side": "+x", "force_N": [-40, 0, 0]}])"));
    std::string text = read_file(file);
    text.replace(text.find("[20, 10, 10]"), 12, "[120, 2, 2]");
    scratch_.write("world.fab.json", text);
    // Euler's load is pi^2 2000 (16 / 12) / (4 * 120^2) = 0.457 N; the stress is 10 MPa, a fifth of the strength.
    const Outcome buckles = mechanics({"part", file, "--voxel", "0.5mm", "-o", path("b.json")});
    ASSERT_EQ(buckles.exit_code, 0) << buckles.err;
    EXPECT_THAT(buckles.out, AllOf(HasSubstr("it buckles"), ::testing::Not(HasSubstr("it holds"))));
    const std::string json = read_file(path("b.json"));
    const size_t at = json.find("\"factor\":");
    ASSERT_NE(at, std::string::npos) << json;
    EXPECT_NEAR(std::stod(json.substr(at + 9)) * 40 / 0.457, 1, 0.03);
    EXPECT_THAT(json, HasSubstr("\"buckles\""));
    EXPECT_THAT(mechanics({"part", file, "--voxel", "0.5mm", "--require", "1"}).err,
                testing::Says(mechanics::messages::kBucklesBelow));
    EXPECT_THAT(mechanics({"part", file, "--voxel", "0.5mm", "--buckling", "never"}).out,
                HasSubstr("unless it buckles"));
    // Less than two elements across.
    EXPECT_THAT(mechanics({"part", file, "--voxel", "1.5mm"}).err,
                testing::Says(mechanics::messages::kThinWalls));
    const Outcome thin = mechanics({"part", file, "--voxel", "1.5mm", "--thin"});
    EXPECT_THAT(thin.out, AllOf(HasSubstr("not resolved"), ::testing::Not(HasSubstr("it holds"))));
    // Where a block is held at its foot, stress has no limit.
    const Outcome corner = mechanics(
        {"part", world(both(kHeld, R"("loads": [{"side": "+z", "force_N": [20, 0, 0]}])")),
         "--voxel", "1mm", "--converge"});
    ASSERT_EQ(corner.exit_code, 0) << corner.err;
    EXPECT_THAT(corner.out, testing::Says(mechanics::messages::kNotSettled, "*stress at most*"));
}

// What stands and what does not, at any pitch: the foot is looked at in voxels of its own.
TEST_F(Mechanics, WhetherItStandsDoesNotDependOnThePitch) {
    const std::string file = world(both(kHeld, kPush));
    const std::string plain = read_file(file);
    const std::string box = R"({"box": [20, 10, 10]})";
    struct Part {
        const char *mesh, *turn;
        int exit_code;
    };
    for (const Part& part :
         {Part{R"({"box": [20, 10, 10]})", "[0, 0, 0]", 0},
          // Lower than the layers that are looked at.
          {R"({"box": [30, 30, 0.6]})", "[0, 0, 0]", 0},
          {R"({"sphere": 10})", "[0, 0, 0]", 1},
          {R"({"cylinder": [8, 20]})", "[90, 0, 0]", 1},
          {R"({"torus": [9, 3]})", "[90, 0, 0]", 1},
          {R"({"extrusion": {"polygons": [[[0, 0], [3, 10], [-3, 10]]], "height": 10}})",
           "[90, 0, 0]", 1},
          {R"({"extrusion": {"polygons": [[[-4, 0], [4, 0], [11, 10], [3, 10]]], "height": 10}})",
           "[90, 0, 0]", 0}}) {
        std::string text = plain;
        text.replace(text.find(box), box.size(), part.mesh);
        const std::string placed = R"("translate_mm": [0, 0, 0])";
        text.replace(text.find(placed), placed.size(),
                     std::string(R"("translate_mm": [0, 0], "rotate_deg": )") + part.turn);
        scratch_.write("world.fab.json", text);
        for (const char* voxel : {"1mm", "0.8x0.5x0.25mm"}) {
            const Outcome out =
                mechanics({"stand", file, "--voxel", voxel, "--modes", "0", "--thin"});
            EXPECT_EQ(out.exit_code, part.exit_code) << part.mesh << voxel << out.out << out.err;
            if (part.exit_code == 1) {
                EXPECT_THAT(out.err, testing::Says(mechanics::messages::kRolls));
            }
        }
    }
}

// What a print says of a setting is no bug of ours.
TEST_F(Mechanics, AWrongSettingEndsAsThePrintDoes) {
    const std::string file = world(both(kHeld, kPush));
    for (const char* command : {"part", "stand", "export"}) {
        std::vector<std::string> words{command, file, "--voxel", "1mm", "--set", "foo"};
        if (std::string(command) == "export") words.insert(words.end(), {"-o", path("x.inp")});
        const Outcome out = mechanics(words);
        EXPECT_THAT(out.exit_code, ::testing::AnyOf(1, 2)) << command << out.err;
    }
}

TEST_F(Mechanics, EachFigureSaysItsPitchElementsAndResidual) {
    const std::string file = world(both(kHeld, kPush));
    const auto all = AllOf(HasSubstr("pitch "), HasSubstr("elements"), HasSubstr("residual "));
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"part", file, "--voxel", "1mm", "--converge"},
          {"part", file, "--iterations", "1000"},
          {"stand", file, "--voxel", "1mm", "--modes", "2"},
          {"cell", path("mix.fl"), "--cell", "8mm", "--voxel", "1mm", "--converge"},
          {"cell", path("mix.fl"), "--cell", "8mm", "--voxel", "1mm", "--sweep",
           "share=0.2:0.4:2"}}) {
        const Outcome out = mechanics(command);
        EXPECT_EQ(out.exit_code, 0) << out.err;
        EXPECT_THAT(out.out, all) << command[0];
    }
}

}  // namespace
}  // namespace openfab::testing
