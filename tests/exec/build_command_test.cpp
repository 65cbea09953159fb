// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openflc build`, `check` and `emit` from outside: carets in schedules, exit codes, what a print program
// needs at run time.

#include <HalideRuntime.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {

namespace {

const std::string kPostcard = source_dir() / "gallery/magic_postcard/magic_postcard.fl";

Outcome openflc(std::vector<std::string> args) {
    args.insert(args.begin(), program("openflc"));
    return run(args);
}

/// Builds the postcard for one target with a schedule; returns stderr without the folder.
std::string errors_of(const std::string& name, const std::string& schedule, int exit_code) {
    const ScratchFolder folder;
    folder.write(name, schedule);
    const Outcome out = openflc({"build", kPostcard, "-o", folder / "print", "--target", "avx2",
                                 "--schedule", folder / name});
    EXPECT_EQ(out.exit_code, exit_code) << out.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "print"));
    std::string text = out.err;
    const std::string prefix = folder.path().string() + "/";
    for (size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) {
        text.erase(at, prefix.size());
    }
    return text;
}

TEST(BuildCommand, WithoutAFolderForTemporaryFilesNoBugIsReported) {
    RunOptions options;
    options.environment = {{"TMPDIR", "/nowhere/at/all"}};
    const Outcome out =
        run({program("openflc"), "emit", "--stage", "slab", "--as", "llvm", kPostcard}, options);
    EXPECT_EQ(out.exit_code, 3) << out.err;
    EXPECT_THAT(out.err, Says(messages::kNoTemporaryFolder)) << out.err;
    EXPECT_EQ(out.err.find("internal error"), std::string::npos) << out.err;
}

