// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints in parts, by `--slices`, which `openfab merge` makes one: the bytes must be those of one run.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>

#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Merge : public ::testing::Test {
  protected:
    Merge() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        scratch_.write("w.fab.json", SimpleWorld{"Skin", R"({"sphere": 10})"}.text());
        scratch_.write("other.fab.json", SimpleWorld{"Skin", R"({"sphere": 10.1})"}.text());
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    void print(const std::string& output, const std::string& slices = "",
               const std::string& world = "w.fab.json") {
        std::vector<std::string> argv{test_program("openfab_test_print_4"),
                                      path(world),
                                      "--voxel",
                                      "0.25mm",
                                      "-o",
                                      path(output)};
        if (output.find(".ofr") == std::string::npos) argv.insert(argv.end(), {"--format", "png"});
        if (!slices.empty()) argv.insert(argv.end(), {"--slices", slices});
        const Outcome outcome = run(argv);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    Outcome merge(const std::vector<std::string>& files, const std::string& output) {
        std::vector<std::string> argv{program("openfab"), "merge"};
        for (const std::string& file : files)
            argv.push_back(file.starts_with("--") ? file : path(file));
        argv.insert(argv.end(), {"-o", path(output)});
        return run(argv);
    }
    /// Expects a refusal that says so, and that nothing is written.
    void expect_refused(const std::vector<std::string>& files, const std::string& message) {
        const Outcome outcome = merge(files, "refused.ofr");
        EXPECT_EQ(outcome.exit_code, 1);
        EXPECT_THAT(outcome.err, testing::Says(message));
        EXPECT_FALSE(fs::exists(path("refused.ofr")));
    }
    std::map<std::string, std::string> files_of(const std::string& folder) {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::directory_iterator(path(folder)))
            files[entry.path().filename().string()] = read_file(entry.path());
        return files;
    }

    ScratchFolder scratch_;
};

TEST_F(Merge, PartsInAnyOrderBecomeTheBytesOfOneRun) {
    print("whole.ofr");
    print("whole");
    // The first and the last part have slices without a voxel, and no part starts with a slab.
    print("a.ofr", "0:3");
    print("b.ofr", "3:20");
    print("c.ofr", "20:21");
    print("d.ofr", "21:40");
    Outcome outcome = merge({"c.ofr", "a.ofr", "d.ofr", "b.ofr"}, "merged.ofr");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(read_file(path("merged.ofr")), read_file(path("whole.ofr")));
    outcome = merge({"a.ofr", "b.ofr", "c.ofr", "d.ofr"}, "merged");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(files_of("merged"), files_of("whole"));

    // Less than the whole is a print of these slices.
    print("middle.ofr", "3:21");
    outcome = merge({"b.ofr", "c.ofr"}, "merged_middle.ofr");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(read_file(path("merged_middle.ofr")), read_file(path("middle.ofr")));
}

/// What an array of jobs leaves of which the first or the last failed.
TEST_F(Merge, WhatIsMissingAtTheEndsIsNamed) {
    print("a.ofr", "0:3");
    print("b.ofr", "3:20");
    print("c.ofr", "20:40");
    print("whole.ofr");
    const auto told = [](const std::string& slices, const std::string& ranges) {
        return fmt::format(tools::messages::kPartsMissing, 40, slices, ranges);
    };
    const std::string top = fmt::format(tools::messages::kSlicesTo, 20, 39);
    const std::string bottom = fmt::format(tools::messages::kSlicesTo, 0, 2);
    EXPECT_THAT(merge({"a.ofr", "b.ofr"}, "low.ofr").err, HasSubstr(told(top, "`--slices 20:40`")));
    EXPECT_THAT(merge({"b.ofr", "c.ofr"}, "high.ofr").err,
                HasSubstr(told(bottom, "`--slices 0:3`")));
    EXPECT_THAT(merge({"b.ofr"}, "middle").err,
                HasSubstr(told(bottom + " and " + top, "`--slices 0:3` and `--slices 20:40`")));
    EXPECT_EQ(merge({"low.ofr", "c.ofr"}, "all.ofr").err, "");
    EXPECT_EQ(read_file(path("all.ofr")), read_file(path("whole.ofr")));

    const std::string low = run({program("openfab"), "info", path("low.ofr")}).out;
    EXPECT_THAT(low, HasSubstr(fmt::format(tools::messages::kSlicesOfWhole, 0, 19, 40)));
    EXPECT_THAT(low, HasSubstr(fmt::format(tools::messages::kCompletePart, 20)));
    const std::string middle = run({program("openfab"), "info", path("middle")}).out;
    EXPECT_THAT(middle, HasSubstr("slices_of_whole  40\nslices_elsewhere 0:3 20:40\n"));
    const std::string all = run({program("openfab"), "info", path("all.ofr")}).out;
    EXPECT_THAT(all, HasSubstr("slices     0 to 39\n"));
    EXPECT_THAT(all, HasSubstr("complete   yes\n"));

    expect_refused({"--whole", "a.ofr", "b.ofr"}, told(top, "`--slices 20:40`"));
    EXPECT_EQ(merge({"--whole", "a.ofr", "b.ofr", "c.ofr"}, "all2.ofr").exit_code, 0);
}

