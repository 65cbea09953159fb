// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openflc run`: the bytes of the print binary, without one, and again after a change.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <chrono>
#include <cstring>
#include <regex>
#include <utility>

#include "tests/scenes/scene_fixture.h"
#include "tests/support/long_run.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class RunCommand : public PostcardScene {
  protected:
    static std::vector<std::string> command(const std::filesystem::path& folder,
                                            const std::vector<std::string>& arguments) {
        std::vector<std::string> argv{program("openflc").string(), "run",
                                      (folder / "magic_postcard.fl").string(),
                                      (folder / "postcard.fab.json").string()};
        argv.insert(argv.end(), arguments.begin(), arguments.end());
        return argv;
    }
};

TEST_F(RunCommand, GivesTheBytesOfThePrintBinary) {
    const std::filesystem::path built = scratch() / "built.ofr", run_file = scratch() / "run.ofr";
    const Outcome printed = print({"--draft", "6", "-o", built.string()});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Outcome ran =
        run(command(gallery_postcard(), {"--draft", "6", "-o", run_file.string()}), environment());
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_GT(read_file(built).size(), 10'000u);
    EXPECT_TRUE(read_file(built) == read_file(run_file));
}

/// All but form_surface_bounds, without which undisplaced surfaces are diced. All at once on each
/// push, and each one alone in long runs.
TEST_F(RunCommand, NoPassChangesTheBytes) {
    const std::filesystem::path with = scratch() / "with.ofr", without = scratch() / "without.ofr";
    const Outcome printed = print({"--draft", "8", "-o", with.string()});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const std::vector<std::string> passes{
        "simplify",           "eliminate_common_values", "eliminate_dead_values",
        "form_volume_bounds", "hoist_invariants",        "hoist_uniforms"};
    std::vector<std::vector<std::string>> runs{passes};
    for (size_t k = 0; k < passes.size() && long_run(); ++k)
        runs.push_back({passes[k]});
    for (const std::vector<std::string>& left_out : runs) {
        std::vector<std::string> arguments{"--draft", "8", "-o", without.string()};
        for (const std::string& pass : left_out)
            arguments.insert(arguments.end(), {"--no-pass", pass});
        const Outcome ran = run(command(gallery_postcard(), arguments), environment());
        ASSERT_EQ(ran.exit_code, 0) << ran.err;
        EXPECT_TRUE(read_file(with) == read_file(without)) << left_out.front();
    }
}

/// Stripes of a quarter of 0.4 mm: the centres of coarse voxels all lie in the same part of one.
TEST_F(RunCommand, CoarseFractionsAreMeansOverVolumesUnlessCentresAreAskedFor) {
    scratch().write("stripes.fl", R"(fablet Stripes {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(frac(attr.voxelCenter.x / 0.4) < 0.25 ? a : b, 1);
        return mc;
    }
}
)");
    scratch().write("stripes.fab.json", R"({
    "openfab": 1, "printer": "generic",
    "fablets": {"s": {"source": "stripes.fl", "fablet": "Stripes"}},
    "materials": {"a": {"key": "#ff0000"}, "b": {"key": "#00ff00"}},
    "meshes": {"m": {"box": [8, 8, 8]}},
    "objects": {"o": {"mesh": "m", "fablet": "s", "uniforms": {"a": "a", "b": "b"}}},
    "build": [{"object": "o"}]
})");
    const std::filesystem::path array = scratch() / "mix.npy";
    const auto share_of_a = [&](const std::vector<std::string>& more) {
        std::vector<std::string> argv{program("openflc").string(),
                                      "run",
                                      (scratch() / "stripes.fl").string(),
                                      (scratch() / "stripes.fab.json").string(),
                                      "--fractions",
                                      array.string()};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome ran = run(argv, environment());
        EXPECT_EQ(ran.exit_code, 0) << ran.err;
        const std::string file = read_file(array).substr(128);  // after the header
        std::vector<std::array<float, 2>> voxels(file.size() / sizeof(std::array<float, 2>));
        std::memcpy(voxels.data(), file.data(), file.size());
        double sum = 0;
        for (const auto& [a, b] : voxels) {
            EXPECT_NEAR(a + b, 1, 1e-6);
            sum += a;
        }
        return sum / static_cast<double>(voxels.size());
    };
    EXPECT_NEAR(share_of_a({"--voxel", "0.05mm"}), 0.25, 1e-6);
    EXPECT_NEAR(share_of_a({"--voxel", "1mm"}), 0.25, 1e-6);
    EXPECT_NEAR(share_of_a({"--voxel", "0.8mm", "--threads", "3", "--slices", "2:5"}), 0.25, 1e-6);
    EXPECT_NEAR(share_of_a({"--draft", "8"}), 0.25, 1e-6);
    // 32 parts of 4 mm are not those of the printer's voxels, which is told.
    EXPECT_NEAR(share_of_a({"--voxel", "4mm"}), 0.25, 0.02);
    EXPECT_EQ(share_of_a({"--voxel", "1mm", "--sampling", "centre"}), 0);
    // In parts of 0.1 mm a stripe is one of four; the centres of coarser ones may miss it again.
    EXPECT_NEAR(share_of_a({"--voxel", "1mm", "--fractions-supersample", "10"}), 0.25, 1e-6);
    EXPECT_NEAR(share_of_a({"--voxel", "0.8mm", "--fractions-supersample", "8"}), 0.25, 1e-6);
}