/// A program takes the place of its output: a pipe would be one no more.
TEST(BuildCommand, APipeIsNoPlaceForAProgram) {
    const ScratchFolder folder;
    const std::string pipe = folder / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const Outcome out = openflc({"build", kPostcard, "-o", pipe});
    EXPECT_EQ(out.exit_code, 1) << out.err;
    EXPECT_THAT(out.err, Says(messages::kOutputIsNoFile, "*", messages::kKindPipe)) << out.err;
    EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(BuildCommand, WhatTheMachineRefusesIsNoBugAndHasARemedy) {
    const ScratchFolder folder;
    int caches = 0;
    const auto build = [&](const std::string& before) {
        RunOptions options;
        // A new one each time: all kernels are compiled.
        options.environment.emplace_back("OPENFAB_CACHE",
                                         folder / ("cache" + std::to_string(++caches)));
        return run({"/bin/sh", "-c", before + "exec \"$0\" \"$@\"", program("openflc"), "build",
                    kPostcard, "-o", folder / "print", "--target", "sse41"},
                   options);
    };
    struct Case {
        const char* before;
        const char* remedy;
    };
    for (const Case& one :
         {Case{"PATH=; export PATH; ", "apt install gcc"},
#ifndef OPENFAB_SANITIZED
          Case{"ulimit -v 1000000; ", "memory"},
#endif
          Case{"ulimit -n 6; ", "open"},
          // Before the first byte of an object, within one, and in linking all.
          Case{"ulimit -f 0; ", "ulimit -f"}, Case{"ulimit -f 8; ", "ulimit -f"},
          Case{"ulimit -f 20; ", "ulimit -f"}, Case{"ulimit -f 400; ", "ulimit -f"}}) {
        const Outcome out = build(one.before);
        EXPECT_EQ(out.exit_code, 3) << out.err;
        EXPECT_NE(out.err.find(one.remedy), std::string::npos) << out.err;
        EXPECT_EQ(out.err.find("TMPDIR"), std::string::npos) << "does not help: " << out.err;
        EXPECT_EQ(out.err.find("internal error"), std::string::npos) << out.err;
    }
}

TEST(BuildCommand, MarksAMisspelledDirective) {
    EXPECT_EQ(errors_of("slab.sched", "# mine\nweights.vektorize(z)\n", 1),
              "slab.sched:2:9: error: no directive is called `vektorize` [schedule-illegal]\n"
              " 2 | weights.vektorize(z)\n"
              "   |         ^~~~~~~~~\n"
              "help: " +
                  fmt::format(messages::kDidYouMean, "vectorize") + "\n");
}

TEST(BuildCommand, MarksAFuncThatIsComputedWhereNothingReadsIt) {
    EXPECT_EQ(
        errors_of("slab.sched", "weights.vectorize(z)\nrequests_0.compute_at(weights, z)\n", 1),
        "slab.sched:2:12: error: `samples_0` reads `requests_0` too, outside the loop `z` of "
        "`weights` [schedule-illegal]\n"
        " 2 | requests_0.compute_at(weights, z)\n"
        "   |            ^~~~~~~~~~\n"
        "help: `compute_root()` is around all that reads it\n");
}

TEST(BuildCommand, FindsMistakesInFilesThatAScheduleIncludes) {
    const ScratchFolder folder;
    folder.write("strips.sched", "param strip = 2 in [1, 8]\nslab.split(column, o, i, stripe)\n");
    folder.write("slab.sched", "include \"strips.sched\"\n");
    const auto emit = [&](std::vector<std::string> more) {
        std::vector<std::string> args = {"emit", kPostcard, "--stage", "slab", "--as", "schedule"};
        args.insert(args.end(), more.begin(), more.end());
        return openflc(args);
    };
    Outcome out = emit({"--schedule", folder / "slab.sched"});
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_THAT(out.err,
                ::testing::HasSubstr(
                    "strips.sched:2:26: error: `stripe` is not a number, nor a parameter from a "
                    "line before [schedule-illegal]\n"
                    " 2 | slab.split(column, o, i, stripe)\n"
                    "   |                          ^~~~~~\n"
                    "help: " +
                    fmt::format(messages::kDidYouMean, "strip") + "\n"))
        << out.err;
    // A folder of schedules, and parameters.
    folder.write("strips.sched", "param strip = 2 in [1, 8]\nslab.split(column, o, i, strip)\n");
    out = emit({"--schedule", folder.path().string(), "--param", "strip=4"});
    EXPECT_EQ(out.exit_code, 0) << out.err;
    EXPECT_EQ(out.out,
              "# slab.sched, bound to avx2\npipeline slab\n# strip = 4 in [1, 8]\n"
              "slab.split(column, o, i, 4)\n");
    // What is printed is a file that gives the same again.
    folder.write("again.sched", out.out);
    const Outcome again = emit({"--schedule", folder / "again.sched"});
    EXPECT_NE(again.out.find("slab.split(column, o, i, 4)\n"), std::string::npos) << again.err;
    out = emit({"--schedule", folder / "slab.sched", "--param", "strip=9"});
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(out.err.find("`strip` is set to 9, which is not in [1, 8]"), std::string::npos);
    out = emit({"--schedule", folder / "slab.sched", "--param", "cols=9"});
    EXPECT_EQ(out.exit_code, 2);
    EXPECT_NE(out.err.find("no schedule in use has a parameter of that name"), std::string::npos);
    EXPECT_EQ(emit({"--param", "strip"}).exit_code, 2);
    out = emit({"--schedule", folder / "slab.sched", "--schedule", folder / "again.sched"});
    EXPECT_NE(out.err.find("are both for the pipeline `slab`"), std::string::npos) << out.err;
    // The built-in one has a parameter, too.
    out = emit({"--param", "columns=16"});
    EXPECT_NE(out.out.find("slab.split(column, batch, member, 16)"), std::string::npos) << out.err;
    out = emit({"--param", "columns=17"});
    EXPECT_NE(out.err.find("`columns` is set to 17, which is not in {4, 8, 16, 32, 64}"),
              std::string::npos)
        << out.err;
}

// Halide 14 cannot lower this schedule; 19 can.
TEST(BuildCommand, WhatHalideCannotLowerIsToldInOurWords) {
    const ScratchFolder folder;
    folder.write("slab.sched",
                 "weights.unroll(z, 3)\n"
                 "footprint_1.compute_at(weights, z_unroll)\n"
                 "values_early_0.compute_root()\n");
    const Outcome out =
        openflc({"emit", source_dir() / "gallery/ink_profile/ink_profile.fl", "--stage", "slab",
                 "--as", "loops", "--schedule", folder / "slab.sched"});
#if HALIDE_VERSION_MAJOR >= 19
    EXPECT_EQ(out.exit_code, 0) << out.err;
#else
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(out.err.find("slab.sched:2:13: error: `footprint_1` would be stored here on a "
                           "condition that reads a func of several values, as it is one"),
              std::string::npos)
        << out.err;
#endif
}

// What a user adds to the built-in schedule, in a folder and on top of what was written before.
TEST(BuildCommand, BuildsUponOtherSchedules) {
    const ScratchFolder folder;
    const auto emit = [&](const std::string& schedule) {
        return openflc(
            {"emit", kPostcard, "--stage", "slab", "--as", "schedule", "--schedule", schedule});
    };
    const std::string mine = "include \"slab.sched\"\nweights.unroll(column, 2)\n";
    folder.write("slab.sched", mine);
    for (const std::filesystem::path& named : {folder.path(), folder.path() / "slab.sched"}) {
        const Outcome out = emit(named.string());
        EXPECT_EQ(out.exit_code, 0) << out.err;
        EXPECT_NE(out.out.find("slab.split(column, batch, member, 64)"), std::string::npos);
        EXPECT_NE(out.out.find("weights.unroll(column, 2)"), std::string::npos);
    }
    // In a folder the rest of a name is the user's, too; two files for one pipeline are not ignored.
    folder.write("slab.mine.sched", mine);
    Outcome out = emit(folder.path().string());
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(out.err.find("are both for the pipeline `slab`"), std::string::npos) << out.err;
    std::filesystem::remove(folder.path() / "slab.sched");
    out = emit(folder.path().string());
    EXPECT_EQ(out.exit_code, 0) << out.err;
    EXPECT_NE(out.out.find("weights.unroll(column, 2)"), std::string::npos);
    // What is printed is for one pipeline.
    folder.write("printed.sched", out.out);
    folder.write("slab.mine.sched", "include \"printed.sched\"\nslab.parallel(batch)\n");
    out = emit(folder / "slab.mine.sched");
    EXPECT_EQ(out.exit_code, 0) << out.err;
    EXPECT_NE(out.out.find("weights.unroll(column, 2)"), std::string::npos);
    folder.write("surface.sched", "include \"printed.sched\"\n");
    out = emit(folder / "surface.sched");
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(
        out.err.find("printed.sched:2:10: error: this file is for the pipeline `slab`, and is "
                     "included in one for `surface`"),
        std::string::npos)
        << out.err;
}

// Statements of code that is written out are nested by the ten thousand.
TEST(BuildCommand, RefusesWhatUnrollsTooMuch) {
    const ScratchFolder folder;
    for (const char* copies : {"32", "64"}) {
        folder.write("mine.sched", std::string("pipeline slab\ninclude \"slab.sched\"\n") +
                                       "weights.unroll(column, " + copies + ")\n");
        const Outcome out =
            openflc({"emit", source_dir() / "gallery/library/color_spaces.fl", "--stage", "slab",
                     "--as", "loops", "--schedule", folder / "mine.sched"});
        EXPECT_EQ(out.exit_code, 1);
        EXPECT_NE(out.err.find(" operations, most of them for `weights`; the limit is 400000"),
                  std::string::npos)
            << out.err;
    }
}

/// The first fenced block of schedules/README.md that is a schedule.
std::string worked_example() {
    std::ifstream file(source_dir() / "schedules/README.md");
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    const std::string fence = "```sched\n";
    const size_t begin = text.find(fence) + fence.size();
    return text.substr(begin, text.find("```", begin) - begin);
}

TEST(BuildCommand, TheWorkedExampleOfTheReferenceWorks) {
    const ScratchFolder folder;
    folder.write("mine.sched", worked_example());
    const auto emit = [&](const char* form, const char* target) {
        return openflc({"emit", kPostcard, "--stage", "slab", "--as", form, "--schedule",
                        folder / "mine.sched", "--param", "strip=8", "--target", target});
    };
    const Outcome schedule = emit("schedule", "avx2");
    EXPECT_EQ(schedule.exit_code, 0) << schedule.err;
    EXPECT_NE(schedule.out.find("weights.split(column, strips, column, 8)\n"), std::string::npos);
    EXPECT_NE(schedule.out.find("slab.parallel(batch)\n"), std::string::npos);
    EXPECT_EQ(emit("schedule", "sse41").out.find("parallel"), std::string::npos);
    const Outcome loops = emit("loops", "avx2");
    EXPECT_EQ(loops.exit_code, 0) << loops.err;
    for (const char* line :
         {"slab:\n", "parallel batch:\n", "for strips:\n", "for column in 8:\n",
          "store samples_0: ", "samples_0: computed by the runtime\n", "vectorized z in 8:\n"})
        EXPECT_NE(loops.out.find(line), std::string::npos) << line << loops.out;
}

// 4096 floats of each of 3 channels in each of 1024 columns, and as many of their sum: 48 and 16 MiB.
TEST(BuildCommand, RefusesAScheduleThatStoresMoreThanAPlanAllows) {
    const ScratchFolder folder;
    folder.write("mine.sched",
                 "pipeline slab\nsums.compute_root().align_storage(z, 4096)\n"
                 "total.compute_root().align_storage(z, 4096)\n");
    const Outcome out = openflc({"emit", kPostcard, "--stage", "slab", "--as", "loops",
                                 "--schedule", folder / "mine.sched"});
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(out.err.find("mine.sched:2:6: error: this schedule stores up to "), std::string::npos)
        << out.err;
    EXPECT_NE(out.err.find(" MiB for a thread, `sums` the most of it; the limit is 64.0 MiB"),
              std::string::npos)
        << out.err;
}

TEST(BuildCommand, SaysThatSamplesHaveNoLoops) {
    EXPECT_EQ(errors_of("slab.sched", "samples_0.compute_root().vectorize(z)\n", 1),
              "slab.sched:1:26: error: `samples_0` is computed by the runtime: it has no loops of "
              "its own [schedule-illegal]\n"
              " 1 | samples_0.compute_root().vectorize(z)\n"
              "   |                          ^~~~~~~~~\n"
              "help: it can be placed: compute_at, compute_root, store_at, store_root\n");
}

TEST(BuildCommand, WantsToKnowTheKernelOfASchedule) {
    const std::string text = errors_of("fast.sched", "weights.vectorize(z)\n", 1);
    EXPECT_NE(text.find("no pipeline is called `fast`"), std::string::npos) << text;
}

TEST(BuildCommand, ReportsWhatIsMissing) {
    const ScratchFolder folder;
    EXPECT_EQ(openflc({"build", folder / "none.fl", "-o", folder / "p"}).exit_code, 3);
    EXPECT_EQ(openflc({"build", kPostcard}).exit_code, 2);
    EXPECT_EQ(openflc({"build", kPostcard, "-o", folder / "p", "--target", "arm"}).exit_code, 2);
    const Outcome out =
        openflc({"build", kPostcard, "-o", folder / "no/such/folder", "--target", "sse41"});
    EXPECT_EQ(out.exit_code, 3) << out.err;
}

TEST(BuildCommand, MakesAProgramThatRuns) {
    const ScratchFolder folder;
    const std::string program = folder / "print";
    const Outcome out = openflc({"build", kPostcard, "-o", program, "--target", "sse41"});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    EXPECT_EQ(out.err, "");
    EXPECT_EQ(run({program, "--help"}).exit_code, 0);
    const Outcome needs = run({"/usr/bin/ldd", program});
    for (const char* unwanted : {"Halide", "LLVM", "OpenImageIO", "not found"}) {
        EXPECT_EQ(needs.out.find(unwanted), std::string::npos) << needs.out;
    }
}

size_t count(const std::filesystem::path& folder) {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                             std::filesystem::directory_iterator()));
}

