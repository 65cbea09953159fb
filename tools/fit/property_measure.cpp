// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/property_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/conditions.h"
#include "base/near_miss.h"
#include "tools/fit/messages.h"
#include "world/json_reader.h"

namespace openfab::fit {

namespace {

constexpr size_t kLargestTable = size_t{1} << 20;

struct TableRow {
    std::vector<double> mixture;
    double value = 0;
};

double value_at(const std::vector<TableRow>& rows, std::span<const double> shares) {
    double nearest = std::numeric_limits<double>::max(), value = 0;
    for (size_t r = 0; r + 1 < rows.size(); ++r) {
        const TableRow &a = rows[r], &b = rows[r + 1];
        double along = 0, length = 0, away = 0;
        for (size_t m = 0; m < shares.size(); ++m) {
            const double step = b.mixture[m] - a.mixture[m];
            along += (shares[m] - a.mixture[m]) * step;
            length += step * step;
        }
        const double t = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0;
        for (size_t m = 0; m < shares.size(); ++m) {
            const double d = shares[m] - std::lerp(a.mixture[m], b.mixture[m], t);
            away += d * d;
        }
        if (away >= nearest) continue;
        nearest = away;
        value = std::lerp(a.value, b.value, t);
    }
    return value;
}

}  // namespace

Result<Property> read_property(const std::filesystem::path& file, const world::World& world) {
    const Result<std::string> text = read_text_file(file, kLargestTable);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    world::JsonReader json(file.string());
    const JsonMember* materials = root->find("materials");
    const JsonMember* rows = root->find("rows");
    if (materials == nullptr || rows == nullptr || !materials->value.is(JsonValue::Kind::kArray) ||
        !rows->value.is(JsonValue::Kind::kArray) || rows->value.items.size() < 2)
        return error_at(json.location(*root), messages::kNoTable, messages::kNoTableHelp);
    Property out;
    if (const JsonMember* name = root->find("property"); name != nullptr)
        out.name = json.string(name->value, "`property`");
    if (const JsonMember* unit = root->find("unit"); unit != nullptr)
        out.unit = json.string(unit->value, "`unit`");
    auto measure = std::make_shared<program::SumMeasure>();
    std::vector<std::string> names;
    for (const world::Material& material : world.materials)
        names.push_back(material.name);
    for (const JsonValue& item : materials->value.items) {
        const std::string name = json.string(item, messages::kTableMaterial);
        const auto found = std::ranges::find(names, name);
        if (json.ok() && found == names.end())
            json.fail(item, fmt::format(messages::kNoSuchMaterial, name), suggest(name, names));
        if (!json.ok()) return json.error();
        measure->materials.push_back(static_cast<size_t>(found - names.begin()));
    }
    std::vector<TableRow> read;
    for (const JsonValue& item : rows->value.items) {
        const JsonMember* mixture = item.find("mixture");
        const JsonMember* value = item.find("value");
        if (mixture == nullptr || value == nullptr)
            return error_at(json.location(item), messages::kTableRow, messages::kNoTableHelp);
        TableRow& row = read.emplace_back();
        row.mixture = json.numbers(mixture->value, "`mixture`", measure->materials.size(), 1);
        if (value->value.is(JsonValue::Kind::kArray)) {
            Result<ConditionedNumber> number =
                number_at(value->value, "`value`", {}, file.string());
            if (!number && value->value.items.size() > 1)
                return error_at(json.location(value->value), messages::kOneCondition,
                                messages::kOneConditionHelp);
            if (!number) return number.error();
            row.value = number->value;
        } else {
            row.value = json.number(value->value, "`value`", -1e30, 1e30);
        }
        if (!json.ok()) return json.error();
    }
    const auto [lowest, highest] = std::ranges::minmax_element(read, {}, &TableRow::value);
    measure->lowest = lowest->value;
    measure->highest = highest->value;
    measure->of = [read](std::span<const double> shares) { return value_at(read, shares); };
    out.measure = std::move(measure);
    return out;
}

}  // namespace openfab::fit
