// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab fit` against closed forms: shares, volumes and weights of boxes and balls, counted in the print of what was
// found; choices, aims, steps; the same for any number of threads; and what is wrong, named before time is spent.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "tests/programs/tools/fit_folder.h"
#include "tests/support/says/says.h"
#include "tools/fit/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kFablet = R"(enum Way { PLAIN, HALF = 4, FULL };
fablet Mix {
    @uniform {
        float t = 0.5;
        float edge = 0;
        float2 pair = float2(0.5, 0.5);
        int rings = 3;
        bool flip = false;
        Way way = PLAIN;
        bool inner = false, outer = false;
        float2x2 corner = float2x2(1, 2, 3, 4);
        float sharp = 1;
        float idle = 0 [[ float min = 0, float max = 1 ]];
        Material a, b;
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float s = t * pair.x * 2;
        if (sharp > 1.5) s = p.x < edge ? 1 : 0;
        if (rings != 3) s = rings / 10.0;
        if (inner && outer) s = 0.9;
        if (way == HALF) s = 0.45;
        if (way == FULL) s = 0.95;
        if (flip && rings == 3 && sharp < 0.5) s = corner._m10 / 10;
        if (flip) s = 1 - s;
        mc.Set(a, s);
        mc.Set(b, 1 - s);
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"mix": {"source": "mix.fl", "fablet": "Mix"}},
  "materials": {"light": {"key": "#ffffff", "density_g_cm3": 1.0}, "heavy": {"key": "#000000", "density_g_cm3": 2.0}},
  "meshes": {"block": {"box": [10, 5, 4]}},
  "objects": {"thing": {"mesh": "block", "fablet": "mix", "uniforms": {"a": "heavy", "b": "light"}}},
  "build": [{"object": "thing"}]
}
)";

class FitTest : public FitFolder {
  protected:
    void SetUp() override {
        folder_.write("mix.fl", kFablet);
        folder_.write("w.fab.json", kWorld);
    }
};

TEST_F(FitTest, AShareIsLinearInItsUniform) {
    const JsonValue found =
        fit(R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
            {"-o", path("new.fab.json")});
    EXPECT_NEAR(unknown(found, "thing.t"), 0.3, 1e-3 * 0.3);
    EXPECT_NEAR(goal(found, "mixtures"), 0.3, 1e-3 * 0.3);
    EXPECT_NEAR(goal(found, "printed"), 0.3, 1e-3 * 0.3);
    // The third number is that of the print, to the last voxel.
    const Outcome printed =
        openfab({"print", path("new.fab.json"), "-o", path("new.ofr"), "--stats", path("s.json")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Result<JsonValue> stats = parse_json(read_file(folder_ / "s.json"), "s.json");
    ASSERT_TRUE(stats);
    const JsonValue& ml = stats->find("ml_by_material")->value;
    const double heavy = ml.find("heavy")->value.number, light = ml.find("light")->value.number;
    EXPECT_NEAR(heavy / (heavy + light), goal(found, "printed"), 1e-5);
}

TEST_F(FitTest, AllElseOfTheWorldStays) {
    fit(R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.25})", {"--write"});
    const std::string written = read_file(folder_ / "w.fab.json");
    const size_t at = written.find("\"t\": ");
    ASSERT_NE(at, std::string::npos) << written;
    std::string rest = written;
    rest.erase(at, written.find(',', at) + 2 - at);
    EXPECT_EQ(rest, kWorld);
}

TEST_F(FitTest, TwoGoalsOfTwoUnknowns) {
    // 0.2 ml of which a share t is twice as heavy weigh 0.2 (1 + t) g.
    const JsonValue found =
        fit(R"("thing.t": {"min": 0.1, "max": 1}, "thing.pair[0]": {"min": 0.1, "max": 0.5})",
            R"({"weight_g": "all", "equal": 0.25}, {"volume_ml": "heavy", "at_most": 0.06})");
    const double share = 2 * unknown(found, "thing.t") * unknown(found, "thing.pair[0]");
    EXPECT_NEAR(share, 0.25, 1e-3);
    EXPECT_NEAR(goal(found, "printed", 1), 0.05, 1e-3 * 0.06);
}

TEST_F(FitTest, TheMostUnderABound) {
    const JsonValue found =
        fit(R"("thing.t": {"min": 0, "max": 1})",
            R"({"weight_g": "all", "aim": "most"}, {"share": "heavy", "at_most": 0.4})");
    EXPECT_NEAR(unknown(found, "thing.t"), 0.4, 1e-3);
    EXPECT_NEAR(goal(found, "printed", 0), 0.28, 1e-3);
}

TEST_F(FitTest, AMovingFaceCountsInItsBox) {
    // Of the 10 mm along x, from the middle: heavy below the edge; in the box from -5 to 0 all of it.
    fit(R"("thing.edge": {"min": -5, "max": 5})",
        R"({"volume_ml": "heavy", "equal": 0.13, "within": 0.001},
           {"share": "heavy", "box_mm": [[-5, -3, -1], [0, 3, 5]], "at_least": 0.999})",
        {"--set", "thing.sharp=2", "--voxel", "0.05mm"});
    EXPECT_THAT(last_.out, HasSubstr("in the box"));
    const JsonValue found = fit(R"("thing.edge": {"min": -5, "max": 5})",
                                R"({"volume_ml": "heavy", "equal": 0.13, "within": 0.001})",
                                {"--set", "thing.sharp=2", "--voxel", "0.05mm"});
    EXPECT_NEAR(unknown(found, "thing.edge"), 1.5, 0.05 + 0.025);
}

