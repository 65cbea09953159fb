// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab print`: what a world and its fablets ask for, and what is refused.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "base/messages.h"
#include "program/messages.h"
#include "runtime/part/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

TEST_F(OpenfabPrint, SchedulesAreCompiledInAndAreInputsOfTheCache) {
    scratch_.write("tuned.sched", "pipeline slab\ninclude \"base.sched\"\n");
    scratch_.write("base.sched", "include \"slab.sched\"\nparam strip = 16 in {8, 16}\n");
    const auto tuned = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {path("world.fab.json"), "-o", path("b.ofr"), "--schedule",
                                   path("tuned.sched")});
        return print(more);
    };
    const auto compiles = [&](const std::vector<std::string>& more = {}) {
        const Outcome outcome = tuned(more);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
        return testing::says(outcome.err, fmt::format(tools::messages::kCompiling, "plain.fl"));
    };
    ASSERT_EQ(print({path("world.fab.json"), "-o", path("a.ofr")}).exit_code, 0);
    EXPECT_TRUE(compiles());
    EXPECT_FALSE(compiles());
    EXPECT_TRUE(compiles({"--param=strip=8"}));
    EXPECT_FALSE(compiles({"--param", "strip=8"}));

    const Outcome unknown = tuned({"--param", "strap=8"});
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("no schedule in use has a parameter of that name"));
    const Outcome over = print({path("world.fab.json"), "-o", path("base.sched"), "--format", "ofr",
                                "--schedule", path("tuned.sched")});
    EXPECT_EQ(over.exit_code, 1) << "an output in the place of an input";
    EXPECT_THAT(read_file(path("base.sched")), HasSubstr("strip"));
    const Outcome bare = print({path("world.fab.json"), "-o", path("b.ofr"), "--schedule"});
    EXPECT_EQ(bare.exit_code, 2);
    EXPECT_THAT(bare.err, testing::Says(tools::messages::kOptionNeeds, "--schedule",
                                        tools::messages::kAScheduleOrFolder));
    const Outcome missing =
        print({path("world.fab.json"), "-o", path("b.ofr"), "--schedule", path("none.sched")});
    EXPECT_NE(missing.exit_code, 0);
    EXPECT_THAT(missing.err, HasSubstr("none.sched"));

    scratch_.write("base.sched", "include \"slab.sched\"\nnowhere.unroll(column)\n");
    const Outcome wrong = tuned({});
    EXPECT_EQ(wrong.exit_code, 1) << "an included file changed";
    EXPECT_THAT(wrong.err, HasSubstr("base.sched:2:"));
}

