// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A signal ends whatever a fablet is doing, also what would never end, and what was printed before is
// whole. No test looks at the clock: a program that goes on runs into the limit of ten minutes, and is
// killed.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "backends/ofr/ofr_sink.h"
#include "program/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

/// Runs as many times as TRIPS says, each lane on its own, above z = 0.8 mm.
constexpr const char* kLoops = R"(fablet Loops {
    @uniform { Material body; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float x = attr.voxelCenter.x;
        int trips = attr.voxelCenter.z < 0.8 ? 1 : TRIPS;
        for (int j = 0; j < trips; j++)
            for (int i = 0; i < trips; i++)
                x = x * 0.5 + attr.voxelCenter.y;
        mc.Set(body, x < 1e30 ? 1 : 0);
        return mc;
    }
}
)";

/// Asks for the distance of places that the answers decide, forever above z = 0.8 mm.
constexpr const char* kWalks = R"(fablet Walks {
    @uniform { Material body; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        int trips = p.z < 0.8 ? 1 : 1000000;
        for (int j = 0; j < trips; j++)
            for (int i = 0; i < trips; i++)
                p += float3(0.01, 0.02, 0.01) * distance(p);
        mc.Set(body, p.x < 1e30 ? 1 : 0);
        return mc;
    }
}
)";

constexpr const char* kShape = R"(fablet Turns {
    @uniform { Material body; }
    @Shape(@varying { ShapeAttributes attr }) {
        float x = attr.p.x;
        int trips = attr.p.z < 0.8 ? 1 : 1000000;
        for (int j = 0; j < trips; j++)
            for (int i = 0; i < trips; i++)
                x = x * 0.5 + attr.p.y;
        return length(attr.p - float3(0, 0, 1)) - (x < 1e30 ? 0.9 : 0.8);
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 1);
        return mc;
    }
}
)";

constexpr const char* kSurface = R"(fablet Bumps {
    @uniform { Material body; }
    @Surface(@varying { SurfaceAttributes attr }) {
        float x = attr.p.x;
        int trips = attr.p.z < 0.8 ? 1 : 1000000;
        for (int j = 0; j < trips; j++)
            for (int i = 0; i < trips; i++)
                x = x * 0.5 + attr.p.y;
        return attr.n * (x < 1e30 ? 0.01 : 0.02);
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 1);
        return mc;
    }
}
)";

class Interrupts : public OpenfabPrint {
  protected:
    void write_world(const std::string& fablet, const std::string& name, const std::string& mesh,
                     int trips = 1'000'000) {
        std::string source = fablet;
        if (const size_t at = source.find("TRIPS"); at != std::string::npos)
            source.replace(at, 5, fmt::format("{}", trips));
        scratch_.write("f.fl", source);
        scratch_.write("w.fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "{}"}}}},
  "materials": {{"resin": {{"key": "#ffffff"}}}},
  "meshes": {{"m": {}}},
  "objects": {{"o": {{"mesh": "m", "fablet": "f", "uniforms": {{"body": "resin"}},
                      "max_displacement_mm": 0.05}}}},
  "build": [{{"object": "o"}}]
}})",
                                                 name, mesh));
    }
    RunOptions options() const {
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}};
        options.signal = SIGTERM;
        return options;
    }
    /// Sends a signal once lower slices are printed, and a while later, when the upper ones have begun.
    Outcome print_interrupted(const std::vector<std::string>& more, int wait_ms = 2000) {
        std::vector<std::string> argv{
            program("openfab"), "print", path("w.fab.json"), "-o",   path("a.ofr"),
            "--progress",       "json",  "--voxel",          "0.1mm"};
        argv.insert(argv.end(), more.begin(), more.end());
        RunOptions run_options = options();
        int seen = -1;
        run_options.interrupt_when = [&](int elapsed_ms, const Outcome& so_far) {
            if (seen < 0 && so_far.err.find("slices_done") != std::string::npos) seen = elapsed_ms;
            return seen >= 0 && elapsed_ms > seen + wait_ms;
        };
        return run(argv, run_options);
    }
    Outcome compile() {
        std::vector<std::string> argv{program("openfab"), "print",   path("w.fab.json"),
                                      "--dry-run",        "--voxel", "0.1mm"};
        return run(argv, options());
    }
};

constexpr const char* kBlock = R"({"box": [2, 2, 2]})";

TEST_F(Interrupts, LoopsThatNeverEndEnd) {
    write_world(kLoops, "Loops", kBlock);
    const Outcome ended = print_interrupted({});
    EXPECT_EQ(ended.exit_code, 130) << ended.err;
    EXPECT_THAT(ended.err, ::testing::ContainsRegex("interrupted after [1-8] of 20 slices"));
    EXPECT_THAT(ended.err, Says(program::messages::kResumeHelp));
}

