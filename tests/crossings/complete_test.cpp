// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The table has a column for each command, format and option, and a row for each kind of mesh, or says why not.

#include <gtest/gtest.h>

#include <rapidjson/document.h>

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

#include "backends/formats/formats.h"
#include "tests/crossings/columns.h"
#include "tests/crossings/rows.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

/// What rows and columns show, and what is elsewhere.
std::set<std::string> known_words() {
    std::set<std::string> out;
    for (const Column& column : columns())
        out.insert(column.shows.begin(), column.shows.end());
    for (const Kind& kind : kinds()) {
        out.insert(kind.source);
        out.insert(kind.options.begin(), kind.options.end());
    }
    for (const Elsewhere& row : elsewhere())
        out.insert(row.name);
    return out;
}

/// The subcommands of a help.
std::vector<std::string> commands_of(const std::vector<std::string>& words) {
    std::istringstream help(run(words).out);
    std::vector<std::string> out;
    bool in = false;
    for (std::string line; std::getline(help, line);) {
        if (!line.starts_with("  ")) {
            in = line == "Subcommands:";
        } else if (in && line.size() > 2 && line[2] != ' ') {
            out.push_back(line.substr(2, line.find(' ', 2) - 2));
        }
    }
    return out;
}

TEST(CrossingsComplete, EveryCommandFormatAndOptionHasAColumn) {
    const std::set<std::string> known = known_words();
    const std::string openfab = program("openfab").string();
    std::vector<std::string> words = commands_of({openfab, "--help"});
    EXPECT_GT(words.size(), 15U);
    const std::vector<std::string> mechanics = commands_of({openfab, "mechanics", "--help"});
    EXPECT_GT(mechanics.size(), 3U);
    for (const std::string& command : mechanics)
        words.push_back("mechanics " + command);
    for (const backends::Format* format : backends::formats())
        words.emplace_back(format->name);
    const std::string help = run({openfab, "print", "--help"}).out;
    const std::regex option("\n  (-[a-z],)?(--[a-z-]+)");
    for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at)
        words.push_back((*at)[2]);
    EXPECT_GT(words.size(), 60U);
    for (const std::string& word : words)
        EXPECT_EQ(known.count(word), 1U)
            << word << " has no column, and elsewhere.cpp does not say why";
}

TEST(CrossingsComplete, EveryKindOfMeshHasARow) {
    rapidjson::Document schema;
    schema.Parse(read_file(source_dir() / "world/fab_world.schema.json").c_str());
    ASSERT_FALSE(schema.HasParseError());
    const std::set<std::string> known = known_words();
    const auto& choices = schema["$defs"]["mesh"]["oneOf"];
    EXPECT_GT(choices.Size(), 10U);
    for (const auto& choice : choices.GetArray()) {
        const std::string word = choice["required"][0].GetString();
        EXPECT_EQ(known.count(word), 1U)
            << word << " has no row, and elsewhere.cpp does not say why";
    }
    for (const SolidKind solid :
         {SolidKind::kGrow, SolidKind::kShape, SolidKind::kBeams, SolidKind::kMesh}) {
        EXPECT_TRUE(std::any_of(kinds().begin(), kinds().end(),
                                [&](const Kind& kind) { return kind.solid == solid; }));
    }
}

}  // namespace
}  // namespace openfab::testing