TEST_F(OpenfabPrint, AWorldChoosesADitherRule) {
    const auto fablet = [](const std::string& rule) {
        return R"(fablet Mix {
    @uniform { Material body, other; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 0.4);
        mc.Set(other, 0.6);
        return mc;
    }
)" + rule + "}\n";
    };
    scratch_.write("rules.fl",
                   "int checks(DitherAttributes v) { return 1 + ((v.voxel.x + v.voxel.y) & 1); }\n"
                   "int stripes(DitherAttributes v) { return 1 + (v.voxel.x & 1); }\n");
    scratch_.write("plain.fl", fablet(""));
    scratch_.write("own.fl", "import rules;\n" +
                                 fablet("    @Dither(@varying { DitherAttributes attr }) { return "
                                        "checks(attr); }\n"));
    std::string world = kWorld;
    world.replace(world.find(R"("Plain")"), 7, R"("Mix")");
    world.insert(world.find(R"("resin": )"), R"("wax": {"key": "#000000"}, )");
    world.insert(world.find(R"("body": )"), R"("other": "wax", )");
    const auto with = [&](const std::string& source, const std::string& dither) {
        std::string text = world;
        text.replace(text.find("plain.fl"), 8, source);
        if (!dither.empty())
            text.insert(text.find("  \"materials\""),
                        R"("dither": {"source": "rules.fl", "rule": ")" + dither + "\"},\n");
        return text;
    };
    const auto codes = [&](const std::string& text, bool compiles) {
        scratch_.write("world.fab.json", text);
        const Outcome outcome = print({path("world.fab.json"), "-o", path("codes.npy")});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("compiling") != std::string::npos, compiles) << outcome.err;
        return read_file(path("codes.npy"));
    };
    const std::string own = codes(with("own.fl", ""), true);
    const std::string checks = codes(with("plain.fl", "checks"), true);
    EXPECT_TRUE(own == checks);
    EXPECT_TRUE(codes(with("plain.fl", "checks"), false) == checks);
    const std::string stripes = codes(with("plain.fl", "stripes"), true);
    EXPECT_FALSE(stripes == checks);
    EXPECT_TRUE(codes(with("own.fl", "stripes"), true) == own) << "a fablet's own rule stays";

    // In memory, from the same world.
    scratch_.write("world.fab.json", with("plain.fl", "stripes"));
    const Outcome in_memory = run({program("openflc"), "run", path("plain.fl"),
                                   path("world.fab.json"), "-o", path("run.npy")});
    ASSERT_EQ(in_memory.exit_code, 0) << in_memory.err;
    EXPECT_TRUE(read_file(path("run.npy")) == stripes);

    scratch_.write("world.fab.json", with("plain.fl", "dots"));
    const Outcome unknown = print({path("world.fab.json"), "-o", path("x.npy")});
    EXPECT_EQ(unknown.exit_code, 1);
    EXPECT_THAT(unknown.err,
                HasSubstr("the dither rules of module `rules` are `checks`, `stripes`"));
    scratch_.write("world.fab.json", with("plain.fl", "stripes"));
    const Outcome spared =
        print({path("world.fab.json"), "-o", path("rules.fl"), "--format", "npy"});
    EXPECT_EQ(spared.exit_code, 1) << "an output in the place of an input";

    // A program that was built without the rule.
    const Outcome built = run({program("openflc"), "build", path("plain.fl"), "-o", path("without"),
                               "--target", "sse41"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    const Outcome without = run({path("without"), path("world.fab.json"), "-o", path("x.npy")});
    EXPECT_EQ(without.exit_code, 1);
    EXPECT_THAT(without.err, testing::Says(part::messages::kWithoutDitherRule, "Mix", "stripes"));
}

TEST(Programs, ListTheirCommandsWithoutAWord) {
    for (const char* const name : {"openfab", "openflc", "openfab-color"}) {
        const Outcome out = run({program(name)});
        EXPECT_EQ(out.exit_code, 0) << name;
        EXPECT_THAT(out.out, HasSubstr("Subcommands:")) << name;
        EXPECT_EQ(out.err, "") << name;
    }
}

TEST(Programs, EachCommandHasAnExample) {
    for (const char* const name : {"openfab", "openflc", "openfab-color", "openfab-mechanics"}) {
        std::istringstream help(run({program(name), "--help"}).out);
        bool in = false;
        int commands = 0;
        for (std::string line; std::getline(help, line);) {
            if (!line.starts_with("  ")) in = line == "Subcommands:";
            if (!in || !line.starts_with("  ") || line[2] == ' ') continue;
            const std::string command = line.substr(2, line.find(' ', 2) - 2);
            EXPECT_THAT(run({program(name), command, "--help"}).out,
                        HasSubstr("Examples:\n  openf"))
                << name << ' ' << command;
            ++commands;
        }
        EXPECT_GT(commands, 5) << name;
    }
}

// Whichever comes first in the print program: the source tells them apart.
TEST_F(OpenfabPrint, FabletsOfOneNameAreThoseOfTheirSources) {
    scratch_.write("other.fl", R"(fablet Plain {
    @uniform { Material body, half; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter.x > 0 ? half : body, 1);
        return mc;
    }
}
)");
    const auto world = [](const std::string& first, const std::string& second) {
        return R"({"openfab": 1, "printer": "generic", "fablets": {)" + first + ", " + second +
               R"(}, "materials": {"resin": {"key": "#ffffff"}, "ink": {"key": "#000000"}},
                "meshes": {"block": {"box": [4, 3, 2]}},
                "objects": {"p": {"mesh": "block", "fablet": "a", "uniforms": {"body": "resin"}},
                            "q": {"mesh": "block", "fablet": "b",
                                  "uniforms": {"body": "ink", "half": "resin"}}},
                "build": [{"object": "p"}, {"object": "q", "translate_mm": [6, 0, 0]}]})";
    };
    const std::string plain = R"("a": {"source": "plain.fl", "fablet": "Plain"})",
                      other = R"("b": {"source": "other.fl", "fablet": "Plain"})";
    for (const std::string& text : {world(plain, other), world(other, plain)}) {
        scratch_.write("two.fab.json", text);
        const Outcome outcome =
            print({path("two.fab.json"), "-o", path("a.ofr"), "--voxel", "0.5mm"});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        // Half of the second block is ink: 12 of 48 mm³.
        EXPECT_THAT(outcome.err, HasSubstr("resin 0.04 ml, ink 0.01 ml"));
    }
    // The same file name in another folder tells nothing.
    fs::create_directory(path("more"));
    scratch_.write("more/plain.fl", read_file(path("other.fl")));
    scratch_.write("two.fab.json",
                   world(plain, R"("b": {"source": "more/plain.fl", "fablet": "Plain"})"));
    const Outcome refused = print({path("two.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("`Plain` is declared twice"));
    EXPECT_THAT(refused.err, HasSubstr("rename one of the two, or its file"));
}

TEST_F(OpenfabPrint, LimitsOfAUniformHold) {
    std::string limited = kFablet;
    limited.insert(limited.find("Material body"),
                   "float part = 1 [[ float min = 0.25, float max = 1 ]]; "
                   "int2 pair = int2(1, 2) [[ int min = -1 ]]; "
                   "float free = 0 [[ string help = \"min = 3\" ]]; ");
    limited.replace(limited.find("(body, 1)"), 9, "(body, part + free + pair.x)");
    scratch_.write("plain.fl", limited);
    const auto with = [&](const std::string& setting) {
        return print({path("world.fab.json"), "-o", path("a.ofr"), "--set", setting});
    };
    for (const char* fine :
         {"thing.part=0.25", "thing.part=1", "thing.pair=[-1, 5]", "thing.free=-9"}) {
        const Outcome outcome = with(fine);
        EXPECT_EQ(outcome.exit_code, 0) << fine << outcome.err;
    }
    const Outcome low = with("thing.part=0.2");
    EXPECT_EQ(low.exit_code, 1);
    EXPECT_THAT(low.err,
                HasSubstr(fmt::format(part::messages::kIsGivenNumber, "float part", "Plain", 0.2) +
                          "; " + fmt::format(part::messages::kLimit, "min", 0.25)));
    const Outcome high = with("thing.part=1.5");
    EXPECT_EQ(high.exit_code, 1);
    EXPECT_THAT(high.err, testing::Says(part::messages::kLimit, "max", 1));
    EXPECT_THAT(with("thing.pair=[0, -2]").err,
                testing::Says(part::messages::kIsGivenNumber, "int2 pair", "Plain", -2));
    // The world's own values are checked against them, too, with their locations.
    std::string world = kWorld;
    world.insert(world.find("\"body\": \"resin\""), "\"part\": -3, ");
    scratch_.write("world.fab.json", world);
    const Outcome of_world = print({path("world.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(of_world.exit_code, 1);
    EXPECT_THAT(of_world.err, HasSubstr("world.fab.json:7:"));
    EXPECT_THAT(of_world.err, testing::Says(part::messages::kLimit, "min", 0.25));
}

TEST_F(OpenfabPrint, SourcesAndTheirModulesAreSpared) {
    scratch_.write("helper.fl", "float half_of(float x) { return x / 2; }\n");
    for (const std::string name : {"plain.fl", "helper.fl"}) {
        const std::string before = read_file(path(name));
        for (const std::vector<std::string>& options :
             {std::vector<std::string>{path("world.fab.json"), "-o", path(name), "--format", "ofr"},
              {path("block.obj"), "--fablet", path("plain.fl"), "-o", path("a.ofr"), "--stats",
               path(name)}}) {
            const Outcome outcome = print(options);
            EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
            EXPECT_THAT(outcome.err, HasSubstr("would overwrite"));
            EXPECT_TRUE(read_file(path(name)) == before);
        }
    }
}

// A damaged picture has one message, ours.
TEST_F(OpenfabPrint, ImageLibrariesDoNotSpeakForThemselves) {
    const std::string png =
        std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x40\0\0\0\x40\x08\2\0\0\0", 29) +
        "nonsense that no checksum covers";
    scratch_.write("broken.png", png);
    const Outcome outcome =
        run({program("openfab"), "texture", path("broken.png"), "-o", path("broken.oftx")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("error: "));
    EXPECT_THAT(outcome.err, HasSubstr("broken.png"));
#ifndef OPENFAB_SANITIZED  // standard error stays open for the sanitizers' reports
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
#endif
    const Outcome onto =
        run({program("openfab"), "texture", path("broken.png"), "-o", path("broken.png")});
    EXPECT_EQ(onto.exit_code, 1);
    EXPECT_TRUE(read_file(path("broken.png")) == png);
}

TEST_F(OpenfabPrint, CompileErrorsPassThrough) {
    std::string wrong = kFablet;
    wrong.replace(wrong.find("mc.Set"), 6, "md.Set");
    scratch_.write("plain.fl", wrong);
    const Outcome outcome = print({path("world.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("plain.fl:5:9: error"));
    EXPECT_FALSE(fs::exists(path("a.ofr")));
    EXPECT_TRUE(fs::is_empty(path("cache/prints")));
}

TEST_F(OpenfabPrint, ACompilerThatCrashesIsABug) {
    // `openfab` takes the compiler beside it.
    fs::copy_file(program("openfab"), path("openfab"));
    const auto exit_code_with = [&](const std::string& signal) {
        scratch_.write("openflc", "#!/bin/sh\nkill -" + signal + " $$\n");
        fs::permissions(path("openflc"), fs::perms(0755));
        const Outcome outcome =
            run({path("openfab"), "print", path("world.fab.json"), "-o", path("a.ofr")},
                {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
        EXPECT_THAT(outcome.err, testing::Says(tools::messages::kEndedBySignal));
        return outcome.exit_code;
    };
    EXPECT_EQ(exit_code_with("SEGV"), 4);
    EXPECT_EQ(exit_code_with("KILL"), 3);
}

#ifndef OPENFAB_SANITIZED
// An address space in which the print program runs and the compiler's libraries have no room.
TEST_F(OpenfabPrint, ACompilerThatIsNotLoadedIsNoBug) {
    for (const int megabytes : {50, 100, 200}) {
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}};
        const Outcome outcome =
            run({"/bin/sh", "-c",
                 "ulimit -v " + std::to_string(megabytes << 10) + "; exec \"$0\" \"$@\"",
                 program("openfab"), "print", path("world.fab.json"), "-o", path("a.ofr")},
                options);
        EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
        EXPECT_THAT(outcome.err, testing::Says(tools::messages::kLibrariesNotLoaded));
        EXPECT_THAT(outcome.err, Not(HasSubstr("internal error")));
    }
}
#endif

TEST_F(OpenfabPrint, MistakesAreFoundBeforeAnythingIsCompiled) {
    EXPECT_EQ(print({}).exit_code, 2);
    EXPECT_EQ(print({path("world.fab.json"), "-o", path("a.ofr"), "--nonsense"}).exit_code, 2);
    EXPECT_EQ(print({path("block.obj"), "-o", path("a.ofr")}).exit_code, 2);
    EXPECT_EQ(print({path("gone.fab.json"), "-o", path("a.ofr")}).exit_code, 1);
    EXPECT_EQ(
        print({path("block.obj"), "--fablet", path("gone.fl"), "-o", path("a.ofr")}).exit_code, 1);
    const Outcome help = print({"--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("openfab print"));
    EXPECT_FALSE(fs::exists(path("cache")));
}

TEST(Programs, SayTheirVersion) {
    for (const std::string command : {program("openfab"), program("openflc")}) {
        const Outcome outcome = run({command, "--version"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::string name = fs::path(command).filename().string();
        EXPECT_THAT(outcome.out, ::testing::MatchesRegex(name + " [0-9]+\\.[0-9]+\\.[0-9]+\n"));
    }
}

TEST_F(OpenfabPrint, NamesOfAWorldAreNoOptions) {
    // An option of the compiler whose value is a program beside the world.
    fs::create_directory(scratch_ / "--linker=.");
    for (const char* name : {"--linker=./evil.fl", "evil.fl"}) {
        scratch_.write(name, "#!/bin/sh\ntouch " + path("was-here") + "\n");
        fs::permissions(scratch_ / name, fs::perms(0755));
    }
    std::string world = kWorld;
    const std::string one = "\"plain\": {";
    world.replace(world.find(one), one.size(),
                  R"("x": {"source": "--linker=./evil.fl", "fablet": "X"}, "plain": {)");
    scratch_.write("world.fab.json", world);
    for (const char* name : {"world.fab.json", "./world.fab.json"}) {
        const Outcome outcome = run({program("openfab"), "print", name, "-o", "a.ofr"},
                                    {{{"OPENFAB_CACHE", path("cache")}}, scratch_.path(), {}});
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("--linker=./evil.fl:1:1: error"));
    }
    EXPECT_FALSE(fs::exists(path("was-here")));
    // A valid fablet may have such a name.
    scratch_.write("-o.fl", kFablet);
    world = kWorld;
    world.replace(world.find("plain.fl"), 8, "-o.fl");
    scratch_.write("world.fab.json", world);
    const Outcome outcome = run({program("openfab"), "print", "world.fab.json", "-o", "a.ofr"},
                                {{{"OPENFAB_CACHE", path("cache")}}, scratch_.path(), {}});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(OpenfabPrint, NeighboursOfAFabletNeitherHoldUpNorLeadAway) {
    ASSERT_EQ(::mkfifo(path("wait.fl").c_str(), 0600), 0);
    fs::create_symlink("/dev/zero", path("zero.fl"));
    const Outcome outcome = print({path("world.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;

    fs::create_directory(scratch_ / "w");
    scratch_.write("secret.fl", "float share() { return 1; }\n");
    scratch_.write("w/world.fab.json", kWorld);
    scratch_.write("w/plain.fl", "import far;\n" + std::string(kFablet));
    fs::create_symlink("../secret.fl", path("w/far.fl"));
    const Outcome refused = print({path("w/world.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("`far` cannot be read"));
    EXPECT_THAT(refused.err, testing::Says(messages::kNotBelow));
    // A project may use all of its folders.
    scratch_.write("openfab.project", "");
    EXPECT_EQ(print({path("w/world.fab.json"), "-o", path("a.ofr")}).exit_code, 0);
}

TEST_F(OpenfabPrint, PlacesWithoutMaterialAreToldOfTheirObject) {
    // Of a block from x = -2 to 2 mm, in voxels of 0.1 mm, the share below `at`.
    scratch_.write("plain.fl", R"(fablet Plain {
    @uniform { Material body, hole; float at = -9, least = 0; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, attr.voxelCenter.x < at ? least : 1);
        mc.Set(hole, 0);
        return mc;
    }
})");
    const auto world = [&](const std::string& hole) {
        std::string text = kWorld;
        text.replace(text.find(R"("body": "resin")"), std::string(R"("body": "resin")").size(),
                     R"("body": "resin", "hole": ")" + hole + '"');
        scratch_.write("world.fab.json", text);
    };
    const auto said = [&](std::vector<std::string> words) {
        words.insert(words.begin(), path("world.fab.json"));
        words.insert(words.end(), {"--stats", path("s.json")});
        const Outcome done = print(words);
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return done.err + read_file(path("s.json"));
    };
    const auto says_nothing =
        Not(::testing::AnyOf(testing::Says(pipeline::messages::kPartsEmpty),
                             testing::Says(pipeline::messages::kPartsEmptyNegative)));
    world("resin");
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{"-o", path("a.ofr")},
          {"-o", path("a.ofr"), "--no-cull"},
          {"-o", path("a.ofr"), "--threads", "1", "--slices", "8:16"},
          {"--estimate"}}) {
        const auto half = [&](const char* least) {
            std::vector<std::string> words = more;
            words.insert(words.end(), {"--set", "thing.at=0", "--set", least});
            return said(words);
        };
        EXPECT_THAT(half("thing.least=0"),
                    testing::Says(pipeline::messages::kPartsEmpty, "50 % of `thing`"));
        EXPECT_THAT(half("thing.least=-1"),
                    testing::Says(pipeline::messages::kPartsEmptyNegative, "50 % of `thing`"));
    }
    const std::vector<std::string> to{"-o", path("a.ofr"), "--set"};
    const auto at = [&](const std::string& place) {
        std::vector<std::string> words = to;
        words.push_back("thing.at=" + place);
        return said(words);
    };
    EXPECT_THAT(at("-1.9"), testing::Says(pipeline::messages::kPartsEmpty, "2.5 % of `thing`"));
    EXPECT_THAT(at("-1.99"), says_nothing);
    // A print of nothing has its warning, which is enough.
    const std::string nothing = at("9");
    EXPECT_THAT(nothing.substr(0, nothing.find('{')), says_nothing);
    EXPECT_THAT(nothing, testing::Says(program::messages::kNothingPrinted));
    // Who binds void asks for it.
    world("VOID");
    EXPECT_THAT(at("0"), says_nothing);
}

}  // namespace
}  // namespace openfab::testing
