// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/property_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/module_text.h"

namespace openfab::tools {

namespace {

using Kind = JsonValue::Kind;

/// As many as PropertyTable of stdlib/property.fl holds.
constexpr size_t kMostRows = 16, kMostMaterials = 4;
/// Of a sum of fractions, as people round them.
constexpr double kRounding = 1e-6;

struct Row {
    std::array<float, kMostMaterials> mixture{};
    float value = 0;
    double deviation = 0;  ///< of `count` specimens, as `openfab specimens read` writes it
    int count = 0;         ///< 0: unknown
};

struct Table {
    std::string property, unit, source;
    std::vector<std::string> materials;
    bool measured = false;
    std::vector<Row> rows;
};

class Reader {
  public:
    Reader(const JsonValue& root, const std::string& file, const Conditions& asked)
        : root_(root), file_(file), asked_(asked) {}

    Result<Table> read() {
        Table out;
        if (!root_.is(Kind::kObject)) return wrong(root_, messages::kTableIsAnObject);
        for (const JsonMember& member : root_.members) {
            constexpr std::array kKeys{"property", "unit",   "materials",
                                       "measured", "source", "rows"};
            if (std::find(kKeys.begin(), kKeys.end(), member.key) == kKeys.end())
                return wrong(member.value, fmt::format(messages::kNoKeyOfTable, member.key));
        }
        for (const auto& [key, to] :
             {std::pair{"property", &out.property}, {"unit", &out.unit}, {"source", &out.source}}) {
            const Result<const JsonValue*> text = member(root_, key, Kind::kString, "a text");
            if (!text) return text.error();
            *to = one_line((*text)->text);
        }
        const Result<const JsonValue*> measured =
            member(root_, "measured", Kind::kBool, "true, or false where values are nominal");
        if (!measured) return measured.error();
        out.measured = (*measured)->boolean;
        if (Result<void> done = read_materials(&out); !done) return done.error();
        if (Result<void> done = read_rows(&out); !done) return done.error();
        return out;
    }

  private:
    Error wrong(const JsonValue& at, const std::string& what, const std::string& help = {}) const {
        return error_at({file_, at.line, at.column}, what, help);
    }
    Result<const JsonValue*> member(const JsonValue& object, const char* key, Kind kind,
                                    const char* right) const {
        const JsonMember* const found = object.find(key);
        if (found == nullptr) return wrong(object, fmt::format(messages::kKeyMissing, key, right));
        if (found->value.is(kind)) return &found->value;
        return wrong(found->value,
                     fmt::format(messages::kKeyIsNot, key, found->value.kind_name(), right));
    }
    /// Text for a comment of one line.
    static std::string one_line(const std::string& text) {
        std::string out = printable(text);
        std::erase(out, '\\');
        return out;
    }
    Result<void> read_materials(Table* out) {
        const Result<const JsonValue*> names = member(root_, "materials", Kind::kArray, "names");
        if (!names) return names.error();
        for (const JsonValue& name : (*names)->items) {
            if (!name.is(Kind::kString)) return wrong(name, messages::kMaterialNamedByText);
            out->materials.push_back(one_line(name.text));
        }
        if (out->materials.size() >= 2 && out->materials.size() <= kMostMaterials) return {};
        return wrong(**names,
                     fmt::format(messages::kMaterialCount, out->materials.size(), kMostMaterials));
    }
    Result<void> read_rows(Table* out) {
        const Result<const JsonValue*> rows = member(root_, "rows", Kind::kArray, "rows");
        if (!rows) return rows.error();
        if ((*rows)->items.size() < 2 || (*rows)->items.size() > kMostRows) {
            return wrong(**rows,
                         fmt::format(messages::kRowCount, (*rows)->items.size(), kMostRows));
        }
        for (const JsonValue& item : (*rows)->items) {
            const Result<Row> row = read_row(item, out->materials.size());
            if (!row) return row.error();
            out->rows.push_back(*row);
            const size_t n = out->rows.size();
            if (n < 2) continue;
            const bool rises = out->rows[1].value > out->rows[0].value;
            const float before = out->rows[n - 2].value;
            if (row->value == before || (row->value > before) != rises) {
                return wrong(item,
                             fmt::format(messages::kValuesNotMonotonic, n, row->value, before),
                             messages::kValuesNotMonotonicHelp);
            }
        }
        return {};
    }
    /// A number, or what was measured at temperatures and rates.
    Result<double> value_of(const JsonValue& item) const {
        const JsonMember* const value = item.find("value");
        if (value == nullptr || !value->value.is(Kind::kArray)) {
            const Result<const JsonValue*> number =
                member(item, "value", Kind::kNumber, "a number");
            if (!number) return number.error();
            return (*number)->number;
        }
        const Result<ConditionedNumber> number = number_at(value->value, "`value`", asked_, file_);
        if (!number) return number.error();
        return number->value;
    }
    Result<Row> read_row(const JsonValue& item, size_t materials) const {
        const Result<const JsonValue*> mixture = member(item, "mixture", Kind::kArray, "fractions");
        if (!mixture) return mixture.error();
        const Result<double> value = value_of(item);
        if (!value) return value.error();
        Row row;
        row.value = static_cast<float>(*value);
        if (!std::isfinite(row.value)) return wrong(item, messages::kTableValueNotFinite);
        if (item.find("deviation") != nullptr || item.find("count") != nullptr) {
            const Result<const JsonValue*> deviation =
                member(item, "deviation", Kind::kNumber, "a number");
            if (!deviation) return deviation.error();
            const Result<const JsonValue*> count = member(item, "count", Kind::kNumber, "a number");
            if (!count) return count.error();
            row.deviation = (*deviation)->number;
            if (!(row.deviation >= 0)) return wrong(**deviation, messages::kDeviationNegative);
            row.count = static_cast<int>(std::clamp((*count)->number, 0.0, 1e6));
        }
        if ((*mixture)->items.size() != materials) {
            return wrong(**mixture, fmt::format(messages::kFractionCount, (*mixture)->items.size(),
                                                materials));
        }
        double sum = 0;
        for (size_t i = 0; i < materials; ++i) {
            const JsonValue& part = (*mixture)->items[i];
            if (!part.is(Kind::kNumber) || !(part.number >= 0 && part.number <= 1))
                return wrong(part, messages::kFractionOutside);
            row.mixture[i] = static_cast<float>(part.number);
            sum += part.number;
        }
        if (std::abs(sum - 1) > kRounding)
            return wrong(**mixture, fmt::format(messages::kFractionSum, sum));
        return row;
    }