TEST(BuildCommand, LeavesNothingBehindWhenItIsEnded) {
    for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
        SCOPED_TRACE(signal);
        const ScratchFolder folder;
        const std::filesystem::path temporary = folder / "temporary";
        std::filesystem::create_directory(temporary);
        RunOptions options;
        options.environment = {{"TMPDIR", temporary.string()}};
        options.signal = signal;
        // While its folder already contains kernels.
        options.interrupt_when = [&](int, const Outcome&) {
            for (const auto& entry : std::filesystem::directory_iterator(temporary)) {
                std::error_code gone;
                if (!std::filesystem::is_empty(entry.path(), gone) && !gone) return true;
            }
            return false;
        };
        const Outcome out =
            run({program("openflc"), "build", kPostcard, "-o", folder / "print"}, options);
        EXPECT_EQ(out.exit_code, signal == SIGKILL ? 128 + SIGKILL : 130) << out.err;
        EXPECT_EQ(count(temporary), signal == SIGKILL ? 1u : 0u);
        EXPECT_EQ(count(folder.path()), 1u);
        if (signal != SIGKILL) continue;
        // The next one that creates a temporary folder there.
        options.interrupt_when = nullptr;
        EXPECT_EQ(
            run({program("openflc"), "emit", kPostcard, "--stage", "volume_bounds", "--as", "asm"},
                options)
                .exit_code,
            0);
        EXPECT_EQ(count(temporary), 0u);
    }
}

