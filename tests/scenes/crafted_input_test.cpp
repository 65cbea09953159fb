// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Malicious inputs: exploits, memory bombs and endless work. The programs print them or refuse them
// with a message, within the memory budget and a time limit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "base/messages.h"
#include "runtime/part/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

#ifdef OPENFAB_SANITIZED  // a sanitizer's own memory counts
constexpr int64_t kMemoryMb = 3000;
#else
constexpr int64_t kMemoryMb = 300;
#endif
constexpr int64_t kSlackMb = 50;
/// Of a processor: what takes more hangs, on any machine. Most take a second, the compiler ten.
constexpr double kHangSeconds = 300;
/// Memory limit of the compiler, which has no budget.
constexpr int64_t kCompilerMb = 1500;

struct Crafted {
    const char* name;
    const char* folder;                  ///< of tests/scenes/crafted
    const char* program;                 ///< openfab or openflc
    std::vector<std::string> arguments;  ///< the memory budget is added for `print`
    /// Text that the error message must contain; null if the input must be printed, empty if either
    /// is right.
    const char* refusal;
};

std::ostream& operator<<(std::ostream& out, const Crafted& crafted) {
    return out << crafted.name;
}

const std::vector<Crafted>& crafted_inputs() {
    static const std::vector<Crafted> inputs = {
        {"SourceThatLooksLikeAnOption",
         "option_as_source",
         "openfab",
         {"print", "card.fab.json", "--draft", "4"},
         nullptr},
        {"GridsWhoseProductOverflows",
         "grid_beyond_64_bits",
         "openfab",
         {"print", "g.fab.json"},
         "placements"},
        {"GridsBeyondMemory",
         "grid_beyond_64_bits",
         "openfab",
         {"print", "g2.fab.json"},
         "placements"},
        {"NumberOfManyZeros",
         "long_zeros",
         "openfab",
         {"print", "crash.fab.json", "--draft", "4"},
         nullptr},
        {"NumberOfManyDigits",
         "long_zeros",
         "openfab",
         {"print", "garbage.fab.json", "--draft", "4"},
         nullptr},
        {"NumberOfManyZerosInGltf", "long_zeros", "openfab", {"info", "crash.gltf"}, ""},
        {"DisplacedAndSelfCrossing",
         "scrambled_displaced",
         "openfab",
         {"print", "w.fab.json", "--slices", "0:8", "--draft", "4"},
         ""},
        {"EstimateOfDisplacedAndSelfCrossing",
         "scrambled_displaced",
         "openfab",
         {"print", "w.fab.json", "--estimate"},
         nullptr},
        {"TwoTrianglesAsLongAsThePart",
         "long_box",
         "openfab",
         {"print", "longbox.fab.json", "--slices", "0:1", "--draft", "4"},
         ""},
        {"ComponentsOfComponents",
         "packages",
         "openfab",
         {"import", "components.3mf", "-o", "out"},
         ""},
        {"Laughs",
         "packages",
         "openfab",
         {"import", "laughs.3mf", "-o", "out"},
         messages::kDocumentType},
        {"DoublesBeyondFloats", "packages", "openfab", {"info", "huge_doubles.ply"}, ""},
        {"MaterialsByIndex",
         "compile_bombs",
         "openflc",
         {"build", "materials_256.fl", "-o", "out", "--target", "sse41"},
         ""},
        {"FourThousandTextures",
         "compile_bombs",
         "openflc",
         {"build", "textures_4096.fl", "-o", "out", "--target", "sse41"},
         ""},
        {"NestedUnrolling",
         "compile_bombs",
         "openflc",
         {"build", "unroll_nest.fl", "-o", "out", "--target", "sse41"},
         ""},
        {"ArrayFilledByALoop",
         "compile_bombs",
         "openflc",
         {"build", "filled_array.fl", "-o", "out"},
         nullptr},
        {"TextureByIndex",
         "textures_by_index",
         "openflc",
         {"build", "min.fl", "-o", "out"},
         nullptr},
        {"TextureByIndexAndNoise",
         "textures_by_index",
         "openflc",
         {"build", "bad1.fl", "-o", "out", "--target", "sse41"},
         ""},
    };
    return inputs;
}

