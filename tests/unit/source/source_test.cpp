// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/messages.h"
#include "compiler/source/source_manager.h"
#include "tests/support/says/says.h"

namespace openfab::source {
namespace {

TEST(SourceManager, LinesAndColumnsCountFromOne) {
    SourceManager s;
    const uint32_t file = s.add("a.fl", "ab\nc\r\n\nlast");
    EXPECT_NE(file, 0u);
    const auto at = [&](uint32_t offset) {
        const Location l = s.locate(file, offset);
        return std::make_pair(l.line, l.column);
    };
    EXPECT_EQ(at(0), std::make_pair(1u, 1u));
    EXPECT_EQ(at(2), std::make_pair(1u, 3u));  // the line end belongs to its line
    EXPECT_EQ(at(3), std::make_pair(2u, 1u));
    EXPECT_EQ(at(6), std::make_pair(3u, 1u));
    EXPECT_EQ(at(11), std::make_pair(4u, 5u));
    EXPECT_EQ(at(1000), std::make_pair(4u, 5u));
    EXPECT_EQ(s.line_text(file, 2), "c");
    EXPECT_EQ(s.line_text(file, 3), "");
    EXPECT_EQ(s.line_text(file, 4), "last");
    EXPECT_EQ(s.line_text(file, 5), "");
}

TEST(SourceManager, ColumnsAreCodePointsAndABadByteIsOne) {
    SourceManager s;
    const uint32_t file = s.add("a.fl", "\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80x\xFFy");
    EXPECT_EQ(s.locate(file, 9).column, 4u);   // é € 😀 x
    EXPECT_EQ(s.locate(file, 11).column, 6u);  // and one bad byte
    EXPECT_EQ(count_code_points("\xE2\x82"), 2u);
}

TEST(SourceManager, NowhereIsEmpty) {
    SourceManager s;
    EXPECT_EQ(s.text(0), "");
    EXPECT_EQ(s.name(3), "");
    EXPECT_EQ(s.locate(0, 5).line, 1u);
    EXPECT_EQ(s.line_text(0, 1), "");
    const uint32_t file = s.add("a.fl", "abc");
    EXPECT_EQ(s.text(Span{file, 1, 2}), "b");
    EXPECT_EQ(s.text(Span{file, 2, 1}), "");
}

TEST(SourceManager, LoadSaysWhyItFailed) {
    SourceManager s;
    std::string fault;
    EXPECT_FALSE(s.load("no/such/file.fl", &fault).has_value());
    EXPECT_EQ(fault, "no/such/file.fl: cannot be opened: No such file or directory");
    EXPECT_FALSE(s.load(std::filesystem::temp_directory_path(), &fault).has_value());
    EXPECT_THAT(fault,
                testing::Says(openfab::messages::kKindNotAFile, openfab::messages::kKindFolder));
    const std::filesystem::path path =
        std::filesystem::path(::testing::TempDir()) / "openfab_source_test.fl";
    std::ofstream(path, std::ios::binary) << "fablet A\n";
    const std::optional<uint32_t> file = s.load(path, &fault);
    ASSERT_TRUE(file.has_value());
    EXPECT_EQ(s.text(*file), "fablet A\n");
    EXPECT_EQ(s.name(*file), path.string());
    // An old line end: a comment must not take the rest of the file.
    std::ofstream(path, std::ios::binary) << "// one\rfablet A\r";
    EXPECT_EQ(s.text(s.load(path, &fault).value_or(0)), "// one\nfablet A\r");
    std::ofstream(path, std::ios::binary) << std::string_view("\xFF\xFE/\0/\0", 6);
    EXPECT_FALSE(s.load(path, &fault).has_value());
    EXPECT_EQ(fault, path.string() + ": " + fmt::format(openfab::messages::kWideText, "UTF-16") +
                         "; " + openfab::messages::kWideTextHelp);
    std::filesystem::resize_file(path, SourceManager::kMaxFileBytes + 1);
    EXPECT_FALSE(s.load(path, &fault).has_value());
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace openfab::source
