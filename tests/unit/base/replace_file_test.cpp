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

}  // namespace
}  // namespace openfab::testing
