// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Programs that the viewer and mechanics start, and what is said where that fails.

#include "client/child.h"

#include <gmock/gmock.h>

#include "base/clock.h"
#include "client/messages.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::client {
namespace {

using testing::ScratchFolder;
using testing::SmallDisk;

TEST(Child, WordsAndCodeAreKept) {
    const ScratchFolder folder;
    auto child = Child::start({"/bin/sh", "-c", "echo out; echo err >&2; exit 7"}, folder / "out",
                              folder / "err");
    ASSERT_TRUE(child) << child.error().text();
    EXPECT_EQ((*child)->wait(), 7);
    EXPECT_EQ(testing::read_file(folder / "out"), "out\n");
    EXPECT_EQ(testing::read_file(folder / "err"), "err\n");
    EXPECT_FALSE(Child::start({folder / "none"}, folder / "out", folder / "err"));
}

/// A program that finds the disk full could not say so.
TEST(Child, IsNotStartedWhereItsWordsFindNoRoom) {
    std::string why_not;
    const std::unique_ptr<SmallDisk> disk = SmallDisk::create(100'000, &why_not);
    if (disk == nullptr) GTEST_SKIP() << why_not;
    disk->fill("other", 0);
    const auto child =
        Child::start({"/bin/sh", "-c", "exit 3"}, disk->path("out"), disk->path("err"));
    ASSERT_FALSE(child);
    EXPECT_EQ(child.error().code, ErrorCode::kOutside);
    EXPECT_THAT(child.error().text(), testing::Says(messages::kNoRoomForWords, disk->path("err"),
                                                    "No space left on device"));
}

TEST(Child, ProgramsGetWhatIsLeftOfTheMemory) {
    EXPECT_TRUE(memory_words().empty());
    set_memory_of_programs(1'000'000'000);
    const std::vector<std::string> words = memory_words();
    set_memory_of_programs(0);
    ASSERT_EQ(words.size(), 1u);
    ASSERT_TRUE(words[0].starts_with("--memory=") && words[0].ends_with("B"));
    const int64_t left = std::stoll(words[0].substr(9));
    EXPECT_LT(left, 1'000'000'000);
    EXPECT_GT(left, 1'000'000'000 - peak_resident_bytes() - 1);
}

}  // namespace
}  // namespace openfab::client
