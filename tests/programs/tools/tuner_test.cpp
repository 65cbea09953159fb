// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab profile` and `openfab tune` on a small world: figures that add up, a schedule that prints
// the same bits, a search that goes on where it ended, and clear refusals.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <set>

#include "base/json.h"
#include "base/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/tuner/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr const char* kFablet = R"(fablet Layers {
    @uniform { Material body, core; float size = 0.7; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float wave = sin(attr.voxelCenter.x * 3 / size) * sin(attr.voxelCenter.y * 3 / size);
        float share = saturate(wave + distance(attr.voxelCenter) + 0.5);
        mc.Set(body, share);
        mc.Set(core, 1 - share);
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"layers": {"source": "layers.fl", "fablet": "Layers"}},
  "materials": {"resin": {"key": "#ffffff"}, "ink": {"key": "#000000"}},
  "meshes": {"block": {"box": [6, 5, 7]}},
  "objects": {"thing": {"mesh": "block", "fablet": "layers",
                        "uniforms": {"body": "resin", "core": "ink"}}},
  "build": [{"object": "thing"}]
}
)";

class TunerTest : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_.write("layers.fl", kFablet);
        folder_.write("w.fab.json", kWorld);
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    Outcome openfab(std::vector<std::string> words, RunOptions options = {}) const {
        words.insert(words.begin(), program("openfab"));
        options.environment.emplace_back("XDG_CACHE_HOME", path("cache"));
        return run(words, options);
    }
    JsonValue json(const std::string& name) const {
        const Result<JsonValue> value = parse_json(read_file(folder_ / name), name);
        EXPECT_TRUE(value) << value.error().text();
        return value ? *value : JsonValue();
    }
    static double number(const JsonValue& object, const std::string& key) {
        const JsonMember* member = object.find(key);
        EXPECT_NE(member, nullptr) << key;
        return member != nullptr ? member->value.number : 0;
    }

    ScratchFolder folder_;
};

TEST_F(TunerTest, ProfileAddsUp) {
    for (const std::string threads : {"1", "2"}) {
        SCOPED_TRACE(threads + " threads");
        const Outcome outcome =
            openfab({"profile", path("w.fab.json"), "--voxel", "0.05mm", "--threads", threads,
                     "--time", "2s", "--json", path("p.json")});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const JsonValue profile = json("p.json");
        EXPECT_EQ(number(profile, "threads"), std::stod(threads));
        std::set<std::string> names;
        double stages = 0, all = 0, slab = 0, by_thread = 0;
        for (const JsonValue& stage : profile.find("stages")->value.items) {
            const std::string& name = stage.find("name")->value.text;
            const double seconds = number(stage, "seconds");
            EXPECT_TRUE(names.insert(name).second) << name;
            all += seconds;
            if (name == "other" || name == "waiting") continue;
            stages += seconds;
            if (name == "slab") slab = seconds;
            for (const JsonValue& thread : stage.find("seconds_by_thread")->value.items)
                by_thread += thread.number;
        }
        EXPECT_THAT(names, IsSupersetOf({"coverage", "culling", "nearest", "slab", "dither", "pack",
                                         "encode", "commit", "waiting"}));
        // The system's count of the process's seconds is another clock than the threads' own. Threads
        // also spin for a while before they sleep, which is no stage; how long the machine's load decides.
        EXPECT_LE(stages / number(profile, "processor_seconds"), 1.1);
        EXPECT_GE(stages / number(profile, "processor_seconds"), 0.3);
        EXPECT_NEAR(all / number(profile, "thread_seconds"), 1, 1e-9);
        EXPECT_NEAR(by_thread / stages, 1, 1e-9);
        EXPECT_GT(slab, 0);
        double funcs = 0;
        std::set<std::string> func_names;
        for (const JsonValue& func : profile.find("slab_funcs")->value.items) {
            funcs += number(func, "seconds");
            func_names.insert(func.find("name")->value.text);
        }
        EXPECT_NEAR(funcs / slab, 1, 1e-9);
        EXPECT_TRUE(func_names.contains("values_*") || func_names.contains("weights"));
        EXPECT_LE(number(profile, "alone_seconds"), number(profile, "print_seconds"));
        EXPECT_THAT(outcome.out, HasSubstr("\nslab "));
        EXPECT_THAT(outcome.out, HasSubstr("\nsum "));
    }
}