TEST_F(Interrupts, WalksThatNeverEndEnd) {
    write_world(kWalks, "Walks", R"({"sphere": 2})");
    const Outcome ended = print_interrupted({});
    EXPECT_EQ(ended.exit_code, 130) << ended.err;
    EXPECT_THAT(ended.err, ::testing::ContainsRegex("interrupted after [1-8] of 20 slices"));
}

TEST_F(Interrupts, WhatWasPrintedGoesOnToTheSameBytes) {
    write_world(kLoops, "Loops", kBlock, 200);
    std::vector<std::string> argv{
        program("openfab"), "print", path("w.fab.json"), "-o", path("whole.ofr"),
        "--voxel",          "0.1mm"};
    ASSERT_EQ(run(argv, options()).exit_code, 0);
    const Outcome ended = print_interrupted({}, 0);
    EXPECT_EQ(ended.exit_code, 130) << ended.err;
    argv[4] = path("a.ofr");
    argv.emplace_back("--resume");
    const Outcome resumed = run(argv, options());
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("whole.ofr")));
}

TEST_F(Interrupts, StagesOfGeometryEndToo) {
    struct Case {
        const char *fablet, *name, *mesh;
    };
    for (const Case& c :
         {Case{kShape, "Turns", R"({"shape": "f", "box_mm": [[-1, -1, 0], [1, 1, 2]]})"},
          Case{kSurface, "Bumps", kBlock}}) {
        write_world(c.fablet, c.name, c.mesh);
        const Outcome built =
            run({program("openflc"), "build", path("f.fl"), "-o", path("printer")}, options());
        ASSERT_EQ(built.exit_code, 0) << built.err;
        RunOptions run_options = options();
        run_options.interrupt_when = [](int elapsed_ms, const Outcome&) {
            return elapsed_ms > 1500;
        };
        const Outcome ended =
            run({path("printer"), path("w.fab.json"), "-o", path("a.ofr"), "--voxel", "0.1mm"},
                run_options);
        EXPECT_EQ(ended.exit_code, 130) << c.name << ended.err;
    }
}

TEST_F(Interrupts, CommandsThatWaitForAPrintEndWithIt) {
    write_world(kLoops, "Loops", kBlock);
    ASSERT_EQ(compile().exit_code, 0);
    const std::string world = path("w.fab.json");
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"check", world, "--wall", "0.3mm"},
             {"render", world, "-o", path("a.png")},
             {"profile", world, "--voxel", "0.1mm"},
             {"tune", world, "--voxel", "0.1mm", "-o", path("t.sched")}}) {
        std::vector<std::string> argv{program("openfab")};
        argv.insert(argv.end(), words.begin(), words.end());
        RunOptions run_options = options();
        run_options.interrupt_when = [](int elapsed_ms, const Outcome&) {
            return elapsed_ms > 2500;
        };
        const Outcome ended = run(argv, run_options);
        EXPECT_EQ(ended.exit_code, 130) << words[0] << ended.err;
    }
}

/// Writes a ball of very many triangles, which takes long to read.
void write_ball(const std::string& file, int rings) {
    const auto at = [&](int ring, int spoke) -> std::array<float, 3> {
        const double up = 3.14159265358979 * ring / rings,
                     around = 3.14159265358979 * (spoke % (2 * rings)) / rings;
        if (ring == 0 || ring == rings) return {0, 0, ring == 0 ? 20.0F : -20.0F};
        return {static_cast<float>(20 * std::sin(up) * std::cos(around)),
                static_cast<float>(20 * std::sin(up) * std::sin(around)),
                static_cast<float>(20 * std::cos(up))};
    };
    std::string facets;
    uint32_t count = 0;
    const auto add = [&](const std::array<std::array<float, 3>, 3>& corners) {
        const std::array<float, 3> normal{};
        facets.append(reinterpret_cast<const char*>(&normal), sizeof normal);
        facets.append(reinterpret_cast<const char*>(&corners), sizeof corners);
        facets.append(2, 0);
        ++count;
    };
    for (int r = 0; r < rings; ++r) {
        for (int s = 0; s < 2 * rings; ++s) {
            if (r > 0) add({at(r, s), at(r + 1, s), at(r, s + 1)});
            if (r + 1 < rings) add({at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)});
        }
    }
    std::ofstream out(file, std::ios::binary);
    out << std::string(80, ' ');
    out.write(reinterpret_cast<const char*>(&count), sizeof count);
    out << facets;
}

