// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Inputs that were made to break in, to take more memory than was allowed, or never to end. The
// programs print them or refuse them with a message, within the budget and soon.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

#ifdef OPENFAB_SANITIZED  // what a sanitizer keeps counts
constexpr int64_t kMemoryMb = 3000;
#else
constexpr int64_t kMemoryMb = 300;
#endif
constexpr int64_t kSlackMb = 50;
/// Of a processor that other tests share.
constexpr double kMostSeconds = 20;
/// Of the compiler, which takes no budget.
constexpr int64_t kCompilerMb = 1500;

struct Crafted {
    const char* name;
    const char* folder;                  ///< of tests/scenes/crafted
    const char* program;                 ///< openfab or openflc
    std::vector<std::string> arguments;  ///< the memory budget is added for `print`
    /// What the message must hold where the input is refused; null where it must be printed, empty
    /// where either is right.
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
        {"Laughs", "packages", "openfab", {"import", "laughs.3mf", "-o", "out"}, "a document type"},
        {"DoublesBeyondFloats", "packages", "openfab", {"info", "huge_doubles.ply"}, ""},
        {"MaterialsByIndex",
         "compile_bombs",
         "openflc",
         {"build", "materials_256.fl", "-o", "out"},
         ""},
        {"FourThousandTextures",
         "compile_bombs",
         "openflc",
         {"build", "textures_4096.fl", "-o", "out"},
         ""},
        {"NestedUnrolling",
         "compile_bombs",
         "openflc",
         {"build", "unroll_nest.fl", "-o", "out"},
         ""},
        {"TextureByIndex",
         "textures_by_index",
         "openflc",
         {"build", "min.fl", "-o", "out"},
         nullptr},
        {"TextureByIndexAndNoise",
         "textures_by_index",
         "openflc",
         {"build", "bad1.fl", "-o", "out"},
         ""},
    };
    return inputs;
}

class CraftedInput : public ::testing::TestWithParam<Crafted> {};

TEST_P(CraftedInput, IsPrintedOrRefusedWithinTheBudget) {
    const Crafted& crafted = GetParam();
    const ScratchFolder scratch;
    std::filesystem::copy(
        std::filesystem::path(OPENFAB_SOURCE_DIR) / "tests/scenes/crafted" / crafted.folder,
        scratch.path(), std::filesystem::copy_options::recursive);
    std::vector<std::string> argv{
        (std::filesystem::path(OPENFAB_BIN_DIR) / crafted.program).string()};
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
    EXPECT_LE(outcome.processor_seconds, kMostSeconds) << outcome.err;
#endif
}

INSTANTIATE_TEST_SUITE_P(All, CraftedInput, ::testing::ValuesIn(crafted_inputs()),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace openfab::testing
