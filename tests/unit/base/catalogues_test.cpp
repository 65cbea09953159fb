// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What all catalogues of messages have in common: who is asked for an option is shown the whole of what to write.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/places/places.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;

/// The rows of a catalogue, each with the file's name.
std::vector<std::string> rows_of(const fs::path& file) {
    std::vector<std::string> out;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("OPENFAB_MESSAGE("))
            out.push_back(fs::relative(file, testing::source_dir()).string() + ": " + line);
    }
    return out;
}

std::vector<std::string> all_rows() {
    std::vector<std::string> out;
    for (const char* folder : {"backends", "client", "compiler", "core", "mechanics", "program",
                               "runtime", "tools", "world"}) {
        for (const auto& entry : fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (!entry.path().filename().string().ends_with("messages.h")) continue;
            for (std::string& row : rows_of(entry.path()))
                out.push_back(std::move(row));
        }
    }
    return out;
}

/// Options that stand alone; all others take a value.
const std::set<std::string> kFlags{
    "allow-programs", "as-built", "check",   "composite", "converge", "dry-run",
    "estimate",       "flip-x",   "help",    "json",      "list",     "loose",
    "recentre",       "relative", "reprint", "resume",    "thin",     "watch",
    "dicom",          "hdf5",     "step",    "vdb",       "vrml",     "one-material"};

/// Returns the options that a text asks for, or says something of, without a value.
std::vector<std::string> bare_options(const std::string& text) {
    static const std::regex asked(
        "(?:\\b(?:raise|lower|more|larger|smaller|finer|coarser|higher|another|longer|with|by|give|"
        "write|set|use|choose|name|pass)(?: an?| it| the)? |\\()`(?:openfab [a-z]+ )?--([a-z-]+)`");
    static const std::regex sets("`--([a-z-]+)` (?:sets|set|changes|chooses|tells|maps|repeats) ");
    std::vector<std::string> out;
    for (const std::regex* rule : {&asked, &sets}) {
        for (std::sregex_iterator at(text.begin(), text.end(), *rule), end; at != end; ++at)
            if (!kFlags.contains((*at)[1])) out.push_back((*at)[1]);
    }
    return out;
}

TEST(Catalogues, WhoIsAskedForAnOptionIsShownItsValue) {
    const std::vector<std::string> rows = all_rows();
    EXPECT_GT(rows.size(), 2000U);
    for (const std::string& row : rows) {
        for (const std::string& option : bare_options(row))
            ADD_FAILURE() << row << "\nshows no value of --" << option
                          << ", such as `--memory 4GB`";
    }
    EXPECT_EQ(bare_options("too large; raise `--memory`, or use `--draft 2`"),
              std::vector<std::string>{"memory"});
    EXPECT_EQ(bare_options("`--voxel` sets another"), std::vector<std::string>{"voxel"});
    EXPECT_TRUE(bare_options("print again with `--resume`").empty());
}

}  // namespace
}  // namespace openfab