TEST_F(FitTest, APropertyIsLinearBetweenItsRows) {
    folder_.write("hard.json",
                  R"({"property": "hardness", "unit": "Shore", "materials": ["light", "heavy"],
        "rows": [{"mixture": [1, 0], "value": 20}, {"mixture": [0.5, 0.5], "value": 70}, {"mixture": [0, 1], "value": 90}]})");
    const JsonValue found = fit(R"("thing.t": {"min": 0, "max": 1})",
                                R"({"property": "hard.json", "equal": 50, "within": 0.1})");
    // 20 + 100 t up to a half.
    EXPECT_NEAR(unknown(found, "thing.t"), 0.3, 2e-3);
    EXPECT_NEAR(goal(found, "mixtures"), 50, 0.1);
    EXPECT_THAT(last_.out, HasSubstr("hardness Shore"));
    // Blocks have a little more or less, on both sides of a straight part of the table.
    EXPECT_NEAR(goal(found, "printed"), 50, 0.5);
    write_goals(R"("thing.t": {"min": 0, "max": 1})", R"({"property": "hard.json", "equal": 95})");
    EXPECT_THAT(openfab({"fit", path("w.fab.json"), path("goals.json")}).err,
                HasSubstr("`equal` of `property`"));
    folder_.write("hard.json", R"({"materials": ["light", "heavi"], "rows": [{}, {}]})");
    EXPECT_THAT(openfab({"fit", path("w.fab.json"), path("goals.json")}).err,
                HasSubstr("did you mean `heavy`?"));
}