    const JsonValue& root_;
    const std::string& file_;
    const Conditions& asked_;
};

/// Returns a comment on the scatter of the values, where the table says it.
std::string scatter_comment(const std::vector<Row>& rows) {
    std::string out;
    for (const Row& row : rows) {
        if (row.count == 0) return {};
        out += fmt::format("{}{:.3g} of {}", out.empty() ? "" : ", ", row.deviation, row.count);
    }
    return comment("Standard deviations of the values, and of how many specimens: " + out + ".");
}

std::string conditions_comment(const Conditions& asked) {
    std::string out;
    if (asked.temperature_C) out = fmt::format("At {:g} C.", *asked.temperature_C);
    if (asked.rate_1_s)
        out += fmt::format("{}At a rate of {:.4g}/s.", out.empty() ? "" : " ", *asked.rate_1_s);
    return out.empty() ? out : comment(out);
}

std::string list(const std::vector<std::string>& items, size_t in_line) {
    std::string out = "{";
    for (size_t i = 0; i < items.size(); ++i)
        out += (i == 0 ? "" : i % in_line == 0 ? ",\n     " : ", ") + items[i];
    return out + "}";
}

}  // namespace

Result<std::string> property_module(std::string_view text, const std::string& file,
                                    const Conditions& asked) {
    const Result<JsonValue> json = parse_json(text, file);
    if (!json) return json.error();
    if (json->is(Kind::kObject) && json->find("parameter")) return sweep_module(*json, file);
    const Result<Table> table = Reader(*json, file, asked).read();
    if (!table) return table.error();
    const std::filesystem::path path(file);
    const std::string name = constant_name(path.stem().string());
    if (name.empty()) {
        return user_error(fmt::format(messages::kCannotNameConstants, path.stem().string()),
                          messages::kCannotNameConstantsHelp);
    }
    std::vector<std::string> values, mixtures;
    for (size_t i = 0; i < kMostRows; ++i) {
        const Row row = i < table->rows.size() ? table->rows[i] : Row{};
        values.push_back(fmt::format("{}", row.value));
        const auto& m = row.mixture;
        mixtures.push_back(fmt::format("{{{}, {}, {}, {}}}", m[0], m[1], m[2], m[3]));
    }
    const auto [first, last] = std::minmax(table->rows.front().value, table->rows.back().value);
    return comment(fmt::format("Made of {} by `openfab property`: change that, not this.",
                               path.filename().string())) +
           comment(fmt::format("The {} of mixtures of {}, in {}, {}.", table->property,
                               fmt::join(table->materials, ", "), table->unit,
                               table->measured ? "measured" : "nominal: not measured")) +
           conditions_comment(asked) + comment("Source: " + table->source) +
           scatter_comment(table->rows) + "import property;\n\n" +
           fmt::format("const PropertyTable {} = {{\n    {},\n    {},\n    {}\n}};\n", name,
                       table->rows.size(), list(values, 16), list(mixtures, 4)) +
           fmt::format("const float {}_LOWEST = {}, {}_HIGHEST = {};\n", name, first, name, last);
}

}  // namespace openfab::tools
