// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Executes README.md literally, in a folder that looks like a built clone: its code blocks in order
// in one shell, and every command of OpenFab in its text.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A fenced block, or a line of text between two of them.
struct Piece {
    bool block = false;
    std::string text;
};

std::vector<Piece> section_of_readme(const std::string& title) {
    const std::string all = read_file(source_dir() / "README.md");
    const size_t begin = all.find("## " + title + "\n");
    EXPECT_NE(begin, std::string::npos);
    const size_t end = all.find("\n## ", begin);
    std::vector<Piece> pieces;
    bool block = false;
    std::istringstream lines(all.substr(begin, end - begin));
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("```")) {
            block = !block;
            if (block) pieces.push_back({true, ""});
        } else if (block) {
            pieces.back().text += line + "\n";
        } else if (!line.empty()) {
            pieces.push_back({false, line});
        }
    }
    EXPECT_FALSE(block);
    return pieces;
}

/// Returns the text in backticks.
std::vector<std::string> quoted_in(const std::string& text) {
    static const std::regex kCode("`([^`]+)`");
    std::vector<std::string> out;
    for (std::sregex_iterator at(text.begin(), text.end(), kCode), end; at != end; ++at)
        out.push_back((*at)[1]);
    return out;
}

bool names_a_file(const std::string& text) {
    return text.ends_with(".fl") || text.ends_with(".fab.json");
}

/// Follows the text like a reader: a block is a file if the text before it starts with a file name,
/// else it is typed.
std::string script_of(const std::vector<Piece>& pieces, int* files, int* commands) {
    std::string script = "set -euo pipefail\n";
    std::string last_text;
    for (const Piece& piece : pieces) {
        if (!piece.block) {
            last_text = piece.text;
            for (const std::string& code : quoted_in(piece.text)) {
                const bool ours = code.starts_with("openfab ") || code.starts_with("openflc ") ||
                                  code.starts_with("./");
                // `openfab import --repair` and the like name an option, not a command.
                if (!ours || code.find("openfab import --") == 0) continue;
                ++*commands;
                const bool endless =
                    code.find("--watch") != std::string::npos || code.starts_with("openfab view ");
                script += fmt::format("echo {} >&2\n{}{}\n", "'" + code + "'",
                                      endless ? "timeout --signal=INT 8 " : "", code);
                // It ends on request, after the print.
                if (endless) script.replace(script.size() - 1, 1, " || test $? = 124\n");
            }
            continue;
        }
        const std::vector<std::string> names = quoted_in(last_text);
        const auto name = std::find_if(names.begin(), names.end(), names_a_file);
        if (name != names.end()) {
            ++*files;
            script += fmt::format("cat > {} << 'END_OF_FILE'\n{}END_OF_FILE\n", *name, piece.text);
        } else {
            script += piece.text;
        }
    }
    return script;
}

TEST(Readme, FiveMinutesWorkAsWritten) {
    int files = 0, commands = 0;
    const std::string script =
        script_of(section_of_readme("Your own part in five minutes"), &files, &commands);
    EXPECT_EQ(files, 2);
    EXPECT_GE(commands, 7);
    const ScratchFolder clone;
    fs::create_directories(clone / "build/release");
    fs::create_directory_symlink(OPENFAB_BIN_DIR, clone / "build/release/bin");
    // The user's own mesh.
    fs::create_directories(clone / "out/ball");
    clone.write("out/ball/robot.obj",
                "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    RunOptions options;
    options.folder = clone.path();
    options.environment = {{"OPENFAB_CACHE", (clone / "cache").string()},
                           {"PATH", "/usr/local/bin:/usr/bin:/bin"}};
    const Outcome outcome = run({"/bin/bash", "-c", script}, options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("slices are whole"));
    for (const char* made : {"slices/manifest.json", "ball.png", "ball.ofr", "ball-print",
                             "soft_toy/soft_toy.fab.json", "robot/robot.fab.json", "ball.3mf"})
        EXPECT_TRUE(fs::exists(clone / "out/ball" / made)) << made;
    EXPECT_EQ(read_ofr(clone / "out/ball/again.ofr").materials,
              (std::vector<std::string>{"white", "black"}));
}

}  // namespace
}  // namespace openfab::testing