class CraftedInput : public ::testing::TestWithParam<Crafted> {};

TEST_P(CraftedInput, IsPrintedOrRefusedWithinTheBudget) {
    const Crafted& crafted = GetParam();
    const ScratchFolder scratch;
    std::filesystem::copy(source_dir() / "tests/scenes/crafted" / crafted.folder, scratch.path(),
                          std::filesystem::copy_options::recursive);
    std::vector<std::string> argv{program(crafted.program).string()};
    argv.insert(argv.end(), crafted.arguments.begin(), crafted.arguments.end());
    const bool prints = crafted.arguments[0] == "print";
    if (prints) {
        argv.insert(argv.end(), {"-o", "out.ofr", "--threads", "2"});
        argv.insert(argv.end(), {"--memory", std::to_string(kMemoryMb) + "MB"});
    }
    RunOptions options;
    options.folder = scratch.path();
    options.environment = {{"OPENFAB_CACHE", (scratch / "cache").string()}};
    const Outcome outcome = run(argv, options);
    if (crafted.refusal == nullptr) {
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    } else {
        EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 1) << outcome.exit_code << '\n'
                                                                      << outcome.err;
        if (outcome.exit_code == 1) {
            EXPECT_THAT(outcome.err, HasSubstr("error: "));
            EXPECT_THAT(outcome.err, HasSubstr(crafted.refusal));
        }
    }
#ifndef OPENFAB_SANITIZED  // sanitizers keep their own memory, and take their own time
    const bool compiles = crafted.arguments[0] == "build";
    EXPECT_LE(outcome.peak_rss_bytes, (compiles ? kCompilerMb : kMemoryMb + kSlackMb) << 20);
    EXPECT_LE(outcome.processor_seconds, kHangSeconds) << outcome.err;
#endif
}

INSTANTIATE_TEST_SUITE_P(All, CraftedInput, ::testing::ValuesIn(crafted_inputs()),
                         [](const auto& tested) { return std::string(tested.param.name); });

/// A world of many textures, of which each alone is small.
TEST(Textures, TakeTogetherWhatIsAllowed) {
    constexpr int kTextures = 16;
    const ScratchFolder scratch;
    std::string textures, maps;
    for (int i = 0; i < kTextures; ++i) {
        const std::string name = "t" + std::to_string(i);
        // All different, or they would share a cache entry.
        scratch.write(name + ".pgm",
                      "P5 1024 1024 255\n" + std::string(1 << 20, static_cast<char>(i)));
        textures += (i > 0 ? ", \"" : "\"") + name + R"(": {"file": ")" + name + R"(.pgm"})";
        maps += (i > 0 ? ", \"" : "\"") + name + "\"";
    }
    scratch.write("large.pgm", "P5 2048 1024 255\n" + std::string(2 << 20, 'x'));
    scratch.write("many.fl", R"(
fablet Many {
    @uniform { ImageTexture2D large; ImageTexture2D maps[16]; Material body; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, large.Sample1(0.5, 0.5, 0) + maps[0].Sample1(0.5, 0.5, 0));
        return mc;
    }
})");
    const std::string world = R"({"openfab": 1, "printer": "j750",
        "fablets": {"m": {"source": "many.fl", "fablet": "Many"}},
        "materials": {"w": {"key": "#ffffff"}},
        "textures": {"large": {"file": "large.pgm"}, )" +
                              textures + R"(},
        "meshes": {"m": {"box": [2, 2, 1]}},
        "objects": {"o": {"mesh": "m", "fablet": "m",
                          "uniforms": {"large": "large", "maps": [)" +
                              maps + R"(], "body": "w"}}},
        "build": [{"object": "o"}]})";
    scratch.write("w.fab.json", world);
    RunOptions options;
    options.folder = scratch.path();
    options.environment = {{"OPENFAB_CACHE", (scratch / "cache").string()}};
    const auto print = [&](const std::string& memory) {
        return run({program("openfab"), "print", "w.fab.json", "-o", "out.ofr", "--draft", "4",
                    "--threads", "2", "--memory", memory},
                   options);
    };
    const Outcome refused = print("150MB");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err,
                AllOf(Says(part::messages::kTexturesTakeMemory, "*", "*", "150 MB"),
                      Says(part::messages::kTexturesTakeMemoryHelp, "large", "34 MB")));
    // Later ones were not converted: a small world does not fill the disk either.
    int64_t kept = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scratch / "cache"))
        kept += entry.is_regular_file() ? static_cast<int64_t>(entry.file_size()) : 0;
    EXPECT_LT(kept, 200'000'000);
    const Outcome printed = print("1.5GB");
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
}