/// A program of so many lines, none of which is merged with another.
std::string long_program(int lines, const std::string& value) {
    std::string text =
        "fablet T {\n@uniform { Material m; ImageTexture2D t; }\n"
        "@Volume(@varying { VolumeAttributes attr }) {\nfloat x = attr.voxelCenter.x;\n";
    for (int i = 0; i < lines; ++i)
        text += "x = x * x + " + std::to_string(i) + ";\n";
    return text + "MaterialComposition mc; mc.Set(m, " + value + "); return mc; } }\n";
}

TEST(CheckCommand, RefusesWhatIsTooLongToBeCompiledWhereItGetsSo) {
    const ScratchFolder folder;
    folder.write("long.fl", long_program(13000, "x"));
    const Outcome own = openflc({"check", folder / "long.fl"});
    EXPECT_EQ(own.exit_code, 1);
    EXPECT_NE(own.err.find("long.fl:1200"), std::string::npos) << own.err;
    EXPECT_NE(own.err.find("the `@Volume` stage of `T` has 260"), std::string::npos) << own.err;
    EXPECT_NE(own.err.find("the limit is 24000"), std::string::npos) << own.err;
    EXPECT_NE(own.err.find("short loops unrolled"), std::string::npos) << own.err;
    // Its own text is short.
    folder.write("lookup.fl", long_program(8000, "t.Sample1(x, 0, 0)"));
    const Outcome lookup = openflc({"check", folder / "lookup.fl"});
    EXPECT_EQ(lookup.exit_code, 1);
    EXPECT_NE(lookup.err.find("pass a width to the lookup"), std::string::npos) << lookup.err;
    folder.write("short.fl", long_program(8000, "x"));
    EXPECT_EQ(openflc({"check", folder / "short.fl"}).exit_code, 0);
}