TEST_F(FitTest, WhatWasTriedBeforeChangesNothing) {
    // A surface that moves, a loop that asks for distances: set up again, and in place.
    folder_.write("mix.fl", R"(fablet Mix {
    @uniform { float t = 0.5; float bump = 0.2; Material a, b; }
    @Surface(@varying { SurfaceAttributes attr }) {
        return attr.n * bump * (1 + sin(attr.p.x * 3));
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float sum = 0;
        for (int k = 0; k < 3; ++k) sum += saturate(-distance(p + float3(0.3 * k, 0, 0)) * t) / 3;
        mc.Set(a, sum);
        mc.Set(b, 1 - sum);
        return mc;
    }
}
)");
    const std::string goals =
        R"({"volume_ml": "heavy", "at_least": 0}, {"weight_g": "all", "aim": "least"})";
    const auto with = [&](const std::string& unknowns) {
        fit(unknowns, goals, {"--history", path("h.csv"), "--voxel", "0.2mm"});
        std::set<std::string> lines;
        const std::string text = read_file(folder_ / "h.csv");
        for (size_t at = text.find('\n') + 1; at < text.size();) {
            const size_t end = text.find('\n', at);
            lines.insert(text.substr(text.find(',', at), end - text.find(',', at)));
            at = end + 1;
        }
        return lines;
    };
    const auto choices = [](const char* t, const char* bump) {
        return fmt::format(R"("thing.t": {{"choices": [{}]}}, "thing.bump": {{"choices": [{}]}})",
                           t, bump);
    };
    const std::set<std::string> one = with(choices("0.4, 0.9, 0.6", "0.1, 0.3"));
    EXPECT_EQ(one.size(), 6U);
    EXPECT_EQ(one, with(choices("0.6, 0.4, 0.9", "0.3, 0.1")));
}

TEST_F(FitTest, AnObjectIsCountedAlone) {
    // Beside a block of light resin alone, of the same size.
    std::string world = kWorld;
    const auto put = [&](const std::string& after, const std::string& text) {
        world.insert(world.find(after) + after.size(), text);
    };
    put(R"("objects": {)", R"("other": {"mesh": "block", "fablet": "mix",
        "uniforms": {"t": 0, "a": "heavy", "b": "light"}}, )");
    put(R"("build": [)", R"({"object": "other", "translate_mm": [20, 0, 0]}, )");
    folder_.write("w.fab.json", world);
    const JsonValue found = fit(R"("thing.t": {"min": 0, "max": 1})",
                                R"({"share": "heavy", "object": "thing", "equal": 0.3})");
    EXPECT_NEAR(unknown(found, "thing.t"), 0.3, 1e-3 * 0.3);
    const JsonValue both =
        fit(R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})");
    EXPECT_NEAR(unknown(both, "thing.t"), 0.6, 1e-3 * 0.6);
    write_goals(R"("thing.t": {"min": 0, "max": 1})",
                R"({"share": "heavy", "object": "othr", "equal": 0.3})");
    EXPECT_THAT(openfab({"fit", path("w.fab.json"), path("goals.json")}).err,
                HasSubstr("did you mean `other`?"));
}

TEST_F(FitTest, ChoicesAreTried) {
    const JsonValue rings = fit(R"("thing.rings": {"min": 4, "max": 9})",
                                R"({"share": "heavy", "equal": 0.7, "within": 0.01})");
    EXPECT_EQ(unknown(rings, "thing.rings"), 7);
    // The materials change places, or the shares do.
    const JsonValue mixed = fit(
        R"("thing.a": {"choices": ["light", "heavy"]}, "thing.b": {"choices": ["light", "heavy"]},
           "thing.t": {"min": 0, "max": 0.3})",
        R"({"share": "light", "equal": 0.2})");
    const JsonValue& unknowns = mixed.find("unknowns")->value;
    EXPECT_EQ(unknowns.find("thing.a")->value.text, "light");
    EXPECT_EQ(unknowns.find("thing.b")->value.text, "heavy");
    EXPECT_NEAR(unknown(mixed, "thing.t"), 0.2, 1e-3);
    const JsonValue flipped = fit(R"("thing.flip": {}, "thing.t": {"min": 0.6, "max": 1})",
                                  R"({"share": "heavy", "equal": 0.2})");
    EXPECT_TRUE(flipped.find("unknowns")->value.find("thing.flip")->value.boolean);
    EXPECT_NEAR(unknown(flipped, "thing.t"), 0.8, 1e-3);
    // Of an enum all names are.
    const JsonValue named = fit(R"("thing.way": {})", R"({"share": "heavy", "equal": 0.95})");
    EXPECT_EQ(named.find("unknowns")->value.find("thing.way")->value.text, "FULL");
    write_goals(R"("thing.way": {"min": 0, "max": 2})", R"({"share": "heavy", "equal": 0.95})");
    EXPECT_THAT(openfab({"fit", path("w.fab.json"), path("goals.json")}).err,
                Says(fit::messages::kBoundOfNames));
    // All of a matrix, whose third number is a share in tenths, that is turned round.
    fit(R"("thing.corner": {"choices": [[[1, 2], [3, 4]], [[1, 2], [6, 4]]]})",
        R"({"share": "heavy", "equal": 0.4})",
        {"--set", "thing.flip=true", "--set", "thing.sharp=0"});
    EXPECT_THAT(last_.out, HasSubstr("[[1,2],[6,4]]"));
}

