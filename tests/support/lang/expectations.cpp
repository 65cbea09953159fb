// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lang/expectations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <regex>
#include <sstream>

#include "compiler/diag/render.h"

namespace openfab::testing {

namespace {

struct Item {
    uint32_t line = 0;
    uint32_t column = 0;
    uint32_t width = 0;
    std::string text;
    std::vector<std::string> extras;
};

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> out;
    std::istringstream in{std::string(text)};
    for (std::string line; std::getline(in, line);)
        out.push_back(line);
    return out;
}

const std::regex kCaret(R"(^//( *)(\^~*) ((?:error|warning): .*)$)");
const std::regex kPlaced(R"(^//@ (\d+):(\d+)\+(\d+) ((?:error|warning): .*)$)");
const std::regex kExtra(R"(^// ((?:note \d+:\d+|help): .*)$)");

bool is_expectation(const std::string& line) {
    return std::regex_match(line, kCaret) || std::regex_match(line, kPlaced) ||
           std::regex_match(line, kExtra);
}

uint32_t number(const std::string& text) {
    return static_cast<uint32_t>(std::strtoul(text.c_str(), nullptr, 10));
}

std::vector<Item> parse_expected(std::string_view text) {
    std::vector<Item> items;
    uint32_t line_number = 0;
    uint32_t source_line = 0;
    for (const std::string& line : lines_of(text)) {
        ++line_number;
        std::smatch m;
        if (std::regex_match(line, m, kCaret)) {
            items.push_back({source_line,
                             static_cast<uint32_t>(3 + m[1].length()),
                             static_cast<uint32_t>(m[2].length()),
                             m[3],
                             {}});
        } else if (std::regex_match(line, m, kPlaced)) {
            items.push_back({number(m[1]), number(m[2]), number(m[3]), m[4], {}});
        } else if (std::regex_match(line, m, kExtra) && !items.empty()) {
            items.back().extras.push_back(m[1]);
        } else {
            source_line = line_number;
        }
    }
    return items;
}

/// Parses the compiler's output, so that the rendering is tested, too.
std::vector<Item> parse_rendered(const std::string& text) {
    static const std::regex kMessage(R"(^.*?:(\d+):(\d+): ((?:error|warning): .*)$)");
    static const std::regex kNote(R"(^.*?:(\d+:\d+): note: (.*)$)");
    static const std::regex kUnder(R"(^ +\| ( *)(\^~*)$)");
    std::vector<Item> items;
    bool source_line_next = false;
    for (const std::string& line : lines_of(text)) {
        std::smatch m;
        if (source_line_next) {
            source_line_next = false;
        } else if (std::regex_match(line, m, kMessage)) {
            items.push_back({number(m[1]), number(m[2]), 0, m[3], {}});
            source_line_next = true;
        } else if (std::regex_match(line, m, kUnder) && !items.empty()) {
            items.back().width = static_cast<uint32_t>(m[2].length());
            if (m[1].length() + 1 != static_cast<long>(items.back().column)) items.back().width = 0;
        } else if (std::regex_match(line, m, kNote) && !items.empty()) {
            items.back().extras.push_back("note " + m[1].str() + ": " + m[2].str());
        } else if (!items.empty()) {
            items.back().extras.push_back(line);
        }
    }
    return items;
}

std::vector<std::string> flatten(std::vector<Item> items) {
    std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
        return std::tie(a.line, a.column, a.text) < std::tie(b.line, b.column, b.text);
    });
    std::vector<std::string> out;
    for (const Item& item : items) {
        out.push_back(fmt::format("{}:{}+{} {}", item.line, item.column, item.width, item.text));
        out.insert(out.end(), item.extras.begin(), item.extras.end());
    }
    return out;
}

}  // namespace

std::vector<std::string> expected_diagnostics(std::string_view text) {
    return flatten(parse_expected(text));
}

std::vector<std::string> actual_diagnostics(const diag::Sink& sink,
                                            const source::SourceManager& sources) {
    return flatten(parse_rendered(diag::render_text(sink, sources)));
}

std::string difference(const std::vector<std::string>& expected,
                       const std::vector<std::string>& actual) {
    if (expected == actual) return "";
    std::string out;
    std::multimap<std::string, int> left;
    for (const std::string& line : actual)
        left.emplace(line, 0);
    for (const std::string& line : expected) {
        const auto found = left.find(line);
        if (found == left.end()) {
            out += "missing: " + line + '\n';
        } else {
            left.erase(found);
        }
    }
    for (const auto& [line, unused] : left)
        out += "extra:   " + line + '\n';
    return out.empty() ? "the order differs\n" : out;
}

std::string with_expectations(std::string_view text, const diag::Sink& sink,
                              const source::SourceManager& sources) {
    const std::vector<Item> items = parse_rendered(diag::render_text(sink, sources));
    std::string out;
    std::string placed;
    uint32_t line_number = 0;
    const std::vector<std::string> lines = lines_of(text);
    for (size_t i = 0; i < lines.size(); ++i) {
        ++line_number;
        if (is_expectation(lines[i])) continue;
        out += lines[i];
        if (i + 1 < lines.size() || (!text.empty() && text.back() == '\n')) out += '\n';
        for (const Item& item : items) {
            if (item.line != line_number || item.column < 3) continue;
            out += "//" + std::string(item.column - 3, ' ') + '^' +
                   std::string(item.width - 1, '~') + ' ' + item.text + '\n';
            for (const std::string& extra : item.extras)
                out += "// " + extra + '\n';
        }
    }
    for (const Item& item : items) {
        if (item.column >= 3) continue;
        out += fmt::format("//@ {}:{}+{} {}\n", item.line, item.column, item.width, item.text);
        for (const std::string& extra : item.extras)
            out += "// " + extra + '\n';
    }
    return out;
}

}  // namespace openfab::testing
