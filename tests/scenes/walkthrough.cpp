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
    bool is_block = false;
    Block block;
    std::string text;
};

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
    static const std::regex kFile(R"([^ ]+\.(fl|json|vtu|nrrd|obj|ppm|sched|py|csv|txt|sh))");
    return std::regex_match(text, kFile);
}

bool is_command(const std::string& code) {
    // `openfab import --repair` and the like name an option, `openflc check` alone a command, and
    // capitals stand for what the reader has.
    static const std::regex kOurs(R"((openfab|openflc) [a-z]+ +(?!-)[^ ].*|\./.*)");
    static const std::regex kStandsFor(R"(.*\b[A-Z]{3,}\b.*)");
    return std::regex_match(code, kOurs) && !std::regex_match(code, kStandsFor);
}

/// Whether a command runs until it is interrupted.
bool is_endless(const std::string& command) {
    return command.find("--watch") != std::string::npos || command.starts_with("openfab view ");
}

/// A command with its name before what it says, and its end where it has none of its own.
std::string typed(const std::string& command) {
    std::string out = fmt::format("echo {} >&2\n", "'" + command + "'");
    if (!is_endless(command)) return out + command + "\n";
    // It ends on request, after the print.
    return out + "timeout --signal=INT 8 " + command + " || test $? = 124\n";
}

std::vector<Piece> pieces_of(const std::string& markdown) {
    std::vector<Piece> pieces;
    bool in_block = false;
    int number = 0;
    std::string last_text;
    std::istringstream lines(markdown);
    for (std::string line; std::getline(lines, line);) {
        ++number;
        if (line.starts_with("```")) {
            in_block = !in_block;
            if (!in_block) continue;
            std::istringstream words(line.substr(3));
            Piece piece{true, {number, "", "", "", ""}, ""};
            words >> piece.block.language >> std::ws;
            std::getline(words, piece.block.how);
            for (const std::string& name : quoted_in(last_text)) {
                const bool is_file = piece.block.language != "sh" && names_a_file(name);
                if (is_file && piece.block.file.empty()) piece.block.file = name;
            }
            last_text.clear();
            pieces.push_back(piece);
        } else if (in_block) {
            pieces.back().block.text += line + "\n";
        } else if (!line.empty()) {
            last_text = line;
            pieces.push_back({false, {}, line});
        }
    }
    EXPECT_FALSE(in_block) << "a block has no end";
    return pieces;
}

std::string file_of(const std::string& name, const std::string& text) {
    return fmt::format("cat > {} << 'END_OF_FILE'\n{}END_OF_FILE\n", name, text);
}

/// Compiles a block of OpenFL: nothing may be said of it, or, of a wrong one, that message alone.
std::string check_of(const Block& block, const std::string& file) {
    std::string text = block.text;
    if (block.how == "statements") {
        text =
            "fablet A { @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;\n" +
            text + "return mc; } }\n";
    }
    const std::string write = file_of(file, text);
    const std::string wrong = "wrong ";
    if (!block.how.starts_with(wrong)) {
        return write + fmt::format(
                           "said=$(openflc check {} 2>&1) || true\n"
                           "test -z \"$said\" || {{ echo \"$said\" >&2; exit 1; }}\n",
                           file);
    }
    return write + fmt::format(
                       "said=$(! openflc check {} 2>&1)\n"
                       "test \"$(grep -oE '\\[[a-z-]+\\]$' <<< \"$said\" | sort -u)\" = '[{}]'"
                       " || {{ echo \"$said\" >&2; exit 1; }}\n",
                       file, block.how.substr(wrong.size()));
}

/// Sets a world up that has the members of a block besides those that `rest.fab.json` begins with.
std::string world_of(const Block& block) {
    return "{ cat rest.fab.json; cat << 'END_OF_FILE'; } > members.fab.json\n" + block.text +
           "}\nEND_OF_FILE\nopenfab print members.fab.json -o members.ofr --dry-run\n";
}

/// Types the lines of a block. What is for long runs is only set up in others.
std::string typed_lines(const Block& block, bool whole) {
    std::string out;
    std::istringstream lines(block.text);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty()) continue;
        if (block.how == "long" && !whole) {
            if (line.starts_with("openfab print ")) out += line + " --dry-run\n";
        } else {
            out += is_endless(line) ? typed(line.substr(0, line.find(" #"))) : line + "\n";
        }
    }
    return out;
}

/// Whether a block needs an optional part, `sh optional DICOM`; the build of these tries it.
std::string part_of(const Block& block) {
    for (const char* part : {"DICOM", "HDF5", "VDB", "STEP"}) {
        if (block.how == std::string("optional ") + part) return part;
    }
    return {};
}

/// Appends what becomes of a block that is no file.
void try_block(const Block& block, const WalkthroughOptions& options, Walkthrough& out) {
    const std::string by_hand = "by hand: ";
    if (block.how.starts_with(by_hand) && block.how.size() > by_hand.size()) {
        out.by_hand.push_back(fmt::format("{}: {}", block.line, block.how.substr(by_hand.size())));
        return;
    }
    const bool plain = block.how.empty();
    if (block.language == "text" && plain) return;
    ++out.blocks;
    if (const std::string part = part_of(block); block.language == "sh" && !part.empty()) {
        const bool is_built =
            std::find(options.parts.begin(), options.parts.end(), part) != options.parts.end();
        if (is_built) out.script += typed_lines(block, options.whole);
    } else if (block.language == "sh" && (plain || block.how == "long")) {
        out.script += typed_lines(block, options.whole);
    } else if (block.language == "openfl" &&
               (plain || block.how == "statements" || block.how.starts_with("wrong "))) {
        out.script += check_of(block, fmt::format("line_{}.fl", block.line));
    } else if (block.language == "json" && block.how == "members") {
        out.script += world_of(block);
    } else if (block.language == "python" && plain) {
        // A file, since processes that it starts may import it.
        const std::string file = fmt::format("line_{}.py", block.line);
        if (!options.python.empty())
            out.script += file_of(file, block.text) + options.python + " " + file + "\n";
    } else {
        out.mistakes.push_back(fmt::format("{}: ```{} {}", block.line, block.language, block.how));
    }
}

}  // namespace

Walkthrough walkthrough_of(const std::string& markdown, const WalkthroughOptions& options) {
    Walkthrough out{"set -euo pipefail\n", 0, 0, 0, {}, {}};
    for (const Piece& piece : pieces_of(markdown)) {
        if (!piece.is_block) {
            for (const std::string& code : quoted_in(piece.text)) {
                if (!is_command(code)) continue;
                ++out.commands;
                out.script += typed(code);
            }
        } else if (!piece.block.file.empty()) {
            ++out.files;
            out.script += file_of(piece.block.file, piece.block.text);
        } else {
            try_block(piece.block, options, out);
        }
    }
    return out;
}

std::vector<Block> blocks_of(const std::string& markdown) {
    std::vector<Block> out;
    for (const Piece& piece : pieces_of(markdown)) {
        if (piece.is_block) out.push_back(piece.block);
    }
    return out;
}

std::vector<std::string> pictures_of(const std::string& markdown) {
    return matches(markdown, R"(!\[[^\]]*\]\(([^)]+)\))");
}

}  // namespace openfab::testing