TEST_F(FitTest, OfWholeNumbersThatReachTheNearestToTheStartIsTaken) {
    const JsonValue found = fit(R"("thing.rings": {"min": 4, "max": 9, "start": 7})",
                                R"({"share": "heavy", "at_least": 0.5})");
    EXPECT_EQ(unknown(found, "thing.rings"), 7);
    EXPECT_EQ(goal(found, "printed") >= 0.69, true);
}

TEST_F(FitTest, UnknownsThatCountOnlyTogetherAreFound) {
    // Two switches; and a product of two numbers that are 0 both.
    const JsonValue both =
        fit(R"("thing.inner": {}, "thing.outer": {})", R"({"share": "heavy", "equal": 0.9})");
    EXPECT_TRUE(both.find("unknowns")->value.find("thing.outer")->value.boolean);
    EXPECT_THAT(last_.err, Not(Says(fit::messages::kUnknownMovesNothing, "*")));
    const JsonValue product = fit(
        R"("thing.t": {"min": 0, "max": 1, "start": 0}, "thing.pair[0]": {"min": 0, "max": 1, "start": 0})",
        R"({"share": "heavy", "equal": 0.3})");
    EXPECT_NEAR(2 * unknown(product, "thing.t") * unknown(product, "thing.pair[0]"), 0.3, 1e-3);
}

TEST_F(FitTest, WhatWasSetBelongsToWhatWasFound) {
    const JsonValue found =
        fit(R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
            {"--set", "thing.pair=[0.25, 0.5]"});
    EXPECT_NEAR(unknown(found, "thing.t"), 0.6, 1e-3);
    EXPECT_THAT(last_.out, HasSubstr("--set 'thing.pair=[0.25, 0.5]' --set thing.t=0."));
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{"-o", path("new.fab.json")}, {"--write"}}) {
        std::vector<std::string> words{"fit", path("w.fab.json"), path("goals.json"), "--set",
                                       "thing.pair=[0.25, 0.5]"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome refused = openfab(words);
        EXPECT_EQ(refused.exit_code, 2) << refused.out;
        EXPECT_THAT(refused.err, Says(fit::messages::kOutputSets, more[0]));
    }
}

TEST_F(FitTest, AShapeIsSetUpAgain) {
    // The ball of 0.2 ml: of its radius r, 4/3 pi r^3.
    folder_.write("ball.fl", R"(fablet Ball {
    @uniform { float r = 2; Material stuff; }
    @Shape(@varying { ShapeAttributes attr }) { return length(attr.p) - r; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(stuff, 1);
        return mc;
    }
}
)");
    folder_.write("w.fab.json", R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"ball": {"source": "ball.fl", "fablet": "Ball"}},
  "materials": {"light": {"key": "#ffffff"}},
  "meshes": {"round": {"shape": "ball", "box_mm": [[-5, -5, -5], [5, 5, 5]]}},
  "objects": {"thing": {"mesh": "round", "fablet": "ball", "uniforms": {"stuff": "light"}}},
  "build": [{"object": "thing"}]
}
)");
    const JsonValue found = fit(R"("thing.r": {"min": 1, "max": 5})",
                                R"({"volume_ml": "light", "equal": 0.2})", {"--voxel", "0.1mm"});
    const double radius = std::cbrt(200 * 3 / (4 * std::numbers::pi));
    EXPECT_NEAR(unknown(found, "thing.r"), radius, 2e-3 * radius);
    EXPECT_NEAR(goal(found, "printed"), 0.2, 1e-3 * 0.2);

    // Of which there is nothing at a bound; and nothing beside the print.
    write_goals(R"("thing.r": {"min": 0, "max": 5})", R"({"volume_ml": "light", "equal": 0.2})");
    last_ = openfab({"fit", path("w.fab.json"), path("goals.json")});
    EXPECT_EQ(last_.exit_code, 1);
    EXPECT_THAT(last_.err, HasSubstr("with `thing.r=0`: the shape `Ball`"));
    EXPECT_THAT(last_.err, HasSubstr(fit::messages::kWithSettingsHelp));
    write_goals(R"("thing.r": {"min": 1, "max": 5})",
                R"({"volume_ml": "light", "equal": 0.2, "box_mm": [[20, 20, 20], [30, 30, 30]]})");
    last_ = openfab({"fit", path("w.fab.json"), path("goals.json")});
    EXPECT_EQ(last_.exit_code, 1);
    EXPECT_THAT(last_.err, Says(fit::messages::kNothingInBox, "volume of light in the box"));
    EXPECT_THAT(last_.err, HasSubstr("the print spans [[-"));
}

