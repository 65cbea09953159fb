// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/run_main.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <system_error>

#include "base/messages.h"
#include "tests/support/says/says.h"

namespace openfab {
namespace {

int outcome_of(int (*program)(int, char**), std::string* message) {
    ::testing::internal::CaptureStderr();
    const int code = run_main(program, 0, nullptr);
    *message = ::testing::internal::GetCapturedStderr();
    return code;
}

TEST(RunMain, ExceptionsOfLibrariesBecomeMessages) {
    std::string message;
    EXPECT_EQ(outcome_of([](int, char**) { return 7; }, &message), 7);
    EXPECT_EQ(message, "");
    EXPECT_EQ(outcome_of([](int, char**) -> int { throw std::bad_alloc(); }, &message), 3);
    EXPECT_EQ(message, fmt::format("error: {}\n", messages::kMemoryRanOut));
    EXPECT_EQ(
        outcome_of(
            [](int, char**) -> int { throw std::system_error(EAGAIN, std::generic_category()); },
            &message),
        3);
    EXPECT_THAT(message, testing::Says(messages::kSystemRefuses));
    EXPECT_THAT(message, testing::Says(messages::kAllowMoreProcesses));
    EXPECT_EQ(outcome_of([](int, char**) -> int { throw std::logic_error("why"); }, &message), 4);
    EXPECT_EQ(message, "error: internal error: why\n");
    EXPECT_EQ(outcome_of([](int, char**) -> int { throw 1; }, &message), 4);
}

// An error that nobody can read keeps its exit code.
TEST(RunMain, AnErrorThatCannotBeWrittenIsNoCrash) {
    EXPECT_EXIT(
        {
            ::close(STDERR_FILENO);
            std::exit(run_main(
                [](int, char**) -> int {
                    throw std::system_error(EAGAIN, std::generic_category());
                },
                0, nullptr));
        },
        ::testing::ExitedWithCode(3), "");
}

}  // namespace
}  // namespace openfab
