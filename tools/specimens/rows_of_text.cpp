// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/rows_of_text.h"

#include <algorithm>

#include "base/scan_number.h"
#include "base/text.h"

namespace openfab::specimens {

namespace {

std::string trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

std::vector<std::string> cells_of(std::string_view line, char between) {
    std::vector<std::string> out;
    std::string cell;
    bool quoted = false;
    for (size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (c == '"') {
            const bool twice = quoted && i + 1 < line.size() && line[i + 1] == '"';
            if (twice) {
                cell += c;
                ++i;
            } else {
                quoted = !quoted;
            }
        } else if (c == between && !quoted) {
            out.push_back(trimmed(cell));
            cell.clear();
        } else {
            cell += c;
        }
    }
    out.push_back(trimmed(cell));
    return out;
}

}  // namespace

TextTable read_text_table(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    const char between = text.find('\t') != std::string_view::npos  ? '\t'
                         : text.find(';') != std::string_view::npos ? ';'
                                                                    : ',';
    TextTable out;
    int32_t number = 0;
    while (!text.empty()) {
        const size_t end = std::min(text.find('\n'), text.size());
        const std::string line = utf8_or_latin1(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        ++number;
        if (trimmed(line).empty()) continue;
        out.rows.push_back({number, cells_of(line, between)});
    }
    // A comma that separates nothing stands before decimals, unless points do.
    if (between != ',') {
        double value = 0;
        for (const TextRow& row : out.rows) {
            for (const std::string& cell : row.cells) {
                if (cell.find(',') == std::string::npos) continue;
                out.decimal_comma = true;
                if (read_cell(out, cell, &value)) return out;
                out.decimal_comma = false;
            }
        }
    }
    return out;
}

bool read_cell(const TextTable& table, const std::string& cell, double* out) {
    std::string text = cell;
    if (table.decimal_comma) {
        if (text.find('.') != std::string::npos) return false;
        std::ranges::replace(text, ',', '.');
    }
    return !text.empty() && read_decimal(text, out) == Decimal::kFine;
}

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",;\"\n\t") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text)
        out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

}  // namespace openfab::specimens