TEST_F(RunCommand, NeedsAFabletAndAWorld) {
    const Outcome no_fablet = run({program("openflc").string(), "run", "some.fab.json"});
    EXPECT_EQ(no_fablet.exit_code, 2);
    EXPECT_THAT(no_fablet.err, HasSubstr("no fablet given"));
    const Outcome no_world = run({program("openflc").string(), "run", "some.fl"});
    EXPECT_EQ(no_world.exit_code, 2);
    const Outcome unknown =
        run(command(gallery_postcard(), {"--drift", "6", "-o", (scratch() / "no.ofr").string()}));
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("--drift"));
}

TEST_F(RunCommand, AMistakeInTheFabletIsADiagnostic) {
    scratch().write("wrong.fl", "fablet Wrong {");
    const Outcome outcome =
        run({program("openflc").string(), "run", (scratch() / "wrong.fl").string(),
             (gallery_postcard() / "postcard.fab.json").string(), "-o",
             (scratch() / "no.ofr").string()});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("wrong.fl:1:15: error"));
}

/// Returns how often `--watch` has printed all there was, and begun to wait.
size_t times_waited(const Outcome& so_far) {
    size_t waits = 0;
    for (size_t at = 0; (at = so_far.err.find("watching", at)) != std::string::npos; ++at)
        ++waits;
    return waits;
}

/// Each time the command waits, the fablet is changed: to black, to an error, and back.
TEST_F(RunCommand, WatchPrintsAgainAfterEachChange) {
    const std::filesystem::path folder = scratch() / "watched";
    std::filesystem::create_directories(folder);
    for (const char* name :
         {"magic_postcard.fl", "card.obj", "foreground.jpg", "hidden.jpg", "postcard.fab.json"}) {
        std::filesystem::copy_file(gallery_postcard() / name, folder / name);
    }
    const std::filesystem::path preview = folder / "preview.png";
    const std::string text = read_file(folder / "magic_postcard.fl");
    const auto with = [&](const std::string& line) {
        std::string changed = text;
        const std::string border = "mc.Set(white, 1);";
        changed.replace(changed.find(border), border.size(), line);
        return changed;
    };
    const std::vector<std::string> versions{with("mc.Set(black, 1);"), with("mc.Set(grey, 1);"),
                                            text};
    std::vector<std::string> pictures;
    RunOptions options = environment();
    options.interrupt_when = [&](int elapsed_ms, const Outcome& so_far) {
        if (elapsed_ms > 300'000) return true;  // which only a hang reaches
        const size_t waits = times_waited(so_far);
        if (waits <= pictures.size()) return false;
        pictures.push_back(read_file(preview));
        if (pictures.size() > versions.size()) return true;
        scratch().write("watched/magic_postcard.fl", versions[pictures.size() - 1]);
        return false;
    };
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = run(command(folder, {"--draft", "8", "--watch", "--preview",
                                                 preview.string() + ",view=bottom"}),
                                options);
    const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("grey"));
    ASSERT_EQ(pictures.size(), 4u) << outcome.err;
    EXPECT_FALSE(pictures[0] == pictures[1]);
    EXPECT_TRUE(pictures[1] == pictures[2]) << "the mistake must leave the picture alone";
    EXPECT_TRUE(pictures[0] == pictures[3]);
    // Each print counts from its own change: the times lie apart within the whole, however slow the
    // machine, and each is rounded to a tenth.
    const std::regex summary(R"(slices in ([0-9.]+) s)");
    double seconds = 0;
    size_t prints = 0;
    for (std::sregex_iterator it(outcome.err.begin(), outcome.err.end(), summary), end; it != end;
         ++it, ++prints)
        seconds += std::stod((*it)[1]);
    EXPECT_EQ(prints, 3u) << outcome.err;
    EXPECT_LT(seconds, whole.count() + 0.2);
}

