// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a search has found is found again, and only by the search that it is of.

#include "tools/tuner/journal.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/process/process.h"

namespace openfab::tuner {
namespace {

using openfab::testing::read_file;
using openfab::testing::ScratchFolder;

TEST(Journal, FindsWhatItWasTold) {
    const ScratchFolder folder;
    {
        Result<Journal> journal = Journal::open(folder / "j", "a world");
        ASSERT_TRUE(journal) << journal.error().text();
        EXPECT_EQ(journal->size(), 0u);
        ASSERT_TRUE(journal->add("lines\n", {{"columns = 32"}, "", {0.5}}));
        ASSERT_TRUE(journal->add("lines\n", {{"columns = 32"}, "", {0.5, 0.75}, true}));
        ASSERT_TRUE(journal->add("others\n", {{"a", "b \"c\""}, "it does not fit", {}}));
    }
    const Result<Journal> again = Journal::open(folder / "j", "a world");
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->size(), 2u);
    const Trial* known = again->find("lines\n");
    ASSERT_NE(known, nullptr);
    EXPECT_EQ(known->changes, (std::vector<std::string>{"columns = 32"}));
    EXPECT_EQ(known->ratios, (std::vector<double>{0.5, 0.75}));
    EXPECT_EQ(known->refused, "");
    EXPECT_TRUE(known->won);
    EXPECT_FALSE(again->find("others\n")->won);
    ASSERT_NE(again->find("others\n"), nullptr);
    EXPECT_EQ(again->find("others\n")->refused, "it does not fit");
    EXPECT_EQ(again->find("others\n")->changes, (std::vector<std::string>{"a", "b \"c\""}));
    EXPECT_EQ(again->find("more\n"), nullptr);
}

TEST(Journal, LeavesOutALineThatWasCutOff) {
    const ScratchFolder folder;
    {
        Result<Journal> journal = Journal::open(folder / "j", "a world");
        ASSERT_TRUE(journal);
        ASSERT_TRUE(journal->add("lines\n", {{}, "", {0.5}}));
    }
    const std::string whole = read_file(folder / "j");
    std::ofstream(folder / "j", std::ios::app) << R"({"schedule": "0123)";
    {
        Result<Journal> journal = Journal::open(folder / "j", "a world");
        ASSERT_TRUE(journal) << journal.error().text();
        EXPECT_EQ(journal->size(), 1u);
        EXPECT_EQ(read_file(folder / "j"), whole);
        ASSERT_TRUE(journal->add("others\n", {{}, "", {0.25}}));
    }
    const Result<Journal> again = Journal::open(folder / "j", "a world");
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->size(), 2u);
}

TEST(Journal, RefusesWhatIsNotItsOwn) {
    const ScratchFolder folder;
    ASSERT_TRUE(Journal::open(folder / "j", "a world"));
    folder.write("text", "Dear diary,\n");
    folder.write("empty", "");
    folder.write("hash", "{\"tunes\":\"a world\"}\n{\"schedule\":\"x\",\"ratios\":[1]}\n");
    const Result<Journal> other = Journal::open(folder / "j", "another world");
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().help.find("--journal"), std::string::npos);
    EXPECT_FALSE(Journal::open(folder / "text", "a world"));
    EXPECT_FALSE(Journal::open(folder / "empty", "a world"));
    EXPECT_FALSE(Journal::open(folder / "hash", "a world"));
    EXPECT_EQ(Journal::open(folder / "no" / "j", "a world").error().code, ErrorCode::kOutside);
}

}  // namespace
}  // namespace openfab::tuner