TEST_F(FitTest, ThreadsChangeNothing) {
    const auto with = [&](const std::string& threads) {
        fit(R"("thing.t": {"min": 0, "max": 1}, "thing.pair[0]": {"min": 0.1, "max": 0.5})",
            R"({"share": "heavy", "equal": 0.3}, {"weight_g": "all", "aim": "least"})",
            {"--threads", threads, "--history", path("h" + threads + ".csv")});
        return read_file(folder_ / ("h" + threads + ".csv"));
    };
    const std::string one = with("1");
    EXPECT_EQ(one, with("2"));
    EXPECT_THAT(one, HasSubstr("evaluation,\"thing.t\",\"thing.pair[0]\",\"share of heavy\""));
}

TEST_F(FitTest, AnInterruptKeepsTheBest) {
    // Two goals that no value meets, so that it would search for long.
    write_goals(R"("thing.t": {"min": 0, "max": 1}, "thing.pair[0]": {"min": 0.1, "max": 0.5})",
                R"({"share": "heavy", "equal": 0.3}, {"weight_g": "all", "equal": 0.3})");
    RunOptions options;
    options.interrupt_when = [](int, const Outcome& so_far) {
        return so_far.err.find("100 evaluations") != std::string::npos;
    };
    const Outcome ended = openfab({"fit", path("w.fab.json"), path("goals.json"), "--voxel",
                                   "0.05mm", "-o", path("best.fab.json")},
                                  options);
    EXPECT_EQ(ended.exit_code, 130) << ended.err;
    EXPECT_THAT(ended.err, Says(fit::messages::kInterruptedBest));
    EXPECT_THAT(ended.out, HasSubstr("not counted"));
    EXPECT_THAT(read_file(folder_ / "best.fab.json"), HasSubstr("\"pair\": ["));
}

TEST_F(FitTest, StepsAreTold) {
    const JsonValue found =
        fit(R"("thing.edge": {"min": -5, "max": 5})", R"({"share": "heavy", "equal": 0.4567})",
            {"--set", "thing.sharp=2", "--voxel", "0.5mm"}, 1);
    EXPECT_FALSE(found.find("reached")->value.boolean);
    // A slice of twenty, of which none is the share that is wanted.
    EXPECT_NEAR(goal(found, "printed"), 0.45, 1e-6);
    EXPECT_THAT(last_.err, Says(fit::messages::kSteps, "share of heavy", "0.05"));
    EXPECT_THAT(last_.err, Says(fit::messages::kNotReached));
}