/// Each time the command waits, a file of the world is changed, or the world so that it names another.
TEST_F(RunCommand, WatchSeesMeshesFromTheFirstPrintOn) {
    const auto box = [](int size) {
        std::string text;
        for (int corner = 0; corner < 8; ++corner)
            text += fmt::format("v {} {} {}\n", corner & 1 ? size : 0, corner & 2 ? 2 : 0,
                                corner & 4 ? 2 : 0);
        return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    };
    const auto world = [](const std::string& mesh) {
        return R"({"openfab": 1, "printer": "generic",
            "fablets": {"f": {"source": "plain.fl", "fablet": "Plain"}},
            "materials": {"a": {"key": "#ff0000"}},
            "meshes": {"m": {"file": ")" +
               mesh + R"(", "unit": "mm"}},
            "objects": {"o": {"mesh": "m", "fablet": "f", "uniforms": {"a": "a"}}},
            "build": [{"object": "o"}]})";
    };
    scratch().write("plain.fl", R"(fablet Plain {
            @uniform { Material a; }
            @Volume(@varying { VolumeAttributes attr }) {
                MaterialComposition mc;
                mc.Set(a, 1);
                return mc;
            }
        })");
    scratch().write("one.obj", box(2));
    scratch().write("two.obj", box(4));
    scratch().write("plain.fab.json", world("one.obj"));
    const std::vector<std::pair<const char*, std::string>> edits{
        {"one.obj", box(3)},
        {"plain.fab.json", world("two.obj")},
        {"two.obj", "no mesh"},
        {"two.obj", box(5)}};
    size_t made = 0;
    RunOptions options = environment();
    options.interrupt_when = [&](int elapsed_ms, const Outcome& so_far) {
        if (elapsed_ms > 300'000) return true;  // which only a hang reaches
        const size_t waits = times_waited(so_far);
        if (waits <= made) return false;
        if (made == edits.size()) return true;
        scratch().write(edits[made].first, edits[made].second);
        ++made;
        return false;
    };
    const Outcome outcome =
        run({program("openflc").string(), "run", (scratch() / "plain.fl").string(),
             (scratch() / "plain.fab.json").string(), "--voxel", "0.5mm", "--watch", "-o",
             (scratch() / "plain.ofr").string()},
            options);
    EXPECT_EQ(made, edits.size()) << outcome.err;
    const std::regex volume(R"(a ([0-9.]+) ml)");
    std::vector<std::string> volumes;
    for (std::sregex_iterator it(outcome.err.begin(), outcome.err.end(), volume), end; it != end;
         ++it)
        volumes.push_back((*it)[1]);
    EXPECT_EQ(volumes, (std::vector<std::string>{"0.01", "0.01", "0.02", "0.02"})) << outcome.err;
}

}  // namespace
}  // namespace openfab::testing
