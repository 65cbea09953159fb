// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/progress.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <functional>
#include <string>

namespace openfab::program {
namespace {

using ::testing::HasSubstr;

/// Returns what `use` has progress write to a file.
std::string written(ProgressMode mode, const std::function<void(Progress*)>& use) {
    std::FILE* file = std::tmpfile();
    Progress progress(mode, file);
    use(&progress);
    progress.end();
    std::string text(static_cast<size_t>(std::ftell(file)), ' ');
    std::rewind(file);
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), file), text.size());
    std::fclose(file);
    return text;
}

/// Returns the progress of a print of 100 slices, one a second.
std::string lines_of(ProgressMode mode) {
    return written(mode, [](Progress* progress) {
        for (int i = 1; i <= 100; ++i)
            progress->update({i, 100, i * 1'000'000, 100'000'000, static_cast<double>(i)});
    });
}

TEST(Progress, WarningsAreShownInEveryMode) {
    const auto messages = [](ProgressMode mode) {
        return written(mode, [](Progress* progress) {
            progress->note("a \"note\"");
            progress->warn("a warning");
        });
    };
    EXPECT_EQ(messages(ProgressMode::kPlain), "note: a \"note\"\nwarning: a warning\n");
    EXPECT_EQ(messages(ProgressMode::kNone), "warning: a warning\n");
    EXPECT_EQ(messages(ProgressMode::kJson),
              "{\"event\": \"note\", \"text\": \"a \\\"note\\\"\"}\n"
              "{\"event\": \"warning\", \"text\": \"a warning\"}\n");
}

TEST(Progress, PlainLinesWhereThereIsNoTerminal) {
    for (ProgressMode mode : {ProgressMode::kAuto, ProgressMode::kPlain}) {
        const std::string text = lines_of(mode);
        EXPECT_EQ(text.find('\r'), std::string::npos);
        EXPECT_EQ(text.find('\x1b'), std::string::npos);
        EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 25);
        EXPECT_THAT(text, HasSubstr("slice 100 of 100  100 %  1.0 M voxels/s\n"));
    }
}

TEST(Progress, JsonLines) {
    const std::string text = lines_of(ProgressMode::kJson);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 100);
    EXPECT_THAT(text, HasSubstr("\"slices_done\": 50, \"slices_total\": 100"));
    EXPECT_THAT(text, HasSubstr("\"seconds_left\": 50.0"));
}

TEST(Progress, NothingWhereNoneIsWanted) {
    EXPECT_EQ(lines_of(ProgressMode::kNone), "");
}

TEST(Progress, Describe) {
    EXPECT_EQ(Progress::describe({12, 150, 12'000'000, 150'000'000, 2}),
              "slice 12 of 150  8 %  6.0 M voxels/s  23.0 s left");
    // The time before the first slice does not affect the estimate for the rest.
    const pipeline::ProgressEvent first{1, 150, 1'000'000, 150'000'000, 90};
    EXPECT_EQ(Progress::describe(first, first), "slice 1 of 150  1 %");
    EXPECT_EQ(Progress::describe({3, 150, 3'000'000, 150'000'000, 92}, first),
              "slice 3 of 150  2 %  1.0 M voxels/s  2 min 27 s left");
    const pipeline::ProgressEvent only{1, 1, 1'000'000, 1'000'000, 2};
    EXPECT_EQ(Progress::describe(only, only), "slice 1 of 1  100 %  0.5 M voxels/s");
}

}  // namespace
}  // namespace openfab::program
