// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/curve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <span>
#include <string_view>

#include "base/json.h"
#include "base/text.h"
#include "tools/specimens/messages.h"
#include "tools/specimens/rows_of_text.h"

namespace openfab::specimens {

namespace {

constexpr size_t kMostBytes = 200'000'000;
constexpr size_t kFewestPoints = 3;
constexpr double kBroken = 0.1;  ///< of the greatest stress

struct Unit {
    std::string_view name;
    double factor;
};
// Of ratios, of mm, of N, of MPa.
constexpr std::array kRatios{Unit{"%", 0.01}, Unit{"mm/mm", 1}, Unit{"m/m", 1}, Unit{"1", 1},
                             Unit{"-", 1},    Unit{"in/in", 1}, Unit{"", 1}};
constexpr std::array kLengths{Unit{"mm", 1},  Unit{"um", 0.001}, Unit{"m", 1000},
                              Unit{"cm", 10}, Unit{"in", 25.4},  Unit{"", 1}};
constexpr std::array kForces{Unit{"N", 1},
                             Unit{"kN", 1000},
                             Unit{"mN", 0.001},
                             Unit{"MN", 1e6},
                             Unit{"lbf", 4.4482216152605},
                             Unit{"kgf", 9.80665},
                             Unit{"", 1}};
constexpr std::array kStresses{
    Unit{"MPa", 1},     Unit{"N/mm2", 1},  Unit{"N/mm^2", 1}, Unit{"N/mm²", 1},
    Unit{"kPa", 0.001}, Unit{"GPa", 1000}, Unit{"Pa", 1e-6},  Unit{"psi", 0.00689475729316836},
    Unit{"", 1}};

/// A kind of column: how its name may read, in lower case, and its units.
struct Quantity {
    std::string_view name;
    std::initializer_list<std::string_view> words;
    std::span<const Unit> units;
};
const std::array<Quantity, 2> kAlong{
    {{"strain", {"strain", "dehnung"}, kRatios},
     {"extension",
      {"extension", "displacement", "elongation", "travel", "crosshead", "stroke", "weg"},
      kLengths}}};
const std::array<Quantity, 2> kAcross{{{"stress", {"stress", "spannung"}, kStresses},
                                       {"force", {"force", "load", "kraft"}, kForces}}};

struct Column {
    size_t at = 0;
    size_t quantity = 0;  ///< of the two
    double factor = 1;
};

class Reader {
  public:
    Reader(TextTable table, std::string file, const CurveOptions& options)
        : table_(std::move(table)), file_(std::move(file)), options_(options) {}

    Result<Curve> read() {
        first_ = first_row();
        if (first_ == table_.rows.size())
            return user_error(fmt::format(messages::kCurveEmpty, file_));
        header_ = first_ == 0 ? std::vector<std::string>{} : table_.rows[header_row()].cells;
        const Result<Column> along = find(kAlong, options_.strain, "--strain");
        const Result<Column> across = find(kAcross, options_.stress, "--stress");
        for (const Result<Column>* each : {&along, &across})
            if (!*each) return each->error();
        Curve out;
        out.extension = along->quantity == 1;
        for (size_t i = first_; i < table_.rows.size(); ++i) {
            const TextRow& row = table_.rows[i];
            double strain = 0, stress = 0;
            if (!cell(row, along->at, &strain) || !cell(row, across->at, &stress))
                return error_at(
                    {file_, row.line, 1},
                    fmt::format(messages::kCurveCell, name(along->at), name(across->at)),
                    messages::kCurveCellHelp);
            out.strain.push_back(strain * along->factor / (out.extension ? options_.length_mm : 1));
            out.stress_MPa.push_back(stress * across->factor /
                                     (across->quantity == 1 ? options_.area_mm2 : 1));
        }
        if (out.strain.size() < kFewestPoints)
            return user_error(fmt::format(messages::kCurveEmpty, file_));
        turn_compression(&out);
        return out;
    }