/// Whatever a command does, whichever signal ends it, and whatever runs for it: exit code 130, and one line.
TEST_F(Interrupts, EveryCommandEndsAlike) {
    std::signal(SIGHUP, SIG_DFL);  // `nohup` has it ignored
    write_world(kLoops, "Loops", kBlock);
    ASSERT_EQ(compile().exit_code, 0);
    write_ball(path("ball.stl"), 700);
    std::string many = read_file(path("w.fab.json")), once = read_file(path("f.fl"));
    once.replace(once.find("1000000"), 7, "1");
    scratch_.write("once.fl", once);
    many.replace(many.find("f.fl"), 4, "once.fl");
    const std::string block = kBlock;
    many.replace(many.find(block), block.size(), R"({"file": "ball.stl"})");
    scratch_.write("many.fab.json", many);
    scratch_.write("mechanics.json",
                   R"({"materials": {"resin": {"E_MPa": 2000, "nu": 0.35, "strength_MPa": 50}}})");
    {
        SamplePrint print = make_sample({900, 900, 200});
        const auto sink = ofr::OfrSink::create(path("large.ofr"));
        ASSERT_TRUE(sink);
        ASSERT_TRUE(print.send(sink->get()));
    }
    const std::string world = path("w.fab.json"), ball = path("many.fab.json");
    const Outcome archived = run(
        {program("openfab"), "print", ball, "-o", path("ball.ofr"), "--voxel", "1mm"}, options());
    ASSERT_EQ(archived.exit_code, 0) << archived.err;
    struct Command {
        std::vector<std::string> words;
        int after_ms = 400;
        const char* until = nullptr;  ///< what it says first; null: nothing
    };
    for (const Command& command :
         std::vector<Command>{{{"print", world, "-o", path("a.ofr"), "--voxel", "0.1mm"}, 1500},
                              {{"print", ball, "-o", path("b.ofr")}},
                              {{"check", world, "--wall", "0.3mm"}, 1500},
                              {{"render", world, "-o", path("a.png")}, 1500},
                              {{"mechanics", "stand", ball}},
                              {{"arrange", ball, "--fit", "j750", "-o", path("trays.fab.json")}},
                              {{"split", ball, "--fit", "j750", "-o", path("pieces.fab.json")}},
                              {{"import", path("ball.stl"), "-o", path("ball")}},
                              {{"export", path("large.ofr"), "-o", path("slices")}},
                              {{"archive", path("ball.ofr"), "-o", path("ball.zip")}, 60},
                              {{"view", world, "--port", "0"}, 100, "http"},
                              {{"receive", "--listen", "tcp://127.0.0.1:0", "-o", path("r.ofr")},
                               100,
                               "listening"}}) {
        for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
            std::vector<std::string> argv{program("openfab")};
            argv.insert(argv.end(), command.words.begin(), command.words.end());
            RunOptions run_options = options();
            run_options.signal = signal;
            // A machine may be so fast that it is done before: then sooner.
            Outcome ended;
            for (int after_ms = command.after_ms; ended.exit_code <= 0 && after_ms > 10;
                 after_ms /= 2) {
                int seen = command.until == nullptr ? 0 : -1;
                run_options.interrupt_when = [&](int elapsed_ms, const Outcome& so_far) {
                    const std::string said = so_far.out + so_far.err;
                    if (seen < 0 && said.find(command.until) != std::string::npos)
                        seen = elapsed_ms;
                    return seen >= 0 && elapsed_ms > seen + after_ms;
                };
                ended = run(argv, run_options);
            }
            EXPECT_EQ(ended.exit_code, 130) << command.words[0] << ' ' << signal << '\n'
                                            << ended.err;
            size_t told = 0;
            for (size_t at = ended.err.find("error: "); at != std::string::npos;
                 at = ended.err.find("error: ", at + 1))
                ++told;
            EXPECT_EQ(told, 1U) << command.words[0] << ' ' << signal << '\n' << ended.err;
            EXPECT_THAT(ended.err, ::testing::HasSubstr("error: interrupted"))
                << command.words[0] << ' ' << signal;
        }
    }
}

/// A command that prints for its own use has no `--resume`, and keeps none of that print.
TEST_F(Interrupts, OnlyAPrintAdvisesToResume) {
    write_world(kLoops, "Loops", kBlock, 1);
    ASSERT_EQ(compile().exit_code, 0);
    RunOptions full = options();
    full.largest_file_bytes = 1200;
    for (const std::string command : {"print", "render"}) {
        const Outcome ended = run({program("openfab"), command, path("w.fab.json"), "-o",
                                   path(command == "print" ? "a.ofr" : "a.png")},
                                  full);
        EXPECT_EQ(ended.exit_code, 3) << command << ended.err;
        EXPECT_EQ(testing::says(ended.err, program::messages::kResumeHelp), command == "print")
            << ended.err;
    }
}

TEST_F(Interrupts, OpenflcRunEndsAtOnce) {
    write_world(kLoops, "Loops", kBlock);
    RunOptions run_options = options();
    run_options.interrupt_when = [](int, const Outcome& so_far) {
        return so_far.err.find("slices_done") != std::string::npos;
    };
    const Outcome ended = run({program("openflc"), "run", path("f.fl"), path("w.fab.json"), "-o",
                               path("a.ofr"), "--voxel", "0.1mm", "--progress", "json"},
                              run_options);
    EXPECT_EQ(ended.exit_code, 130) << ended.err;
    EXPECT_THAT(ended.err, ::testing::ContainsRegex("interrupted after [1-8] of 20 slices"));
}

}  // namespace
}  // namespace openfab::testing