TEST_F(FitTest, WhatCannotBeIsTold) {
    fit(R"("thing.t": {"min": 0, "max": 0.4})", R"({"share": "heavy", "equal": 0.6})", {}, 1);
    EXPECT_THAT(last_.err, Says(fit::messages::kRange, "share of heavy", "0", "0.4*"));
    fit(R"("thing.t": {"min": 0, "max": 1}, "thing.idle": {})",
        R"({"share": "heavy", "equal": 0.6})");
    EXPECT_THAT(last_.err, Says(fit::messages::kUnknownMovesNothing, "thing.idle"));
}

TEST_F(FitTest, Refusals) {
    const struct {
        std::string unknowns, goals, says;
    } cases[] = {
        {R"("thing.tt": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
         "did you mean `t`?"},
        {R"("thng.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
         "did you mean `thing`?"},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavi", "equal": 0.3})",
         "did you mean `heavy`?"},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"weight_kg": "heavy", "equal": 0.3})",
         "did you mean `weight_g`?"},
        {R"("thing.t": {"min": 1, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
         fit::messages::kNoRoomHelp},
        {R"("thing.t": {"min": 0})", R"({"share": "heavy", "equal": 0.3})", "give `max`"},
        {R"("thing.t": {"min": 0, "max": 1})",
         R"({"share": "heavy", "equal": 0.3}, {"share": "heavy", "at_least": 0.5})",
         "share of heavy contradicts the goal in line 3"},
        {R"("thing.t": {"min": 0, "max": 1})",
         R"({"share": "heavy", "at_least": 0.6}, {"share": "light", "at_least": 0.6})",
         fit::messages::kSharesBeyondOneHelp},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 1.3})", "`equal`"},
        {R"("thing.pair": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
         "name `thing.pair[0]` to `thing.pair[1]`"},
        {R"("thing.a": {"min": 0, "max": 1})", R"({"share": "heavy", "equal": 0.3})",
         fit::messages::kChoicesMissingHelp},
        {R"("thing.a": {"choices": ["heavy", "hevy"]})", R"({"share": "heavy", "equal": 0.3})",
         "did you mean `heavy`?"},
        {R"("thing.idle": {})", R"({"share": "heavy", "equal": 0.3})",
         fit::messages::kGoalMovesNotHelp},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"cost": "all", "equal": 0.3})",
         fit::messages::kNoPricesHelp},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"share": "all", "equal": 0.3})",
         fit::messages::kShareOfAllHelp},
        {R"("thing.t": {"min": 0, "max": 1})", R"({"share": "heavy"})",
         fit::messages::kOneRelationHelp},
        {R"("thing.t": {"min": 0, "max": 1})",
         R"({"share": "heavy", "volume_ml": "heavy", "equal": 0.3})",
         fit::messages::kTwoQuantitiesHelp},
    };
    for (const auto& one : cases) {
        SCOPED_TRACE(one.unknowns + one.goals);
        write_goals(one.unknowns, one.goals);
        const Outcome outcome = openfab({"fit", path("w.fab.json"), path("goals.json")});
        EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
        EXPECT_THAT(outcome.err, HasSubstr("goals.json:"));
        EXPECT_THAT(outcome.err, HasSubstr(one.says));
    }
    const std::vector<std::string> fit{"fit", path("w.fab.json"), path("goals.json")};
    const auto with = [&](std::vector<std::string> words) {
        words.insert(words.begin(), fit.begin(), fit.end());
        return openfab(words);
    };
    EXPECT_THAT(openfab({"fit", path("w.fab.json")}).err, Says(fit::messages::kNameBoth));
    EXPECT_THAT(with({"--drft", "2"}).err, HasSubstr("`--drft`"));
    EXPECT_THAT(with({"--drft", "2"}).err, HasSubstr("`--draft`"));
    EXPECT_THAT(with({"-o", path("w.fab.json")}).err, HasSubstr("w.fab.json"));
    EXPECT_THAT(with({"--history", path("h.txt")}).err, Says(fit::messages::kHistoryEnds));
    EXPECT_THAT(with({"-o", path("new.txt")}).err, Says(fit::messages::kOutputEnds));
    EXPECT_EQ(read_file(folder_ / "w.fab.json"), kWorld);
}

}  // namespace
}  // namespace openfab::testing
