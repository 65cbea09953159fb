// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Errors before anything is opened for writing: outputs on inputs, unknown formats, slices beyond
// the budget. And warnings: parts that vanish.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>

#include "backends/ofr/ofr_sink.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class Refusals : public ::testing::Test {
  protected:
    Refusals() {
        scratch_.write("f.fl", "fablet Solid {}\n");
        scratch_.write("block.obj",
                       "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                       "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
        scratch_.write(
            "my.printer.json",
            R"({"name": "my", "pitch_mm": [0.1, 0.1, 0.1], "build_volume_mm": [90, 90, 90], "native_format": "png"})");
        write_world("w.fab.json", R"({"file": "block.obj", "unit": "mm"})");
    }
    void write_world(const std::string& name, const std::string& mesh) {
        scratch_.write(name, SimpleWorld{"Solid", mesh, "my.printer.json"}.text());
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments, const std::string& world = "w.fab.json") {
        arguments.insert(arguments.begin(), {test_program("openfab_test_print_4"), path(world)});
        return run(arguments);
    }
    static Outcome openfab(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments);
    }

    ScratchFolder scratch_;
};

TEST_F(Refusals, APrintSparesAllThatItIsMadeFrom) {
    fs::create_symlink("block.obj", path("link.ofr"));
    fs::create_directory(path("sub"));
    const auto before = [&] {
        std::string all;
        for (const char* name : {"w.fab.json", "block.obj", "f.fl", "my.printer.json"})
            all += read_file(path(name)) + '\0';
        return all;
    };
    const std::string inputs = before();
    for (const std::string& file :
         {path("w.fab.json"), path("block.obj"), path("f.fl"), path("my.printer.json"),
          path("link.ofr"), path("sub/../block.obj"), path("./w.fab.json")}) {
        for (const std::vector<std::string>& options :
             {std::vector<std::string>{"-o", file, "--format", "ofr"},
              {"-o", path("a.ofr"), "--stats", file},
              {"-o", path("a.ofr"), "--stats", file, "--estimate"}}) {
            const Outcome outcome = print(options);
            EXPECT_EQ(outcome.exit_code, 1) << file << ": " << outcome.err;
            EXPECT_THAT(outcome.err, Says(program::messages::kWouldOverwrite)) << file;
            EXPECT_FALSE(fs::exists(path("a.ofr"))) << file;
        }
    }
    // The printer's file from the command line, and a mesh without a world.
    write_world("plain.fab.json", R"({"box": [4, 3, 2]})");
    EXPECT_EQ(print({"--printer", path("my.printer.json"), "--stats", path("my.printer.json"), "-o",
                     path("a.ofr")},
                    "plain.fab.json")
                  .exit_code,
              1);
    EXPECT_EQ(run({test_program("openfab_test_print_1"), path("block.obj"), "-o", path("block.obj"),
                   "--format", "ofr"})
                  .exit_code,
              1);
    EXPECT_TRUE(before() == inputs);
    EXPECT_EQ(print({"-o", path("a.ofr"), "--stats", path("a.ofr")}).exit_code, 1);
    EXPECT_FALSE(fs::exists(path("a.ofr")));
    EXPECT_EQ(print({"-o", path("a.ofr"), "--stats", path("a.json")}).exit_code, 0);
}

TEST_F(Refusals, ExportSparesWhatItReads) {
    ASSERT_EQ(print({"-o", path("e.ofr")}).exit_code, 0);
    const std::string whole = read_file(path("e.ofr"));
    fs::create_hard_link(path("e.ofr"), path("hard.ofr"));
    fs::create_hard_link(path("e.ofr"), path("hard.png"));
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{"-o", path("e.ofr")},
          {"-o", path("hard.ofr")},
          {"-o", path("e.ofr"), "--format", "3mf"},
          {"-o", path("hard.png"), "--slice", "1"},
          {"-o", path("slices"), "--preview", path("p.png"), "--preview", path("p.png")}}) {
        std::vector<std::string> arguments{"export", path("e.ofr")};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = openfab(arguments);
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_TRUE(read_file(path("e.ofr")) == whole) << options[1];
        EXPECT_FALSE(fs::exists(path("slices")));
    }
    const Outcome piped = run({"/bin/bash", "-c",
                               fmt::format("{} export - -o {} < {}", program("openfab").string(),
                                           path("e.ofr"), path("e.ofr"))});
    EXPECT_EQ(piped.exit_code, 1) << piped.err;
    EXPECT_TRUE(read_file(path("e.ofr")) == whole);
    EXPECT_EQ(openfab({"export", path("e.ofr"), "-o", path("copy.ofr")}).exit_code, 0);
    EXPECT_TRUE(read_file(path("copy.ofr")) == whole);
}

