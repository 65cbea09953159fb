// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/replace_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "base/messages.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

TEST(ReplaceFile, OnlyAFileMayBeReplacedByOne) {
    const ScratchFolder folder;
    folder.write("file", "x");
    EXPECT_TRUE(check_replaceable(folder / "file"));
    EXPECT_TRUE(check_replaceable(folder / "not there"));
    const std::string pipe = folder / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    for (const auto& [place, what] : {std::pair{pipe, messages::kKindPipe},
                                      {folder.path().string(), messages::kKindFolder},
                                      {std::string("/dev/null"), messages::kKindDevice}}) {
        const Result<void> checked = check_replaceable(place);
        ASSERT_FALSE(checked) << place;
        EXPECT_EQ(checked.error().code, ErrorCode::kUserInput);
        EXPECT_THAT(checked.error().text(), Says(messages::kOutputIsNoFile, place, what));
    }
}

TEST(CopyFile, IsWholeOrNotThere) {
    const ScratchFolder folder;
    const std::string text(300'000, 'x');
    folder.write("file", text);
    ASSERT_EQ(::chmod((folder / "file").c_str(), 0640), 0);
    ASSERT_TRUE(copy_at_once(folder / "file", folder / "copy"));
    EXPECT_EQ(read_file(folder / "copy"), text);
    struct stat made {};
    ASSERT_EQ(::stat((folder / "copy").c_str(), &made), 0);
    EXPECT_EQ(made.st_mode & 0777, 0640u);
    EXPECT_FALSE(copy_at_once(folder / "not there", folder / "copy"));
    EXPECT_EQ(read_file(folder / "copy"), text);

    std::string why_not;
    const std::unique_ptr<SmallDisk> disk = SmallDisk::create(200'000, &why_not);
    if (disk == nullptr) GTEST_SKIP() << why_not;
    const Result<void> full = copy_at_once(folder / "file", disk->path("copy"));
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().code, ErrorCode::kOutside);
    EXPECT_THAT(full.error().text(), Says(messages::kCannotCopy, (folder / "file").string(),
                                          disk->path("copy"), "No space left on device"));
    const std::filesystem::path there(disk->path("copy"));
    EXPECT_TRUE(std::filesystem::is_empty(there.parent_path()));
}

}  // namespace
}  // namespace openfab::testing
