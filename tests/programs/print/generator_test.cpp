// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Geometry that a program of the user's makes: the same as if it were data, however it is printed; and what a program
// may not do.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>

#include "base/messages.h"
#include "mesh/model/messages.h"
#include "program/messages.h"
#include "runtime/part/messages.h"
#include "runtime/solid/messages.h"
#include "tests/programs/print/process_fixture.h"
#include "tests/support/says/says.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

/// A tree of 2 + 4 * 6 beams; `more` for each branch.
constexpr const char* kTree = R"(
while read word key box; do
    case $key in
    root)
        echo "# the stem"
        echo "beam 0 0 0.8  0 0 5  0.7 0.5"
        echo "beam 0 0 5  0.5 0 9  0.5 0.3"
        for i in 1 2 3 4; do echo "more b$i -5.5 -5.5 $i 5.5 5.5 11.5"; done ;;
    *)
        i=${key#b}
        for j in 1 2 3 4 5 6; do
            echo "beam 0 0 $((i + 2)) $((i - j)).25 $((j - 3)).5 $((i + 5)) 0.3 0.2"
        done ;;
    esac
    echo done
done
)";

class Generator : public ProcessOption {
  protected:
    void world(const std::string& mesh, const std::string& more_objects = "",
               const std::string& more_meshes = "") {
        scratch_.write("g.fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "{}"}}}},
  "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000"}}}},
  "meshes": {{"made": {}{}}},
  "objects": {{"a": {{"mesh": "made", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}{}}},
  "build": [{{"object": "a", "rotate_deg": [10, 20, 30]}}]
}})",
                                                 fablet_, mesh, more_meshes, more_objects));
    }
    void program(const std::string& script, const std::string& keys = "") {
        scratch_.write("made.sh", script);
        world(fmt::format(
            R"({{"program": ["sh", "made.sh"], "box_mm": [[-6, -6, 0], [6, 6, 12]]{}}})", keys));
    }
    Voxels voxels(std::vector<std::string> more = {}) {
        more.push_back("--allow-programs");
        return print_voxels(more, "g.fab.json");
    }
    /// Returns what a print of a program says that fails.
    std::string refusal(const std::string& script, const std::string& keys = "") {
        program(script, keys);
        const Outcome outcome = print({"--allow-programs", "-o", path("bad.ofr")}, "g.fab.json");
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("g.fab.json:5:34"));
        return outcome.err;
    }
    static std::string answer(const std::string& lines) {
        return "while read word key box; do cat <<'END'\n" + lines + "\ndone\nEND\ndone\n";
    }

    std::string fablet_ = "Skin";
};

TEST_F(Generator, RunsOnlyIfItIsAllowed) {
    program("touch ran\n" + std::string(kTree));
    const Outcome refused = print({"-o", path("bad.ofr")}, "g.fab.json");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("`sh made.sh`"));
    EXPECT_THAT(refused.err, HasSubstr("`--allow-programs`"));
    EXPECT_FALSE(std::filesystem::exists(path("ran")));
    voxels();
    EXPECT_TRUE(std::filesystem::exists(path("ran")));
}

TEST_F(Generator, PrintsWhatTheSameBeamsPrint) {
    fablet_ = "Solid";  // the boxes differ, and a dither begins where they do
    std::string nodes = "node 0 0 0.8 0.7\nnode 0 0 5 0.5\nnode 0 0 5 0.5\nnode 0.5 0 9 0.3\n";
    std::string struts = "strut 0 1\nstrut 2 3\n";
    int count = 4;
    for (int i = 1; i <= 4; ++i) {
        for (int j = 1; j <= 6; ++j) {
            nodes += fmt::format("node 0 0 {} 0.3\nnode {}.25 {}.5 {} 0.2\n", i + 2, i - j, j - 3,
                                 i + 5);
            struts += fmt::format("strut {} {}\n", count, count + 1);
            count += 2;
        }
    }
    scratch_.write("tree.txt", nodes + struts);
    world(R"({"beams": "tree.txt"})");
    const Voxels data = voxels();
    program(kTree);
    const Voxels made = voxels();
    // The box of beams is tighter than that of the world.
    int64_t inside = 0;
    const auto shift = [&](int axis) {
        return static_cast<int32_t>(
            std::lround((data.info.origin_mm[axis] - made.info.origin_mm[axis]) / 0.1));
    };
    for (int32_t z = 0; z < data.info.slice_end; ++z) {
        for (int32_t y = 0; y < data.info.size.y; ++y) {
            for (int32_t x = 0; x < data.info.size.x; ++x) {
                const bool solid = data.at(x, y, z) != 0;
                inside += solid ? 1 : 0;
                ASSERT_EQ(made.at(x + shift(0), y + shift(1), z + shift(2)) != 0, solid);
            }
        }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_EQ(std::ranges::count_if(made.codes, [](uint8_t c) { return c != 0; }), inside);
}

TEST_F(Generator, IsTheSameForAllWaysToPrint) {
    program(kTree);
    const Voxels whole = voxels();
    for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
             {"--threads", "1"}, {"--threads", "5", "--no-cull"}, {"--memory", "150MB"}})
        EXPECT_TRUE(voxels(more).codes == whole.codes) << more.front();
    const size_t slice = static_cast<size_t>(whole.info.size.x) * whole.info.size.y;
    for (const auto& [first, last] : {std::pair{13, 40}, std::pair{40, 77}}) {
        const Voxels part = voxels({"--slices", fmt::format("{}:{}", first, last)});
        ASSERT_EQ(part.codes.size(), static_cast<size_t>(last - first) * slice);
        EXPECT_TRUE(std::equal(part.codes.begin(), part.codes.end(),
                               whole.codes.begin() + static_cast<ptrdiff_t>(first * slice)));
    }
}