TEST_F(Refusals, WhatAnOutputCannotHaveIsNotIgnored) {
    ASSERT_EQ(print({"-o", path("e.ofr")}).exit_code, 0);
    // What is of worlds, with a print.
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"check", "--draft", "2"},
                                               {"check", "--parts", "1"},
                                               {"check", "--allow-programs"},
                                               {"check", "--set", "a.b=1"},
                                               {"render", "-o", path("r.png"), "--draft", "2"},
                                               {"render", "-o", path("r.png"), "--set", "a.b=1"}}) {
        std::vector<std::string> all = words;
        all.insert(all.begin() + 1, path("e.ofr"));
        const Outcome refused = openfab(all);
        EXPECT_EQ(refused.exit_code, 2) << words[1];
        EXPECT_THAT(refused.err, HasSubstr("is of worlds, and the voxels of `" + path("e.ofr")));
    }
    for (const char* output : {"f.ofr", "f.npy", "f.3mf"}) {
        const Outcome outcome = print({"-o", path(output), "--flip-x"});
        EXPECT_EQ(outcome.exit_code, 2) << output;
        EXPECT_THAT(outcome.err, Says(program::messages::kNotMirrored));
        EXPECT_FALSE(fs::exists(path(output)));
        const Outcome indexed = print({"-o", path(output), "--png", "indexed"});
        EXPECT_EQ(indexed.exit_code, 2) << output;
        EXPECT_THAT(indexed.err, Says(program::messages::kNoPalette));
        for (const char* option : {"--token-file", "--tls-ca"}) {
            const Outcome alone = print({"-o", path(output), option, path("e.ofr")});
            EXPECT_EQ(alone.exit_code, 2) << option;
            EXPECT_THAT(alone.err, Says(program::messages::kNoReceiver, option, path(output)));
        }
    }
    EXPECT_EQ(openfab({"export", path("e.ofr"), "-o", path("f.npy"), "--flip-x"}).exit_code, 2);
    EXPECT_EQ(openfab({"export", path("e.ofr"), "-o", path("s.ofr"), "--slice", "1"}).exit_code, 2);
    EXPECT_EQ(
        openfab({"export", path("e.ofr"), "-o", path("s.png"), "--slice", "1", "--format", "bmp"})
            .exit_code,
        2);
    EXPECT_FALSE(fs::exists(path("s.ofr")) || fs::exists(path("s.png")));
    const Outcome far = print({"--probe", "1e99,0,0"});
    EXPECT_EQ(far.exit_code, 1);
    EXPECT_THAT(far.err, testing::Says(pipeline::messages::kBeginsTooFar,
                                       pipeline::messages::kWindowBegins, "1e+99", "x"));
}

TEST_F(Refusals, ADeviceStaysADevice) {
    fs::create_symlink("/dev/full", path("full.png"));
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    const Outcome estimated =
        run({"/bin/bash", "-c",
             fmt::format("cat {0} > {1} & {2} {3} -o {4} --estimate --stats {0}; code=$?; wait; "
                         "exit $code",
                         path("pipe"), path("json"), test_program("openfab_test_print_4").string(),
                         path("w.fab.json"), path("a.ofr"))});
    EXPECT_EQ(estimated.exit_code, 0) << estimated.err;
    EXPECT_TRUE(fs::is_fifo(path("pipe")));
    EXPECT_THAT(read_file(path("json")), HasSubstr("\"estimate\": true"));
    const Outcome full = print({"--preview", path("full.png"), "-o", path("a.ofr")});
    EXPECT_EQ(full.exit_code, 3) << full.err;
    EXPECT_TRUE(fs::is_symlink(path("full.png")));
}

TEST_F(Refusals, AFileOfAnotherFormatIsNoFolder) {
    for (const std::string name : {"x.gcode", "x.zip", "x.PNG", "x.jpeg", "x.obj"}) {
        const Outcome outcome = print({"-o", path(name)});
        EXPECT_EQ(outcome.exit_code, 2) << name;
        EXPECT_THAT(outcome.err, HasSubstr(".3mf, .stl")) << name;
        EXPECT_FALSE(fs::exists(path(name))) << name;
    }
    // Explicit options are honoured.
    EXPECT_EQ(print({"-o", path("x.zip/")}).exit_code, 0);
    EXPECT_EQ(print({"-o", path("x.zip")}).exit_code, 0);  // now a folder
    EXPECT_EQ(print({"-o", path("y.tif"), "--format", "png"}).exit_code, 0);
    EXPECT_TRUE(fs::is_directory(path("y.tif")));
    EXPECT_EQ(print({"-o", path("ball_v1.2")}).exit_code, 0);
    EXPECT_TRUE(fs::is_directory(path("ball_v1.2")));
    ASSERT_EQ(print({"-o", path("e.ofr")}).exit_code, 0);
    EXPECT_EQ(openfab({"export", path("e.ofr"), "-o", path("x.gcode")}).exit_code, 2);
    EXPECT_FALSE(fs::exists(path("x.gcode")));
}