TEST_F(TunerTest, TuneKeepsTheBitsAndGoesOn) {
    const auto tune = [&](const std::string& budget, const RunOptions& options = {}) {
        return openfab({"tune", path("w.fab.json"), "--voxel", "0.1mm", "-o", path("t.sched"),
                        "--budget", budget},
                       options);
    };
    // A schedule that the output has is compared with what is found.
    const Outcome built_in =
        run({program("openflc"), "emit", path("layers.fl"), "--stage", "slab", "--as", "schedule"});
    const size_t columns = built_in.out.find("member, 64)");
    ASSERT_NE(columns, std::string::npos) << built_in.out;
    folder_.write("t.sched", std::string(built_in.out).replace(columns, 11, "member, 16)"));
    const Outcome first = tune("3s");
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_THAT(first.err, testing::Says(tuner::messages::kChangesToTry));
    EXPECT_THAT(first.err, testing::Says(tuner::messages::kOfFirstsTime));
    EXPECT_THAT(first.err, testing::Says(tuner::messages::kHasSchedule, "*t.sched"));
    EXPECT_THAT(first.err, testing::Says(fmt::format(tuner::messages::kCompared,
                                                     tuner::messages::kVerdictIs, "{}")));
    const std::string made = read_file(folder_ / "t.sched");
    EXPECT_THAT(made, StartsWith("# Made by `openfab tune` for w on "));
    EXPECT_THAT(made, HasSubstr("\npipeline slab\nslab.split("));
    const std::string journal = read_file(folder_ / "t.sched.journal");
    const auto lines = std::count(journal.begin(), journal.end(), '\n');
    EXPECT_GE(lines, 2);

    // The file is a schedule, and prints what the built-in one prints.
    const auto print = [&](const std::string& output, const std::vector<std::string>& schedule) {
        std::vector<std::string> words = {program("openflc"), "run", path("layers.fl")};
        words.insert(words.end(), schedule.begin(), schedule.end());
        words.insert(words.end(), {path("w.fab.json"), "--voxel", "0.1mm", "-o", path(output)});
        RunOptions options;
        options.environment.emplace_back("XDG_CACHE_HOME", path("cache"));
        const Outcome outcome = run(words, options);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read_file(folder_ / output);
    };
    EXPECT_EQ(print("plain.ofr", {}), print("tuned.ofr", {"--schedule", path("t.sched")}));

    // It goes on: what is known is not tried again. Ctrl-C ends it, and leaves a schedule.
    fs::remove(folder_ / "t.sched");
    RunOptions interrupted;
    interrupted.interrupt_when = [](int, const Outcome& so_far) {
        return testing::says(so_far.err, tuner::messages::kOfFirstsTime);
    };
    const Outcome second = tune("5m", interrupted);
    EXPECT_EQ(second.exit_code, 130) << second.err;
    EXPECT_THAT(second.err, testing::Says(tuner::messages::kSchedulesKnown));
    EXPECT_THAT(second.err, testing::Says(tuner::messages::kInterruptedBest));
    EXPECT_THAT(read_file(folder_ / "t.sched"), HasSubstr("\npipeline slab\n"));
    EXPECT_THAT(read_file(folder_ / "t.sched.journal"), StartsWith(journal));

    // Nor is a journal of another print read.
    const Outcome other = openfab(
        {"tune", path("w.fab.json"), "--voxel", "0.2mm", "-o", path("t.sched"), "--budget", "5s"});
    EXPECT_EQ(other.exit_code, 1);
    EXPECT_THAT(other.err, testing::Says(tuner::messages::kNoJournalOfThisHelp));
}