TEST_F(Generator, GoesOnWhereAPrintWasCut) {
    program(kTree);
    const Voxels whole = voxels();
    const std::string file = path("out.ofr");
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    EXPECT_TRUE(voxels({"--resume"}).codes == whole.codes);
    // Another program is another print.
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    program(std::string(kTree) + "# changed\n");
    const Outcome other = print({"--allow-programs", "--resume", "-o", file}, "g.fab.json");
    EXPECT_NE(other.exit_code, 0);
    std::filesystem::remove(file);
}

/// A mesh in an answer, a mesh that is placed, and the same mesh as data.
TEST_F(Generator, MeshesAndCopiesAreWhereTheyAreAsData) {
    const std::string box = "[[-6, -6, 0], [6, 6, 12]]";
    const std::string made = R"({"program": ["sh", "made.sh"], "box_mm": )" + box;
    scratch_.write("made.sh", answer(R"(mesh 8 12
-2.03 -1.52 1.01
 2.03 -1.52 1.01
 2.03  1.52 1.01
-2.03  1.52 1.01
-2.03 -1.52 5.07
 2.03 -1.52 5.07
 2.03  1.52 5.07
-2.03  1.52 5.07
0 2 1
0 3 2
4 5 6
4 6 7
0 1 5
0 5 4
1 2 6
1 6 5
2 3 7
2 7 6
3 0 4
3 4 7)"));
    world(made + "}");
    const Voxels meshes = voxels();
    const std::string brick = R"(, "brick": {"mesh": "brick", "fablet": "f"})";
    const std::string brick_mesh = R"(, "brick": {"box": [2.03, 2.03, 1.52]})";
    const std::string world_of_bricks = made + R"(, "places": ["brick"]})";
    // The brick's z is the box's y, and it is half as large.
    scratch_.write("made.sh", answer("place brick 0 -1.52 3.04  0 0 2  2 0 0  0 2 0"));
    world(world_of_bricks, brick, brick_mesh);
    EXPECT_TRUE(voxels().codes == meshes.codes);
    // A mirrored one.
    scratch_.write("made.sh", answer("place brick 0 1.52 3.04  0 0 2  2 0 0  0 -2 0"));
    EXPECT_TRUE(voxels().codes == meshes.codes);
    const auto count = [](const Voxels& voxels) {
        return std::ranges::count_if(voxels.codes, [](uint8_t c) { return c != 0; });
    };
    world(R"({"box": [4.06, 3.04, 4.06]})");
    EXPECT_NEAR(static_cast<double>(count(voxels())), static_cast<double>(count(meshes)), 100);
    for (const char* axes : {"2 0 0  0 0 2  0 4 0", "2 0 0  2 0 0  0 2 0", "0 0 0  0 0 0  0 0 0"}) {
        scratch_.write("made.sh", answer(std::string("place brick 0 -1.52 3.04  ") + axes));
        world(world_of_bricks, brick, brick_mesh);
        const Outcome outcome = print({"--allow-programs", "-o", path("bad.ofr")}, "g.fab.json");
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_THAT(outcome.err, HasSubstr("line 1: "));
        EXPECT_THAT(outcome.err, HasSubstr("length"));
    }
}

/// Whether a process is there that is not only waited for.
bool is_running(const std::string& process) {
    const std::string file = "/proc/" + process + "/stat";
    if (!std::filesystem::exists(file)) return false;
    const std::string stat = read_file(file);
    const size_t state = stat.rfind(')') + 2;
    return state < stat.size() && stat[state] != 'Z' && stat[state] != 'X';
}

/// With what it has started, whatever ends the print; also one that minds no signal but the last.
TEST_F(Generator, EndsWithThePrint) {
    for (const std::string mind : {"", "trap '' TERM INT HUP; "}) {
        for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
            std::filesystem::remove(path("pids"));
            program(
                mind +
                "sleep 300 & echo $$ $! > pids.part; mv pids.part pids; read word; sleep 300\n");
            RunOptions ended;
            ended.signal = signal;
            ended.interrupt_when = [&](int, const Outcome&) {
                return std::filesystem::exists(path("pids"));
            };
            const Outcome outcome =
                print({"--allow-programs", "-o", path("cut.ofr")}, "g.fab.json", ended);
            EXPECT_NE(outcome.exit_code, 0);
            std::istringstream pids(read_file(path("pids")));
            std::string shell, child;
            pids >> shell >> child;
            // After SIGKILL another process ends them, within a second or two.
            for (int i = 0; i < 1000 && (is_running(shell) || is_running(child)); ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            EXPECT_FALSE(is_running(shell)) << signal << mind;
            EXPECT_FALSE(is_running(child)) << signal << mind;
        }
    }
}

/// Which slices take long is told, and an unattended machine ends it.
TEST_F(Generator, ASlabMayTakeSoLong) {
    program(R"(
while read word key box; do
    case $key in
    root) echo "beam 0 0 0.8  0 0 5  0.7 0.5"; echo "more b -5.5 -5.5 6 5.5 5.5 11.5" ;;
    *) sleep 300 ;;
    esac
    echo done
done
)");
    const Outcome outcome =
        print({"--allow-programs", "-o", path("cut.ofr"), "--slab-limit", "2"}, "g.fab.json");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, Says(program::messages::kSlabTooLong));
    EXPECT_THAT(outcome.err, HasSubstr("the `--slab-limit`"));
    program(kTree);
    EXPECT_EQ(
        print({"--allow-programs", "-o", path("a.ofr"), "--slab-limit", "10min"}, "g.fab.json")
            .exit_code,
        0);
    EXPECT_EQ(print({"-o", path("a.ofr"), "--slab-limit", "-1"}, "g.fab.json").exit_code, 2);
}