TEST_F(Refusals, SlicesBeyondTheBudgetAreRefusedBeforeTheyAreMade) {
    pipeline::PrintInfo info;
    info.size = {16384, 16384, 2};
    info.slice_end = 2;
    info.bits = 4;
    info.pitch_mm = {0.1, 0.1, 0.1};
    info.title = info.printer = "generic";
    info.materials.push_back({"white", {255, 255, 255, 255}, {255, 255, 255, 255}, 1, ""});
    // 134 MB of rows in 4 kB, 1.07 GB of pixels.
    Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create(path("large.ofr"));
    ASSERT_TRUE(sink);
    ASSERT_TRUE((*sink)->begin(info));
    const std::vector<uint8_t> rows(size_t{8192} * 16384);
    pipeline::PrintTotals totals;
    totals.complete = true;
    for (int32_t z = 0; z < 2; ++z)
        ASSERT_TRUE((*sink)->commit(z, (*sink)->encode({z, rows.data(), 8192, 16384, 16384})));
    totals.voxels_by_code.assign(2, 0);
    ASSERT_TRUE((*sink)->finish(totals));
    ASSERT_LT(fs::file_size(path("large.ofr")), 100'000u);

    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"export", path("large.ofr"), "-o", path("out")},
          {"export", path("large.ofr"), "-o", path("out.3mf")},
          {"export", path("large.ofr"), "-o", path("out.png"), "--slice", "0"}}) {
        std::vector<std::string> limited = arguments;
        limited.insert(limited.end(), {"--memory", "400MB"});
        const Outcome outcome = openfab(limited);
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("16384 x 16384 voxels"));
        EXPECT_THAT(outcome.err, HasSubstr("--memory"));
        EXPECT_FALSE(fs::exists(arguments[3]));
    }
    for (const char* command : {"verify", "info", "export"}) {
        const Outcome outcome = openfab({command, path("large.ofr"), "--memory", "100MB"});
        EXPECT_NE(outcome.exit_code, 0) << command;
    }
    EXPECT_THAT(openfab({"verify", path("large.ofr"), "--memory", "100MB"}).err, HasSubstr("134"));
    const Outcome verified = openfab({"verify", path("large.ofr"), "--memory", "200MB"});
    EXPECT_THAT(verified.err, HasSubstr("hash")) << verified.err;
}

TEST_F(Refusals, AnIndexOfNoLengthThatIsPossibleIsNotRead) {
    ASSERT_EQ(print({"-o", path("e.ofr")}).exit_code, 0);
    // A file that claims an index of 8 GB, mostly a hole.
    std::string tail = read_file(path("e.ofr"));
    tail = tail.substr(tail.size() - 16);
    std::memset(tail.data(), 0, 8);
    fs::copy_file(path("e.ofr"), path("hole.ofr"));
    fs::resize_file(path("hole.ofr"), uintmax_t{8} << 30);
    std::ofstream(path("hole.ofr"), std::ios::binary | std::ios::app) << tail;
    // In an address space too small for it; sanitizers need an unlimited one.
#ifdef OPENFAB_SANITIZED
    const char* limit = "true";
#else
    const char* limit = "ulimit -v 4000000";
#endif
    const Outcome outcome =
        run({"/bin/bash", "-c",
             fmt::format("{}; {} info {}", limit, program("openfab").string(), path("hole.ofr"))});
    EXPECT_LE(outcome.exit_code, 1) << outcome.err;
}

TEST_F(Refusals, PartsThatVanishAreNamed) {
    write_world("sheet.fab.json", R"({"box": [8, 8, 0.004]})");
    std::string world = read_file(path("sheet.fab.json"));
    const std::string build = R"([{"object": "thing"}])";
    world.replace(world.find(build), build.size(),
                  R"([{"object": "thing", "translate_mm": [0, 0, 0.01]},)"
                  R"( {"object": "thing", "translate_mm": [0, 0, 1.01]}])");
    scratch_.write("sheet.fab.json", world);
    const Outcome outcome =
        print({"-o", path("a.ofr"), "--stats", path("s.json")}, "sheet.fab.json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("warning: `thing` (number 1 of the build) is 80 x 80 x 0.04 "
                                       "voxels; anything thinner than a voxel"));
    EXPECT_THAT(outcome.err, HasSubstr("warning: nothing was printed: no voxel has any material; "
                                       "`thing` (number 0 of the build) is 80 x 80 x 0.04 voxels"));
    EXPECT_THAT(read_file(path("s.json")), Says(program::messages::kNothingPrinted));
    EXPECT_THAT(print({"-o", path("b.ofr")}).err, Not(HasSubstr("warning")));
}

}  // namespace
}  // namespace openfab::testing
