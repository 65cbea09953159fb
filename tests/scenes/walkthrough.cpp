// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/scenes/walkthrough.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

namespace openfab::testing {

namespace {

/// A fenced block, or a line of text between two of them.
struct Piece {
    bool block = false;
    std::string text;
};

std::vector<Piece> pieces_of(const std::string& markdown) {
    std::vector<Piece> pieces;
    bool block = false;
    std::istringstream lines(markdown);
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

std::vector<std::string> matches(const std::string& text, const char* pattern) {
    const std::regex expression(pattern);
    std::vector<std::string> out;
    for (std::sregex_iterator at(text.begin(), text.end(), expression), end; at != end; ++at)
        out.push_back((*at)[1]);
    return out;
}

std::vector<std::string> quoted_in(const std::string& text) {
    return matches(text, "`([^`]+)`");
}

bool names_a_file(const std::string& text) {
    static const std::regex kFile(R"([^ ]+\.(fl|fab\.json|obj|ppm|sched|py|csv))");
    return std::regex_match(text, kFile);
}

bool is_command(const std::string& code) {
    // `openfab import --repair` and the like name an option, `openflc check` alone a command.
    static const std::regex kOurs(R"((openfab|openflc) [a-z]+ +(?!-)[^ ].*|\./.*)");
    return std::regex_match(code, kOurs);
}

}  // namespace

Walkthrough walkthrough_of(const std::string& markdown) {
    Walkthrough out{"set -euo pipefail\n"};
    std::string last_text;
    for (const Piece& piece : pieces_of(markdown)) {
        if (!piece.block) {
            last_text = piece.text;
            for (const std::string& code : quoted_in(piece.text)) {
                if (!is_command(code)) continue;
                ++out.commands;
                const bool endless =
                    code.find("--watch") != std::string::npos || code.starts_with("openfab view ");
                out.script += fmt::format("echo {} >&2\n{}{}\n", "'" + code + "'",
                                          endless ? "timeout --signal=INT 8 " : "", code);
                // It ends on request, after the print.
                if (endless) out.script.replace(out.script.size() - 1, 1, " || test $? = 124\n");
            }
            continue;
        }
        const std::vector<std::string> names = quoted_in(last_text);
        const auto name = std::find_if(names.begin(), names.end(), names_a_file);
        if (name != names.end()) {
            ++out.files;
            out.script +=
                fmt::format("cat > {} << 'END_OF_FILE'\n{}END_OF_FILE\n", *name, piece.text);
        } else {
            out.script += piece.text;
        }
        last_text.clear();
    }
    return out;
}

std::vector<std::string> pictures_of(const std::string& markdown) {
    return matches(markdown, R"(!\[[^\]]*\]\(([^)]+)\))");
}

}  // namespace openfab::testing
