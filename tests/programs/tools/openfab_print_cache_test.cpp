// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The programs that `openfab print` keeps: made once, again if an input changed or the program is damaged, and nowhere
// that others can write to.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kPictured = R"(fablet Pictured {
    @uniform { Material body, ink; ImageTexture2D map; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float share = map.Sample1(attr.voxelCenter.x / 4, attr.voxelCenter.y / 3, 0);
        mc.Set(body, share);
        mc.Set(ink, 1 - share);
        return mc;
    }
}
)";
constexpr const char* kPicturedWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"pictured": {"source": "pictured.fl", "fablet": "Pictured"}},
  "materials": {"resin": {"key": "#ffffff"}, "black": {"key": "#000000"}},
  "textures": {"map": {"file": "map.pgm"}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "pictured",
                        "uniforms": {"body": "resin", "ink": "black", "map": "map"}}},
  "build": [{"object": "thing"}]
}
)";

TEST_F(OpenfabPrint, CompilesOnceAndAgainWhenTheSourceChanged) {
    const Outcome first = print({path("world.fab.json"), "-o", path("a.ofr")});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_THAT(first.err, testing::Says(tools::messages::kCompiling, "plain.fl"));
    const Outcome second = print({path("world.fab.json"), "-o", path("b.ofr")});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_THAT(second.err, Not(HasSubstr("compiling")));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    // The mesh alone, by the same fablet: the cache has the binary.
    const Outcome quick =
        print({path("block.obj"), "--fablet", path("plain.fl"), "-o", path("c.ofr")});
    EXPECT_EQ(quick.exit_code, 0) << quick.err;
    EXPECT_THAT(quick.err, Not(HasSubstr("compiling")));

    scratch_.write("plain.fl", std::string(kFablet) + "// changed\n");
    const Outcome changed = print({path("world.fab.json"), "-o", path("b.ofr")});
    ASSERT_EQ(changed.exit_code, 0) << changed.err;
    EXPECT_THAT(changed.err, testing::Says(tools::messages::kCompiling, "plain.fl"));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
}

TEST_F(OpenfabPrint, LeavesNoFolderBehindWhenItIsEndedWhileItCompiles) {
    const fs::path temporary = path("temporary");
    fs::create_directory(temporary);
    for (const int signal : {SIGINT, SIGTERM}) {
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}, {"TMPDIR", temporary.string()}};
        options.signal = signal;
        options.interrupt_when = [&](int, const Outcome&) { return !fs::is_empty(temporary); };
        const Outcome out = run(
            {program("openfab"), "print", path("world.fab.json"), "-o", path("a.ofr")}, options);
        EXPECT_EQ(out.exit_code, signal == SIGKILL ? 128 + SIGKILL : 130) << out.err;
        EXPECT_TRUE(fs::is_empty(path("cache") + "/prints"));
        EXPECT_TRUE(fs::is_empty(temporary)) << "the compiler was told, too";
    }
}