/// A fine ball whose triangles are all displaced: 4 n^2 of them, as binary STL.
std::string fine_ball(int n) {
    constexpr float kRadius_mm = 10;
    const auto corner = [&](int row, int column) {
        // One point each, whatever the column: the ball is closed.
        if (row % n == 0) return std::array<float, 3>{0, 0, row == 0 ? kRadius_mm : -kRadius_mm};
        const double theta = M_PI * row / n, phi = M_PI * (column % (2 * n)) / n;
        return std::array<float, 3>{
            kRadius_mm * static_cast<float>(std::sin(theta) * std::cos(phi)),
            kRadius_mm * static_cast<float>(std::sin(theta) * std::sin(phi)),
            kRadius_mm * static_cast<float>(std::cos(theta))};
    };
    std::string stl(84, '\0');
    uint32_t count = 0;
    const auto add = [&](const std::array<std::array<float, 3>, 3>& corners) {
        stl.append(12, '\0');  // no normal
        stl.append(reinterpret_cast<const char*>(corners.data()), sizeof corners);
        stl.append(2, '\0');
        ++count;
    };
    for (int row = 0; row < n; ++row) {
        for (int column = 0; column < 2 * n; ++column) {
            const auto a = corner(row, column), b = corner(row + 1, column),
                       c = corner(row + 1, column + 1), d = corner(row, column + 1);
            if (row < n - 1) add({a, b, c});
            if (row > 0) add({a, c, d});
        }
    }
    std::memcpy(stl.data() + 80, &count, sizeof count);
    return stl;
}

/// A world of that ball, and the program that prints it.
class FineBall : public ::testing::Test {
  protected:
    void SetUp() override {
        scratch_.write("ball.stl", fine_ball(400));
        scratch_.write("bumpy.fl", R"(
fablet Bumpy {
    @uniform { Material core, shell; }
    @Surface(@varying { SurfaceAttributes attr }) { return attr.n * (0.5 * noise(attr.p)); }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        float t = smoothstep(0, 1, -distance(attr.voxelCenter));
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
})");
        scratch_.write("w.fab.json", R"({"openfab": 1, "printer": "j750",
            "fablets": {"b": {"source": "bumpy.fl", "fablet": "Bumpy"}},
            "materials": {"w": {"key": "#ffffff"}, "k": {"key": "#000000"}},
            "meshes": {"m": {"file": "ball.stl", "unit": "mm"}},
            "objects": {"o": {"mesh": "m", "fablet": "b", "uniforms": {"core": "w", "shell": "k"}}},
            "build": [{"object": "o"}]})");
        const Outcome built = run({program("openflc"), "build", (scratch_ / "bumpy.fl").string(),
                                   "-o", (scratch_ / "print").string()});
        ASSERT_EQ(built.exit_code, 0) << built.err;
    }

    Outcome print(const std::string& memory, RunOptions options = {}) {
        options.folder = scratch_.path();
        return run({(scratch_ / "print").string(), "w.fab.json", "-o", "out.ofr", "--threads", "2",
                    "--memory", memory},
                   options);
    }

    const ScratchFolder scratch_;
};