/// What a program leaves in the background when it has answered, or is too slow.
TEST_F(Generator, LeavesNothingBehind) {
    for (const std::string end : {"", "sleep 300"}) {
        program("sleep 300 & echo $! > pid; " + end +
                    "\nwhile read word key box; do echo 'beam 0 0 1 0 0 9 1 1'; echo done; done\n",
                R"(, "answer_s": 1)");
        const Outcome outcome = print({"--allow-programs", "-o", path("a.ofr")}, "g.fab.json");
        EXPECT_EQ(outcome.exit_code, end.empty() ? 0 : 1) << outcome.err;
        std::string pid = read_file(path("pid"));
        pid.pop_back();
        for (int i = 0; i < 500 && is_running(pid); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        EXPECT_FALSE(is_running(pid)) << end;
    }
}

TEST_F(Generator, SaysWhatAProgramDoesWrong) {
    const std::string box = "-1 -1 1 1 1 2";
    EXPECT_THAT(refusal(answer("hello")), testing::Says(solid::messages::kNoKnownLine, "hello"));
    EXPECT_THAT(refusal(answer("beam 0 0 1 0 0 2 nan 1")),
                testing::Says(solid::messages::kNotABeam));
    EXPECT_THAT(refusal(answer("beam 0 0 1 0 0 2 1")),
                testing::Says(solid::messages::kNotABeamHelp));
    EXPECT_THAT(refusal(answer("# one\nbeam 0 0 1 0 0 2 0 -1")),
                testing::Says(solid::messages::kAtLine, 2));
    EXPECT_THAT(refusal(answer("beam 0 0 1 0 0 12.5 1 1")),
                testing::Says(solid::messages::kReachesOutside, solid::messages::kABeam,
                              "(-1, -1, 0)", "(1, 1, 13.5)"));
    EXPECT_THAT(refusal(answer("beam 0 0 1 0 0 2 1 1 7")),
                testing::Says(solid::messages::kNotABeam));
    EXPECT_THAT(
        refusal(answer("more a -1 -1 1 1 1 20")),
        testing::Says(solid::messages::kReachesOutside, fmt::format(solid::messages::kBoxOf, "a")));
    EXPECT_THAT(refusal(answer("more a 1 1 1 -1 -1 0")),
                testing::Says(solid::messages::kLowerCornerFirst));
    EXPECT_THAT(refusal(answer("more a " + box)),
                testing::Says(solid::messages::kMoreTooDeep, "1000"));
    EXPECT_THAT(refusal(answer("place leaf 0 0 0")),
                testing::Says(solid::messages::kPlaceUnlisted));
    EXPECT_THAT(refusal(answer("mesh 4 4\n0 0 1\n1 0 1\n0 1 1\n0 0 2\n0 2 1\n0 1 3\n0 3 2\n1 2 4")),
                testing::Says(solid::messages::kTriangleVertex, "3", "4"));
    EXPECT_THAT(refusal(answer("mesh 4 4\n0 0 1\n1 0 1\n0 1 1\n0 0 2\n0 2 1\n0 1 3\n0 3 2\n0 1 2")),
                Says(mesh::messages::kNotClosed));
    EXPECT_THAT(refusal(answer("mesh 4 4\n0 0 1\n1 0 1")),
                testing::Says(solid::messages::kEndsInMesh, solid::messages::kVertex, "2"));
    EXPECT_THAT(refusal(answer("error no such forest")), HasSubstr("no such forest"));
    EXPECT_THAT(refusal(answer("done")), testing::Says(messages::kWroteAfterDone));
    EXPECT_THAT(refusal("echo welcome\n" + answer("# nothing")), HasSubstr("welcome"));
    EXPECT_THAT(refusal("read line; exit 7"), testing::Says(messages::kEndedWithCode, "7"));
    EXPECT_THAT(refusal("read line; kill -9 $$"), HasSubstr("signal 9"));
    EXPECT_THAT(refusal("read line; sleep 30", R"(, "answer_s": 0.3)"),
                testing::Says(messages::kNoAnswerInTime, "*", "grow root -6 -6 0 6 6 12", "0.3"));
    EXPECT_THAT(refusal("read line; yes '# more'", R"(, "answer_mb": 1)"),
                testing::Says(messages::kAnswerTooLong, "*", "1"));
    EXPECT_THAT(refusal("n=0\nwhile read word key box; do n=$((n + 1))\n"
                        "if [ $key = root ]; then echo more a " +
                        box + "; echo more a " + box +
                        "; else echo beam 0 0 1.5 0 0 1.5 0.1 0.$n; fi; echo done; done"),
                testing::Says(solid::messages::kAnswersOtherwise));
    world(R"({"program": ["./no_such_program"], "box_mm": [[0, 0, 0], [1, 1, 1]]})");
    EXPECT_THAT(print({"--allow-programs", "-o", path("bad.ofr")}, "g.fab.json").err,
                testing::Says(messages::kDoesNotStart));
}

TEST_F(Generator, SaysWhatTheWorldSaysWrong) {
    const auto error = [&](const std::string& mesh) {
        world(mesh);
        const Outcome outcome = print({"--allow-programs", "-o", path("bad.ofr")}, "g.fab.json");
        EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
        return outcome.err;
    };
    EXPECT_THAT(error(R"({"program": "sh made.sh", "box_mm": [[0, 0, 0], [1, 1, 1]]})"),
                Says(world::messages::kNotWords));
    EXPECT_THAT(error(R"({"program": ["sh"]})"), Says(world::messages::kNoBox));
    EXPECT_THAT(error(R"({"box": [1, 1, 1], "places": []})"),
                Says(world::messages::kGoesWithProgram));
    EXPECT_THAT(error(R"({"program": ["sh"], "box_mm": [[0, 0, 0], [1, 1, 1]], "places": ["b"]})"),
                Says(part::messages::kNoSuchObject, "b"));
    EXPECT_THAT(error(R"({"program": ["sh"], "box_mm": [[0, 0, 0], [1, 1, 1]], "places": ["a"]})"),
                HasSubstr("places"));
    EXPECT_THAT(error(R"({"program": ["sh"], "box_mm": [[0, 0, 0], [1, 1, 1]],
        "attributes": {"age": "double"}})"),
                HasSubstr("attribute `age`"));
}

}  // namespace
}  // namespace openfab::testing