TEST(CheckCommand, NamesWhereFractionsJumpWhereItIsAsked) {
    const ScratchFolder folder;
    folder.write(
        "jump.fl",
        "fablet Jump {\n    @uniform { float u = 1; Material m; }\n"
        "    @Volume(@varying { VolumeAttributes attr })\n    {\n        MaterialComposition mc;\n"
        "        if (attr.voxelCenter.x < u) mc.Set(m, 1);\n        return mc;\n    }\n}\n");
    EXPECT_EQ(openflc({"check", folder / "jump.fl"}).err, "");
    const Outcome asked = openflc({"check", "--derivatives", folder / "jump.fl"});
    EXPECT_EQ(asked.exit_code, 0);
    EXPECT_NE(asked.err.find("jump.fl:6:13: warning:"), std::string::npos) << asked.err;
    EXPECT_NE(asked.err.find("[jump]"), std::string::npos) << asked.err;
    EXPECT_NE(asked.err.find("smoothstep"), std::string::npos) << asked.err;
}

TEST(EmitCommand, PrintsEveryForm) {
    for (const char* form : {"ir", "halide", "schedule", "loops", "stmt", "llvm", "asm"}) {
        const Outcome out = openflc({"emit", kPostcard, "--stage", "volume_bounds", "--as", form});
        EXPECT_EQ(out.exit_code, 0) << out.err;
        EXPECT_GT(out.out.size(), 100u) << form;
    }
}

TEST(EmitCommand, ShowsTheLastSegmentInTheSlabKernel) {
    const std::string queries = source_dir() / "tests/property/pipeline/queries.fl";
    const auto emit = [&](const char* form) {
        return openflc({"emit", queries, "--fablet", "Walk", "--stage", "slab", "--as", form});
    };
    const Outcome funcs = emit("halide");
    EXPECT_EQ(funcs.exit_code, 0) << funcs.err;
    for (const char* part : {"  argument state_", "  func slab(z, column)\n",
                             "  func weights(z, column)\n", "  func remainder(z, column)\n"})
        EXPECT_NE(funcs.out.find(part), std::string::npos) << part << funcs.out;
    EXPECT_EQ(funcs.out.find("argument weight_"), std::string::npos) << funcs.out;
    const Outcome loops = emit("loops");
    EXPECT_EQ(loops.exit_code, 0) << loops.err;
    EXPECT_NE(loops.out.find("a call stores "), std::string::npos) << loops.out;
    // The stage before it was cut.
    const Outcome whole = emit("ir");
    EXPECT_NE(whole.out.find(" query "), std::string::npos) << whole.out;
}

}  // namespace

}  // namespace openfab::testing
