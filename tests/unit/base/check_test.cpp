// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/check.h"

#include <gtest/gtest.h>

#include "base/result.h"

namespace openfab {
namespace {

TEST(CheckDeathTest, SaysWhereAndWhatAndTheValues) {
    const int two = 2;
    EXPECT_DEATH(OPENFAB_CHECK(two == 3),
                 "tests/unit/base/check_test.cpp:[0-9]+: internal error: `two == 3` does not hold");
    EXPECT_DEATH(OPENFAB_CHECK_LT(two + 1, 3), "`two \\+ 1 < 3` does not hold: 3 and 3");
    EXPECT_DEATH(OPENFAB_CHECK_EQ(two, -1), "`two == -1` does not hold: 2 and -1");
    EXPECT_DEATH(OPENFAB_CHECK_GE(0.25, 0.5), "0.25 and 0.5");
}

TEST(CheckDeathTest, AResultWithoutItsValue) {
    const Result<int> none = user_error("no");
    EXPECT_DEATH((void)none.value(), "has_value\\(\\)");
    const Result<void> good;
    EXPECT_DEATH((void)good.error(), "failed_");
}

TEST(Check, EvaluatesOnceAndLetsPassWhatHolds) {
    int calls = 0;
    OPENFAB_CHECK(++calls == 1);
    OPENFAB_CHECK_EQ(++calls, 2);
    OPENFAB_CHECK_LE(calls, 2);
    OPENFAB_CHECK_NE(calls, 1);
    OPENFAB_CHECK_GT(calls, 1);
    EXPECT_EQ(calls, 2);
}

// Without NDEBUG it is a check; with it, not even evaluated.
TEST(Check, DebugChecksCostNothingInAProduct) {
    int calls = 0;
    OPENFAB_DCHECK(++calls == 1);
#ifdef NDEBUG
    EXPECT_EQ(calls, 0);
#else
    EXPECT_EQ(calls, 1);
#endif
}

TEST(Error, TellsAllOfItInOneLine) {
    EXPECT_EQ(user_error("what").text(), "what");
    EXPECT_EQ(user_error("what", "help").text(), "what; help");
    EXPECT_EQ(error_at({"a:b", 3, 4}, "what", "help").text(), "a:b:3:4: what; help");
    EXPECT_EQ(error_at({"file", 0, 0}, "what").text(), "file: what");
    const Error outer = with_context(error_at({"f", 1, 2}, "what", "help"), "before: ");
    EXPECT_EQ(outer.message, "before: f:1:2: what");
    EXPECT_EQ(outer.help, "help");
    EXPECT_EQ(outer.code, ErrorCode::kUserInput);
    EXPECT_TRUE(outer.location.file.empty());
}

}  // namespace
}  // namespace openfab