TEST_F(OpenfabPrint, ACacheThatCannotBeWrittenToIsReadAndKeepsNothing) {
    scratch_.write("pictured.fl", kPictured);
    scratch_.write("world.fab.json", kPicturedWorld);
    scratch_.write("map.pgm", "P2 2 2 255 10 200 90 30\n");
    fs::create_directories(path("cache/prints"));
    RunOptions options;
    options.environment = {{"OPENFAB_CACHE", path("cache")}};
    options.obeys_permissions = true;
    const auto print_with = [&](int mode, const std::string& output) {
        for (const std::string folder : {"cache/prints", "cache"})
            fs::permissions(path(folder), fs::perms(mode));
        return run({program("openfab"), "print", path("world.fab.json"), "--voxel", "0.2mm", "-o",
                    path(output)},
                   options);
    };
    const auto notes =
        AllOf(::testing::HasSubstr("note: " + fmt::format(tools::messages::kProgramNotCached, "")),
              HasSubstr("note: filtered textures are not cached: "),
              testing::Says(messages::kCannotBeWrittenTo, "Permission denied"));
    const Outcome unwritten = print_with(0555, "a.ofr");
    EXPECT_EQ(unwritten.exit_code, 0) << unwritten.err;
    EXPECT_THAT(unwritten.err, notes);
    EXPECT_TRUE(fs::is_empty(path("cache/prints")));
    EXPECT_EQ(std::distance(fs::directory_iterator(path("cache")), {}), 1);
    const Outcome written = print_with(0700, "b.ofr");
    EXPECT_EQ(written.exit_code, 0) << written.err;
    EXPECT_THAT(written.err, Not(HasSubstr("cached")));
    const Outcome read = print_with(0555, "c.ofr");
    EXPECT_EQ(read.exit_code, 0) << read.err;
    EXPECT_THAT(read.err, Not(AnyOf(HasSubstr("compiling"), HasSubstr("cached"))));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("c.ofr")));
    print_with(0700, "c.ofr");
}

