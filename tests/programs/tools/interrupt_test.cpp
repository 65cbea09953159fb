// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A signal ends whatever a fablet is doing, also what would never end, and what was printed before is
// whole. No test looks at the clock: a program that goes on runs into the limit of ten minutes, and is
// killed.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "program/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"

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
        EXPECT_TRUE(ended.exit_code == 130 || ended.exit_code == 128 + SIGTERM)
            << words[0] << " " << ended.exit_code << ended.err;
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