/// Formats without a manifest tell it in the file, and `info` reads that.
TEST_F(Merge, WhatIsMissingIsInFilesOfEveryFormat) {
    print("a.ofr", "0:3");
    print("b.ofr", "3:20");
    print("c.ofr", "20:40");
    const std::string part = fmt::format(tools::messages::kAreSlicesOfWhole, 3, 19, 40);
    for (const std::string name : {"m.gcvf", "m.3mf", "m.stl"}) {
        for (const bool whole : {false, true}) {
            SCOPED_TRACE(name);
            const Outcome merged =
                whole ? merge({"a.ofr", "b.ofr", "c.ofr"}, name) : merge({"b.ofr"}, name);
            ASSERT_EQ(merged.exit_code, 0) << merged.err;
            EXPECT_EQ(testing::says(merged.err, tools::messages::kPartsMissing), !whole);
            std::string file = name;
            for (const auto& entry : fs::directory_iterator(path(""))) {
                const std::string one = entry.path().filename().string();
                if (name == "m.stl" && one.starts_with("m_")) file = one;
            }
            const Outcome told = run({program("openfab"), "info", path(file)});
            EXPECT_EQ(told.exit_code, 0) << told.err;
            EXPECT_EQ(told.out.find(part) != std::string::npos, !whole) << told.out;
            EXPECT_EQ(testing::says(told.out, fmt::format(tools::messages::kCompletePart, 23)),
                      name == "m.gcvf" && !whole);
            const Outcome verified = run({program("openfab"), "verify", path(file)});
            EXPECT_EQ(verified.exit_code, 0) << verified.err;
        }
    }
}

/// Each of N machines asks for its part, whatever the number of slices is.
TEST_F(Merge, PartsOfANumberAreTheWhole) {
    print("whole.ofr");
    std::vector<std::string> files{"--whole"};
    for (int i = 1; i <= 3; ++i) {
        files.push_back(fmt::format("{}.ofr", i));
        ASSERT_EQ(run({test_program("openfab_test_print_4"), path("w.fab.json"), "--voxel",
                       "0.25mm", "-o", path(files.back()), "--part", fmt::format("{}/3", i)})
                      .exit_code,
                  0);
        const std::string told = run({program("openfab"), "info", path(files.back())}).out;
        // Five slabs: 1, 2 and 2 of them.
        const char* const expected[] = {"slices     0 to 7 of 40", "slices     8 to 23 of 40",
                                        "slices     24 to 39 of 40"};
        EXPECT_THAT(told, HasSubstr(expected[i - 1]));
    }
    ASSERT_EQ(merge(files, "merged.ofr").exit_code, 0);
    EXPECT_EQ(read_file(path("merged.ofr")), read_file(path("whole.ofr")));
    const auto refused = [&](const std::vector<std::string>& more, const std::string& message) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"),
                                      path("w.fab.json"),
                                      "--voxel",
                                      "0.25mm",
                                      "-o",
                                      path("no.ofr")};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome outcome = run(argv);
        EXPECT_NE(outcome.exit_code, 0);
        EXPECT_THAT(outcome.err, Says(message));
    };
    refused({"--part", "2/6"}, fmt::format(pipeline::messages::kMorePartsThanSlabs, 2, 6, 5));
    refused({"--part", "0/3"}, program::messages::kNotAPart);
    refused({"--part", "4/3"}, program::messages::kNotAPart);
    refused({"--part", "3"}, program::messages::kNotAPart);
    refused({"--part", "1/3", "--slices", "0:8"}, program::messages::kPartAndRange);
    refused({"--slices", "40:"}, fmt::format(pipeline::messages::kSlicesOutside, 40, "", 40));
    refused({"--slices", ":"}, program::messages::kNotARange);
}