/// What is kept is listed, bounded and purged; a converted picture is not kept where that is asked for.
TEST_F(OpenfabPrint, TheCacheIsListedAndPurged) {
    scratch_.write("pictured.fl", kPictured);
    scratch_.write("world.fab.json", kPicturedWorld);
    scratch_.write("map.pgm", "P2 2 2 255 10 200 90 30\n");
    const auto cache = [&](const std::vector<std::string>& more) {
        std::vector<std::string> argv{program("openfab"), "cache"};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    };
    const auto textures = [&] {
        return std::count_if(
            fs::directory_iterator(path("cache")), {},
            [](const fs::directory_entry& entry) { return entry.path().extension() == ".oftx"; });
    };
    const auto print_to = [&](const std::string& out, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{path("world.fab.json"), "--voxel", "0.2mm", "-o",
                                           path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome printed = print(arguments);
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        EXPECT_THAT(printed.err, Not(HasSubstr("cached")));
    };
    print_to("a.ofr", {"--no-cache"});
    EXPECT_EQ(textures(), 0);
    print_to("b.ofr", {});
    EXPECT_EQ(textures(), 1);
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    Outcome listed = cache({});
    EXPECT_EQ(listed.exit_code, 0);
    EXPECT_THAT(listed.out, AllOf(::testing::ContainsRegex("textures +1 file "),
                                  ::testing::ContainsRegex("prints +1 file ")));
    EXPECT_THAT(cache({"--files"}).out, HasSubstr(".oftx"));
    // What is not ours stays, and so does what fits.
    scratch_.write("cache/mine.oftx", "mine");
    EXPECT_THAT(cache({"--limit", "5GB"}).out, HasSubstr("removed 0 files"));
    EXPECT_EQ(textures(), 2);
    EXPECT_THAT(cache({"--purge", "textures"}).out, HasSubstr("removed 1 file"));
    EXPECT_EQ(textures(), 1);
    EXPECT_EQ(read_file(path("cache/mine.oftx")), "mine");
    EXPECT_THAT(cache({}).out, ::testing::ContainsRegex("prints +1 file "));
    // The program goes first, which is made older, and then all fits.
    print_to("c.ofr", {});
    const fs::path program_file = fs::directory_iterator(path("cache/prints"))->path();
    const std::string aged = "touch -a -m -d 2020-01-01 '" + program_file.string() + "'";
    ASSERT_EQ(std::system(aged.c_str()), 0);
    EXPECT_THAT(cache({"--limit", "6MB"}).out, HasSubstr("removed 1 file"));
    EXPECT_FALSE(fs::exists(program_file));
    EXPECT_EQ(textures(), 2);
    cache({"--purge", "all"});
    EXPECT_THAT(cache({}).out, ::testing::ContainsRegex("all +0 files "));
    EXPECT_EQ(cache({"--limit", "much"}).exit_code, 2);
    EXPECT_EQ(cache({"--purge", "mine"}).exit_code, 2);
}

TEST_F(OpenfabPrint, AModuleBesideAWorldWithoutAFolderCounts) {
    std::string fablet = kFablet;
    fablet.replace(fablet.find("mc.Set(body, 1)"), 15, "mc.Set(body, share())");
    scratch_.write("plain.fl", "import mine;\n" + fablet);
    const auto printed = [&](const std::string& share) {
        scratch_.write("mine.fl", "float share() { return " + share + "; }\n");
        const Outcome outcome = run({program("openfab"), "print", "world.fab.json", "-o", "a.ofr"},
                                    {{{"OPENFAB_CACHE", path("cache")}}, scratch_.path(), {}});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read_file(path("a.ofr"));
    };
    EXPECT_FALSE(printed("1") == printed("0")) << "the program of the old module was run";
}

TEST_F(OpenfabPrint, ADamagedProgramIsMadeAgain) {
    const auto print_it = [&] { return print({path("world.fab.json"), "-o", path("a.ofr")}); };
    ASSERT_EQ(print_it().exit_code, 0);
    ASSERT_EQ(std::distance(fs::directory_iterator(path("cache/prints")), {}), 1);
    const fs::path program = fs::directory_iterator(path("cache/prints"))->path();
    const std::string whole = read_file(program);
    std::string flipped = whole;
    flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
    for (const std::string& damaged : {flipped, whole.substr(0, whole.size() / 3), std::string()}) {
        std::ofstream(program, std::ios::binary) << damaged;
        const Outcome again = print_it();
        EXPECT_EQ(again.exit_code, 0) << again.err;
        EXPECT_THAT(again.err, HasSubstr("compiling"));
        EXPECT_EQ(read_file(program).size(), whole.size());
    }
    EXPECT_THAT(print_it().err, Not(HasSubstr("compiling")));
}

TEST_F(OpenfabPrint, NothingCommonIsTrustedWithoutAHome) {
    // A file that another user could have created.
    ASSERT_EQ(print({path("world.fab.json"), "-o", path("a.ofr")}).exit_code, 0);
    const std::string name =
        fs::directory_iterator(path("cache/prints"))->path().filename().string();
    const fs::path common = scratch_ / ("openfab-" + std::to_string(::getuid()));
    for (const fs::path& planted : {common / "prints" / name, scratch_ / "shared/prints" / name}) {
        fs::create_directories(planted.parent_path());
        std::ofstream(planted) << "#!/bin/sh\ntouch " + path("was-here") + "\n";
        fs::permissions(planted, fs::perms(0755));
    }
    fs::permissions(scratch_ / "shared", fs::perms(0777));
    using Environment = std::vector<std::pair<std::string, std::string>>;
    const std::string temporary = scratch_.path().string();
    for (const Environment& environment :
         {Environment{
              {"OPENFAB_CACHE", ""}, {"XDG_CACHE_HOME", ""}, {"HOME", ""}, {"TMPDIR", temporary}},
          Environment{{"OPENFAB_CACHE", path("shared")}, {"TMPDIR", temporary}}}) {
        for (const char* input : {"world.fab.json", "block.obj"}) {
            std::vector<std::string> words = {program("openfab"), "print", path(input), "-o",
                                              path("b.ofr")};
            if (std::string(input) == "block.obj") words.insert(words.end(), {"--fablet", "solid"});
            const Outcome outcome = run(words, {environment, {}, {}});
            EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
            EXPECT_THAT(outcome.err,
                        ::testing::HasSubstr("note: " +
                                             fmt::format(tools::messages::kProgramNotCached, "")));
        }
    }
    EXPECT_FALSE(fs::exists(path("was-here")));
    for (const auto& entry : fs::directory_iterator(scratch_.path()))
        EXPECT_EQ(entry.path().string().find(".tmp-"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace openfab::testing