TEST_F(FineBall, IsRefusedBeforeItsTreesTakeMoreThanIsAllowed) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "the budget that a sanitizer needs is enough for it, and the print takes long";
#endif
    const Outcome outcome = print(std::to_string(kMemoryMb) + "MB");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_THAT(outcome.err, Says(pipeline::messages::kSurfacesTake));
    EXPECT_LE(outcome.peak_rss_bytes, (kMemoryMb + kSlackMb) << 20);
}

/// During any phase: reading, checking, displacement bounds, trees, the first slab.
/// Its exit code says that it did not go on to the end, which takes minutes.
TEST_F(FineBall, ASignalEndsAnyPhaseSoon) {
    for (const int after_ms : {20, 100, 250, 500, 1000, 2000}) {
        SCOPED_TRACE(after_ms);
        RunOptions options;
        options.signal = SIGTERM;
        options.interrupt_when = [&](int elapsed_ms, const Outcome&) {
            return elapsed_ms >= after_ms;
        };
        const Outcome outcome = print("4GB", options);
        EXPECT_TRUE(outcome.exit_code == 130 || outcome.exit_code == 128 + SIGTERM)
            << outcome.exit_code << '\n'
            << outcome.err;
    }
}

/// Surfaces of many patches, which take long to print whole.
class SlowPrint : public ::testing::TestWithParam<std::array<const char*, 2>> {};

TEST_P(SlowPrint, ASignalKeepsWholeSlicesAndEndsItSoon) {
    const auto& [folder, world] = GetParam();
    const ScratchFolder scratch;
    std::filesystem::copy(source_dir() / "tests/scenes/crafted" / folder, scratch.path(),
                          std::filesystem::copy_options::recursive);
    const Outcome built = run({program("openflc"), "build", (scratch / "disp.fl").string(), "-o",
                               (scratch / "print").string()});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    for (const int after_ms : {500, 3000}) {
        SCOPED_TRACE(after_ms);
        RunOptions options;
        options.folder = scratch.path();
        options.signal = SIGTERM;
        options.interrupt_when = [&](int elapsed_ms, const Outcome&) {
            return elapsed_ms >= after_ms;
        };
        const Outcome outcome = run({(scratch / "print").string(), world, "-o", "out.ofr",
                                     "--threads", "2", "--memory", "300MB"},
                                    options);
        EXPECT_TRUE(outcome.exit_code == 130 || outcome.exit_code == 128 + SIGTERM)
            << outcome.exit_code << '\n'
            << outcome.err;
        if (!std::filesystem::exists(scratch / "out.ofr")) continue;
        const Outcome info = run({program("openfab"), "info", (scratch / "out.ofr").string()});
        EXPECT_EQ(info.exit_code, 0) << info.err;
        EXPECT_THAT(info.out, HasSubstr("no: "));
    }
}

/// A user is told early what makes the print slow.
TEST(CrowdedSurface, IsWarnedOf) {
    const ScratchFolder scratch;
    RunOptions options;
    options.environment = {{"OPENFAB_CACHE", (scratch / "cache").string()}};
    const auto print = [&](const std::string& folder, const std::string& world) {
        const std::filesystem::path file = source_dir() / "tests/scenes/crafted" / folder / world;
        return run({program("openfab"), "print", file.string(), "--dry-run"}, options);
    };
    const Outcome crowded = print("scrambled_displaced", "w.fab.json");
    EXPECT_EQ(crowded.exit_code, 0) << crowded.err;
    EXPECT_THAT(crowded.err, AllOf(HasSubstr("warning: `o` (number 0 of the build) may print many "
                                             "times as slowly"),
                                   Says(pipeline::messages::kLowerDisplacement, "1")));
    const Outcome other = print("long_box", "longbox.fab.json");
    EXPECT_EQ(other.exit_code, 0) << other.err;
    EXPECT_THAT(other.err, ::testing::Not(Says(pipeline::messages::kPrintsSlowly)));
}

INSTANTIATE_TEST_SUITE_P(All, SlowPrint,
                         ::testing::Values(std::array{"scrambled_displaced", "w.fab.json"},
                                           std::array{"long_box", "longbox.fab.json"}),
                         [](const auto& tested) { return std::string(tested.param[0]); });

}  // namespace
}  // namespace openfab::testing
