// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "base/json.h"
#include "base/near_miss.h"
#include "tools/specimens/messages.h"
#include "tools/specimens/rows_of_text.h"

namespace openfab::specimens {

namespace {

constexpr size_t kMostBytes = 4'000'000;

/// Of a list's first line, in the order in which they are written.
enum Column { kLabel, kTray, kPiece, kWidth, kThickness, kFixed };
constexpr std::array<std::string_view, kFixed> kNames{"label", "tray", "piece", "width_mm",
                                                      "thickness_mm"};

class Reader {
  public:
    Reader(TextTable table, std::string file) : table_(std::move(table)), file_(std::move(file)) {}

    Result<List> read() {
        if (table_.rows.empty()) return user_error(fmt::format(messages::kListEmpty, file_));
        if (Result<void> done = read_header(); !done) return done.error();
        std::set<int> labels;
        for (size_t i = 1; i < table_.rows.size(); ++i) {
            const Result<Specimen> one = read_row(table_.rows[i]);
            if (!one) return one.error();
            if (!labels.insert(one->label).second)
                return wrong(table_.rows[i], fmt::format(messages::kLabelTwice, one->label));
            list_.specimens.push_back(*one);
        }
        if (list_.specimens.empty()) return user_error(fmt::format(messages::kListEmpty, file_));
        return list_;
    }

  private:
    Error wrong(const TextRow& row, std::string what) const {
        return error_at({file_, row.line, 1}, std::move(what));
    }
    Result<void> read_header() {
        const TextRow& header = table_.rows.front();
        for (size_t i = 0; i < header.cells.size(); ++i) {
            const auto known = std::ranges::find(kNames, header.cells[i]);
            if (known != kNames.end()) {
                at_[static_cast<size_t>(known - kNames.begin())] = i;
            } else if (!header.cells[i].empty()) {
                list_.columns.push_back(header.cells[i]);
                others_.push_back(i);
            }
        }
        for (size_t i = 0; i < kFixed; ++i) {
            if (!at_[i] && i != kTray)
                return wrong(header, fmt::format(messages::kColumnMissing, kNames[i]));
        }
        list_.mixtures = std::ranges::any_of(
            list_.columns, [](const std::string& name) { return name.starts_with(kShareOf); });
        return {};
    }
    Result<double> number(const TextRow& row, Column column) const {
        const size_t at = at_[column].value();
        double out = 0;
        if (at >= row.cells.size() || !read_cell(table_, row.cells[at], &out)) {
            return wrong(row, fmt::format(messages::kCellNoNumber, kNames[column],
                                          at < row.cells.size() ? row.cells[at] : ""));
        }
        return out;
    }
    Result<Specimen> read_row(const TextRow& row) {
        Specimen out;
        const Result<double> label = number(row, kLabel);
        const Result<double> width = number(row, kWidth), thickness = number(row, kThickness);
        for (const Result<double>* each : {&label, &width, &thickness})
            if (!*each) return each->error();
        if (!(*label >= 1 && *label < 1e6 && *label == std::floor(*label)))
            return wrong(row, fmt::format(messages::kLabelNoNumber, *label));
        if (!(*width > 0 && *thickness > 0))
            return wrong(row, fmt::format(messages::kSizeNotPositive, *width, *thickness));
        out.label = static_cast<int>(*label);
        out.width_mm = *width;
        out.thickness_mm = *thickness;
        const size_t named = at_[kPiece].value();
        const std::string name = named < row.cells.size() ? row.cells[named] : "";
        const Piece* piece = find_piece(name);
        if (piece == nullptr)
            return wrong(row,
                         fmt::format(messages::kPieceUnknown, name, suggest(name, piece_names())));
        if (list_.piece != nullptr && list_.piece != piece)
            return wrong(row, fmt::format(messages::kTwoPieces, name, list_.piece->name));
        list_.piece = piece;
        for (const size_t i : others_)
            out.values.push_back(i < row.cells.size() ? row.cells[i] : "");
        return out;
    }

    TextTable table_;
    std::string file_;
    List list_;
    std::array<std::optional<size_t>, kFixed> at_{};
    std::vector<size_t> others_;
};

}  // namespace

std::string list_text(const List& list) {
    std::string out = fmt::format("{}", fmt::join(kNames, ","));
    for (const std::string& column : list.columns)
        out += "," + csv_cell(column);
    out += "\n";
    for (const Specimen& one : list.specimens) {
        out += fmt::format("{},{},{},{},{}", one.label, one.tray, list.piece->name, one.width_mm,
                           one.thickness_mm);
        for (const std::string& value : one.values)
            out += "," + csv_cell(value);
        out += "\n";
    }
    return out;
}

Result<List> read_list(const std::filesystem::path& file) {
    const Result<std::string> text = read_text_file(file, kMostBytes);
    if (!text) return text.error();
    return Reader(read_text_table(*text), file.string()).read();
}

}  // namespace openfab::specimens