  private:
    bool cell(const TextRow& row, size_t at, double* out) const {
        return at < row.cells.size() && read_cell(table_, row.cells[at], out);
    }
    bool has_numbers(const TextRow& row) const {
        double value = 0;
        return std::ranges::count_if(row.cells, [&](const std::string& one) {
                   return read_cell(table_, one, &value);
               }) >= 2;
    }
    /// Returns the first of three rows with two numbers at least; a machine's remarks before the curve have fewer such.
    size_t first_row() const {
        size_t run = 0;
        for (size_t i = 0; i < table_.rows.size(); ++i) {
            run = has_numbers(table_.rows[i]) ? run + 1 : 0;
            if (run == kFewestPoints) return i + 1 - kFewestPoints;
        }
        return table_.rows.size();
    }
    /// Returns the row of names: the one before the numbers, or the one before that where it has units alone.
    size_t header_row() const {
        const size_t last = first_ - 1;
        if (last == 0) return last;
        const bool units = std::ranges::all_of(table_.rows[last].cells, [](const std::string& c) {
            return c.empty() || c.front() == '(' || c.front() == '[' || c.size() <= 6;
        });
        const bool named = table_.rows[last - 1].cells.size() == table_.rows[last].cells.size();
        return units && named && !has_word(table_.rows[last].cells) ? last - 1 : last;
    }
    static bool has_word(const std::vector<std::string>& cells) {
        for (const auto* kinds : {&kAlong, &kAcross})
            for (const Quantity& kind : *kinds)
                for (const std::string& c : cells)
                    if (is_called(c, kind)) return true;
        return false;
    }
    static bool is_called(const std::string& cell, const Quantity& kind) {
        const std::string small = lower_ascii(cell);
        return std::ranges::any_of(kind.words, [&](std::string_view word) {
            return small.find(word) != std::string::npos;
        });
    }
    std::string name(size_t at) const {
        return at < header_.size() ? header_[at] : fmt::format("column {}", at + 1);
    }
    std::string names() const {
        return header_.empty() ? std::string(messages::kNoHeader)
                               : fmt::format("{}", fmt::join(header_, ", "));
    }

    Result<Column> find(const std::array<Quantity, 2>& kinds, const std::string& asked,
                        const char* option) const {
        Column out;
        if (asked.empty()) {
            for (size_t k = 0; k < kinds.size(); ++k) {
                std::vector<size_t> at;
                for (size_t i = 0; i < header_.size(); ++i)
                    if (is_called(header_[i], kinds[k])) at.push_back(i);
                if (at.size() > 1)
                    return user_error(fmt::format(messages::kColumnsAlike, file_, header_[at[0]],
                                                  header_[at[1]], kinds[k].name, option));
                if (at.size() == 1) return with_unit(at[0], k, kinds);
            }
            return user_error(fmt::format(messages::kColumnNotFound, file_, kinds[0].name,
                                          kinds[1].name, names()),
                              fmt::format(messages::kColumnNotFoundHelp, option));
        }
        const auto named = std::ranges::find(header_, asked);
        if (named != header_.end()) {
            out.at = static_cast<size_t>(named - header_.begin());
        } else {
            size_t number = 0;
            const auto end = std::from_chars(asked.data(), asked.data() + asked.size(), number);
            if (end.ptr != asked.data() + asked.size() || number < 1 ||
                number > table_.rows[first_].cells.size())
                return user_error(fmt::format(messages::kColumnUnknown, file_, asked, names()));
            out.at = number - 1;
        }
        size_t kind = 0;
        if (out.at < header_.size() && is_called(header_[out.at], kinds[1]) &&
            !is_called(header_[out.at], kinds[0]))
            kind = 1;
        return with_unit(out.at, kind, kinds);
    }

