// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// One world gives one set of bytes for any threads, memory, schedule, instruction set, culling and
// split of the slices.

#include <fmt/format.h>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

const std::vector<std::string> kDraft{"--draft", "6"};

class Determinism : public PostcardScene {
  protected:
    static std::string print_bytes(std::vector<std::string> arguments) {
        const std::filesystem::path file = scratch() / fmt::format("print{}.ofr", count_++);
        arguments.insert(arguments.end(), kDraft.begin(), kDraft.end());
        arguments.insert(arguments.end(), {"-o", file.string()});
        const Outcome printed = print(arguments);
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        return read_file(file);
    }
    static const std::string& reference() {
        static const std::string bytes = print_bytes({"--threads", "1"});
        return bytes;
    }

  private:
    static int count_;
};

int Determinism::count_ = 0;

TEST_F(Determinism, SameBytesForAnyWayOfRunning) {
    ASSERT_GT(reference().size(), 10'000u);
    const std::vector<std::vector<std::string>> ways{
        {"--threads", "2"},
#ifndef OPENFAB_SANITIZED
        {"--threads", "1", "--memory", "300MB"},
        {"--threads", "2", "--memory", "300MB"},
        {"--threads", "2", "--no-cull"},
        {"--isa", "sse41"},
        {"--isa", "avx2", "--threads", "2", "--memory", "600MB"},
#endif
        {"--groups-in-flight", "1"},
        {"--groups-in-flight", "5", "--threads", "2"},
    };
    for (const std::vector<std::string>& way : ways) {
        EXPECT_TRUE(print_bytes(way) == reference()) << fmt::format("{}", fmt::join(way, " "));
    }
}

// The budget in the error message suffices, with the smallest caches.
TEST_F(Determinism, TheLeastMemoryGivesTheSameBytes) {
#ifdef OPENFAB_SANITIZED
    GTEST_SKIP() << "a sanitizer's memory counts in the budget, and changes from run to run";
#endif
    // Previews count towards the budget.
    const std::string preview = (scratch() / "least.png").string();
    for (const std::string& threads : {std::string("1"), std::string("2")}) {
        std::vector<std::string> arguments{"--threads", threads, "--memory",
                                           "20MB",      "-o",    (scratch() / "none.ofr").string(),
                                           "--preview", preview};
        arguments.insert(arguments.end(), kDraft.begin(), kDraft.end());
        const std::string least = fmt::format("{}MB", least_memory_mb(print(arguments)));
        EXPECT_TRUE(print_bytes({"--threads", threads, "--memory", least, "--preview", preview}) ==
                    reference())
            << least;
    }
}

TEST_F(Determinism, ADifferentSeedGivesOtherBytes) {
    EXPECT_FALSE(print_bytes({"--seed", "7"}) == reference());
}

TEST_F(Determinism, AnotherScheduleGivesTheSameBytes) {
    std::vector<std::string> argv{print_program("postcard_other_schedule").string(),
                                  (gallery_postcard() / "postcard.fab.json").string(), "-o",
                                  (scratch() / "other.ofr").string()};
    argv.insert(argv.end(), kDraft.begin(), kDraft.end());
    const Outcome printed = run(argv, environment());
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_TRUE(read_file(scratch() / "other.ofr") == reference());
}

TEST_F(Determinism, OpenfabPrintGivesTheBinarysBytes) {
    std::vector<std::string> argv{program("openfab").string(), "print",
                                  (gallery_postcard() / "postcard.fab.json").string(), "-o",
                                  (scratch() / "front.ofr").string()};
    argv.insert(argv.end(), kDraft.begin(), kDraft.end());
    const Outcome printed = run(argv, environment());
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_TRUE(read_file(scratch() / "front.ofr") == reference());
}

TEST_F(Determinism, ToAPipeAsToAFile) {
    std::vector<std::string> arguments{"-o", "-", "--progress", "none"};
    arguments.insert(arguments.end(), kDraft.begin(), kDraft.end());
    const Outcome printed = print(arguments);
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_TRUE(printed.out == reference());
}

TEST_F(Determinism, SlicesInPartsPutTogetherAreTheWhole) {
    scratch().write("whole.ofr", reference());
    const Voxels whole = read_ofr(scratch() / "whole.ofr");
    ASSERT_GT(whole.slice_end, 9);
    std::vector<uint8_t> together;
    // Splits at slices that are not multiples of 8, so that some slabs are computed by two prints.
    const std::vector<int32_t> cuts{0, 3, 9, whole.slice_end};
    for (size_t part = 0; part + 1 < cuts.size(); ++part) {
        const std::filesystem::path file = scratch() / fmt::format("part{}.ofr", part);
        std::vector<std::string> arguments{"-o", file.string(), "--slices",
                                           fmt::format("{}:{}", cuts[part], cuts[part + 1])};
        arguments.insert(arguments.end(), kDraft.begin(), kDraft.end());
        const Outcome printed = print(arguments);
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        const Voxels voxels = read_ofr(file);
        EXPECT_EQ(voxels.slice_begin, cuts[part]);
        together.insert(together.end(), voxels.codes.begin(), voxels.codes.end());
    }
    EXPECT_TRUE(together == whole.codes);
}

}  // namespace
}  // namespace openfab::testing