TEST_F(TunerTest, RefusesWhatItCannotDo) {
    folder_.write("part.obj", "v 0 0 0\n");
    folder_.write("bad.sched", "pipeline slab\nslab.vectorise(z)\n");
    folder_.write("base.sched", "include \"slab.sched\"\n");
    folder_.write("more.sched", "pipeline slab\ninclude \"base.sched\"\n");
    fs::create_directories(folder_ / "f");
    folder_.write("f/slab.sched", "pipeline slab\n");
    const std::string world = path("w.fab.json");
    struct Case {
        std::vector<std::string> words;
        int exit_code;
        std::string message;
    };
    const std::vector<Case> cases = {
        {{"profile"}, 2, "INPUT"},
        {{"profile", path("no.fab.json")}, 1, "no.fab.json"},
        {{"profile", path("part.obj")}, 2, tuner::messages::kNotAWorld},
        {{"profile", world, "-o", path("x.ofr")},
         2,
         fmt::format(tuner::messages::kKeepsNoSlices, "{}", "-o")},
        {{"profile", world, "--time", "10"},
         2,
         "`--time`: " + fmt::format(messages::kNoUnit, "10", "{}")},
        {{"profile", world, "--time", "1ms"}, 2, tuner::messages::kWriteATime},
        {{"profile", world, "--schedule", path("bad.sched")}, 1, "vectorize"},
        {{"profile", world, "--param", "colums=3"}, 2, "no schedule in use has a parameter"},
        {{"profile", world, "--nonsense"}, 2, "--nonsense"},
        {{"profile", world, "--probe", "0,0,0"},
         2,
         fmt::format(tuner::messages::kKeepsNoSlices, "{}", "--probe")},
        {{"profile", world, "--json", path("none/p.json")}, 3, "none/p.json`: No such file"},
        {{"profile", world, "--json", path("layers.fl")}, 1, "would overwrite"},
        {{"profile", world, "--json", world}, 1, "would overwrite"},
        {{"profile", world, "--isa", "foo"}, 2, "`--isa`"},
        {{"profile", world, "--draft", "2", "--time"}, 2, "--time"},
        {{"tune", world, "--draft", "3"}, 2, tuner::messages::kNoOutput},
        {{"tune", world, "-o", path("t.txt")}, 2, tuner::messages::kNameEnds},
        {{"tune", world, "-o", path("t.sched"), "--budget", "soon"}, 2, "`--budget`"},
        {{"tune", world, "-o", path("t.sched"), "--resume"},
         2,
         fmt::format(tuner::messages::kKeepsNoSlices, "{}", "--resume")},
        {{"tune", world, "-o", path("base.sched"), "--schedule", path("more.sched")},
         1,
         "would overwrite"},
        {{"tune", world, "-o", path("f/slab.sched"), "--schedule", path("f")},
         1,
         "would overwrite"},
        {{"tune", world, "-o", path("t.sched"), "--journal", path("t.sched")}, 1, "are one file"},
    };
    for (const Case& c : cases) {
        const Outcome outcome = openfab(c.words);
        EXPECT_EQ(outcome.exit_code, c.exit_code)
            << ::testing::PrintToString(c.words) << outcome.err;
        EXPECT_THAT(outcome.err, testing::Says(c.message)) << ::testing::PrintToString(c.words);
    }
    EXPECT_EQ(read_file(folder_ / "layers.fl"), kFablet);
    EXPECT_EQ(read_file(folder_ / "base.sched"), "include \"slab.sched\"\n");
}

TEST_F(TunerTest, SaysThatNoKernelIsKept) {
    fs::create_directories(folder_ / "cache/openfab/kernels");
    fs::permissions(folder_ / "cache/openfab/kernels", fs::perms(0555));
    RunOptions options;
    options.obeys_permissions = true;
    const Outcome outcome =
        openfab({"profile", path("w.fab.json"), "--json", path("layers.fl")}, options);
    EXPECT_THAT(outcome.err,
                ::testing::HasSubstr("note: " + fmt::format(tuner::messages::kKernelNotKept, "")));
    EXPECT_THAT(outcome.err, testing::Says(messages::kCannotBeWrittenTo, "Permission denied"));
}

TEST_F(TunerTest, HelpNamesThePrintsOptions) {
    for (const std::string command : {"profile", "tune"}) {
        const Outcome outcome = openfab({command, "--help"});
        EXPECT_EQ(outcome.exit_code, 0);
        EXPECT_THAT(outcome.out, HasSubstr("--schedule"));
        EXPECT_THAT(outcome.out, HasSubstr("--voxel"));
        EXPECT_THAT(outcome.out, HasSubstr("Examples:\n  openfab " + command));
        EXPECT_THAT(outcome.out, Not(HasSubstr(" -o card.ofr --draft")));
    }
    EXPECT_THAT(openfab({"--help"}).out, HasSubstr("tune"));
}

}  // namespace
}  // namespace openfab::testing