/// The last of equal ranges ends with the print.
TEST_F(Merge, RangesOfEqualLengthAreTheWhole) {
    print("whole.ofr");
    std::vector<std::string> files{"--whole"};
    for (int i = 0; i < 3; ++i) {
        files.push_back(fmt::format("{}.ofr", i));
        const Outcome outcome =
            run({test_program("openfab_test_print_4"), path("w.fab.json"), "--voxel", "0.25mm",
                 "-o", path(files.back()), "--slices", fmt::format("{}:{}", 16 * i, 16 * i + 16)});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const auto past = Says(pipeline::messages::kSlicesPastEnd, 32, 48, 40);
        if (i == 2) {
            EXPECT_THAT(outcome.err, past);
        } else {
            EXPECT_THAT(outcome.err, ::testing::Not(past));
        }
    }
    ASSERT_EQ(merge(files, "merged.ofr").exit_code, 0);
    EXPECT_EQ(read_file(path("merged.ofr")), read_file(path("whole.ofr")));
}

TEST_F(Merge, WhatIsNotOnePrintIsRefused) {
    print("a.ofr", "0:10");
    print("b.ofr", "8:20");
    print("c.ofr", "20:24");
    print("d.ofr", "25:40");
    print("other.ofr", "20:30", "other.fab.json");
    expect_refused({"a.ofr", "b.ofr"},
                   fmt::format(tools::messages::kBothHaveSlices, "{}", "{}b.ofr",
                               fmt::format(tools::messages::kSlicesTo, 8, 9)));
    expect_refused({"b.ofr", "d.ofr", "c.ofr"},
                   fmt::format(tools::messages::kNoFileHasSlices,
                               fmt::format(tools::messages::kOneSlice, 24), 24, 25));
    expect_refused({"b.ofr", "other.ofr"}, tools::messages::kNotPartsOfOnePrint);
    expect_refused({"b.ofr", "b.ofr"},
                   fmt::format(tools::messages::kBothHaveSlices, "{}", "{}b.ofr",
                               fmt::format(tools::messages::kSlicesTo, 8, 19)));
    // Cut in its last slice: what an interrupted print leaves.
    const std::string bytes = read_file(path("c.ofr"));
    scratch_.write("c.ofr", bytes.substr(0, bytes.size() / 2));
    expect_refused({"b.ofr", "c.ofr"}, tools::messages::kCompleteItWithResume);
    const Outcome onto = merge({"b.ofr", "a.ofr"}, "b.ofr");
    EXPECT_EQ(onto.exit_code, 1);
}

TEST_F(Merge, ADamagedSliceLeavesTheOthersBeforeIt) {
    print("a.ofr", "0:16");
    print("b.ofr", "16:40");
    std::string bytes = read_file(path("b.ofr"));
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    scratch_.write("b.ofr", bytes);
    const Outcome outcome = merge({"a.ofr", "b.ofr"}, "merged.ofr");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("b.ofr: slice "));
    EXPECT_EQ(run({program("openfab"), "verify", path("merged.ofr")}).exit_code, 1);
    const Outcome info = run({program("openfab"), "info", path("merged.ofr")});
    EXPECT_THAT(info.out, HasSubstr(" of 40"));
}

}  // namespace
}  // namespace openfab::testing