    /// Finds the unit in brackets, after an underscore or a comma, or in the row below.
    Result<Column> with_unit(size_t at, size_t kind, const std::array<Quantity, 2>& kinds) const {
        const std::string cell = name(at);
        std::vector<std::string> candidates;
        const size_t open = cell.find_last_of("([");
        if (open != std::string::npos) {
            candidates.push_back(cell.substr(open + 1, cell.find_last_of(")]") - open - 1));
        } else if (const size_t mark = cell.find_last_of("_,/ ");
                   at < header_.size() && mark != std::string::npos) {
            candidates.push_back(cell.substr(mark + 1));
        }
        const bool bracketed = open != std::string::npos;
        if (first_ > 0 && header_row() + 1 < first_ && at < table_.rows[first_ - 1].cells.size()) {
            std::string below = table_.rows[first_ - 1].cells[at];
            std::erase_if(below,
                          [](char c) { return c == '(' || c == ')' || c == '[' || c == ']'; });
            candidates.insert(candidates.begin(), below);
        }
        for (const std::string& candidate : candidates) {
            if (const Unit* unit = find_unit(kinds[kind], candidate))
                return Column{at, kind, unit->factor};
        }
        if (!candidates.empty() && (bracketed || header_row() + 1 < first_))
            return user_error(fmt::format(messages::kCurveUnit, file_, cell, candidates.front(),
                                          kinds[kind].name, unit_names(kinds[kind])));
        return Column{at, kind, 1};
    }
    /// Returns the unit of that name, in any case where only one reads so.
    static const Unit* find_unit(const Quantity& kind, const std::string& name) {
        const auto exact = std::ranges::find(kind.units, std::string_view(name), &Unit::name);
        if (exact != kind.units.end()) return &*exact;
        const Unit* out = nullptr;
        for (const Unit& unit : kind.units) {
            if (lower_ascii(std::string(unit.name)) != lower_ascii(name)) continue;
            if (out != nullptr) return nullptr;
            out = &unit;
        }
        return out;
    }
    static std::string unit_names(const Quantity& kind) {
        std::vector<std::string_view> out;
        for (const Unit& unit : kind.units)
            if (!unit.name.empty()) out.push_back(unit.name);
        return fmt::format("{}", fmt::join(out, ", "));
    }

    static void turn_compression(Curve* curve) {
        for (std::vector<double>* values : {&curve->strain, &curve->stress_MPa}) {
            const auto [low, high] = std::minmax_element(values->begin(), values->end());
            if (-*low <= *high) continue;
            for (double& value : *values)
                value = -value;
        }
    }

    TextTable table_;
    std::string file_;
    CurveOptions options_;
    size_t first_ = 0;
    std::vector<std::string> header_;
};

}  // namespace

Result<Curve> read_curve(const std::filesystem::path& file, const CurveOptions& options) {
    const Result<std::string> text = read_text_file(file, kMostBytes);
    if (!text) return text.error();
    return Reader(read_text_table(*text), file.string(), options).read();
}

Result<Properties> properties_of(const Curve& curve, const std::string& file,
                                 const CurveOptions& options) {
    const auto peak = std::max_element(curve.stress_MPa.begin(), curve.stress_MPa.end());
    const auto end = static_cast<size_t>(peak - curve.stress_MPa.begin()) + 1;
    Properties out;
    out.strength_MPa = *peak;
    if (!(out.strength_MPa > 0)) return user_error(fmt::format(messages::kCurveFlat, file));
    double n = 0, x = 0, y = 0;
    const auto counts = [&](size_t i) {
        return curve.strain[i] >= options.from && curve.strain[i] <= options.to;
    };
    for (size_t i = 0; i < end; ++i) {
        if (!counts(i)) continue;
        n += 1;
        x += curve.strain[i];
        y += curve.stress_MPa[i];
    }
    if (n < static_cast<double>(kFewestPoints)) {
        return user_error(fmt::format(messages::kTooFewInRange, file, n, options.from, options.to,
                                      end, curve.strain[end - 1]),
                          messages::kTooFewInRangeHelp);
    }
    double xx = 0, xy = 0;
    for (size_t i = 0; i < end; ++i) {
        if (!counts(i)) continue;
        const double dx = curve.strain[i] - x / n;
        xx += dx * dx;
        xy += dx * (curve.stress_MPa[i] - y / n);
    }
    out.modulus_MPa = xx > 0 ? xy / xx : 0;
    if (!(out.modulus_MPa > 0)) return user_error(fmt::format(messages::kCurveFlat, file));
    for (size_t i = 0; i < curve.strain.size(); ++i)
        if (i < end || curve.stress_MPa[i] >= kBroken * out.strength_MPa)
            out.strain_at_break = curve.strain[i];
    return out;
}

}  // namespace openfab::specimens
