// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "base/json_text.h"
#include "tools/specimens/messages.h"

namespace openfab::specimens {

namespace {

struct Property {
    const char* file;
    const char* name;
    const char* unit;
    Scatter Kind::*scatter;
};
constexpr std::array kProperties{
    Property{"modulus", "tensile modulus", "MPa", &Kind::modulus_MPa},
    Property{"strength", "strength", "MPa", &Kind::strength_MPa},
    Property{"strain_at_break", "strain at break", "1", &Kind::strain_at_break},
};
/// As many rows as tables hold, of mixtures and of uniforms.
constexpr size_t kMostMixtures = 16, kMostValues = 64;
constexpr double kWhole = 1 - 1e-6;

/// A kind's numbers, of a mixture or of uniforms.
struct Row {
    std::vector<double> at;
    const Kind* kind = nullptr;
};

Result<std::vector<Row>> rows_of(const List& list, const Measurements& measured) {
    std::vector<Row> out;
    for (const Kind& kind : measured.kinds) {
        Row row;
        row.kind = &kind;
        for (size_t i = 0; i < kind.values.size(); ++i) {
            const std::string& text = kind.values[i];
            double value = 0;
            const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
            if (end.ec != std::errc() || end.ptr != text.data() + text.size())
                return user_error(fmt::format(messages::kNotOneNumber, list.columns[i], text));
            row.at.push_back(value);
        }
        out.push_back(std::move(row));
    }
    return out;
}

/// Sorted by the property, which tables of mixtures must be, or by the uniform.
std::vector<Row> sorted(std::vector<Row> rows, const List& list, const Property& property) {
    std::ranges::stable_sort(rows, [&](const Row& a, const Row& b) {
        return list.mixtures && list.columns.size() > 2
                   ? (a.kind->*property.scatter).mean < (b.kind->*property.scatter).mean
               : list.mixtures ? a.at.back() < b.at.back()
                               : a.at.front() < b.at.front();
    });
    return rows;
}

bool is_monotonic(const std::vector<Row>& rows, const Property& property) {
    for (size_t i = 1; i < rows.size(); ++i) {
        const double step =
            (rows[i].kind->*property.scatter).mean - (rows[i - 1].kind->*property.scatter).mean;
        const double first =
            (rows[1].kind->*property.scatter).mean - (rows[0].kind->*property.scatter).mean;
        if (step == 0 || (step > 0) != (first > 0)) return false;
    }
    return true;
}

std::string material_of(const std::string& column) {
    return column.substr(std::min(column.size(), kShareOf.size()));
}

/// Writes a number as a list of one row where it is known at which temperature and rate it was measured.
void write_conditioned(double value, const Conditions& conditions, JsonText* out) {
    if (!conditions.temperature_C) {
        out->value(value);
        return;
    }
    out->begin_list().begin_object();
    out->member("T_C", *conditions.temperature_C).member("rate_1_s", *conditions.rate_1_s);
    out->member("value", value).end_object().end_array();
}

std::string table_text(const List& list, const std::vector<Row>& rows, const Property& property,
                       const Origin& origin) {
    JsonText out(JsonText::Layout::kIndentedLists);
    out.begin_object();
    if (!list.mixtures) out.member("parameter", list.columns.front());
    out.member("property", property.name).member("unit", property.unit);
    if (list.mixtures) {
        out.key("materials").begin_list();
        for (const std::string& column : list.columns)
            out.value(material_of(column));
        out.end_array().member("measured", true);
    }
    out.member("source", origin.source).key("rows").begin_array();
    for (const Row& row : rows) {
        out.begin_object();
        if (list.mixtures) {
            out.key("mixture").begin_list();
            for (const double share : row.at)
                out.value(share);
            out.end_array();
        } else {
            out.member("at", row.at.front());
        }
        const Scatter& scatter = row.kind->*property.scatter;
        out.key("value");
        // Tables of a uniform take numbers alone.
        if (list.mixtures) {
            write_conditioned(scatter.mean, origin.conditions, &out);
        } else {
            out.value(scatter.mean);
        }
        out.member("deviation", scatter.deviation).member("count", scatter.count);
        out.end_object();
    }
    return out.end_array().end_object().take() + "\n";
}

/// Returns the row of a material alone, or null.
const Row* pure(const std::vector<Row>& rows, size_t material) {
    const auto row =
        std::ranges::find_if(rows, [&](const Row& one) { return one.at[material] >= kWhole; });
    return row == rows.end() ? nullptr : &*row;
}

std::optional<std::string> mechanics_text(const List& list, const std::vector<Row>& rows,
                                          const Origin& origin,
                                          const std::map<std::string, double>& poisson,
                                          bool has_table, std::vector<std::string>* notes) {
    JsonText out(JsonText::Layout::kIndented);
    out.begin_object();
    if (has_table) out.member("law", "table").member("table", "modulus.json");
    out.key("materials").begin_object();
    for (size_t i = 0; i < list.columns.size(); ++i) {
        const std::string name = material_of(list.columns[i]);
        const Row* row = pure(rows, i);
        const auto nu = poisson.find(name);
        if (row == nullptr || nu == poisson.end()) {
            notes->push_back(row == nullptr ? fmt::format(messages::kNotAlone, name)
                                            : fmt::format(messages::kNoPoisson, name));
            return std::nullopt;
        }
        out.key(name).begin_object().key("E_MPa");
        write_conditioned(row->kind->modulus_MPa.mean, origin.conditions, &out);
        out.member("nu", nu->second).member("strength_MPa", row->kind->strength_MPa.mean);
        out.member(
            "source",
            fmt::format(
                "{}; {} specimens, standard deviations {:.3g} MPa of E, {:.3g} MPa of strength",
                origin.source, row->kind->modulus_MPa.count, row->kind->modulus_MPa.deviation,
                row->kind->strength_MPa.deviation));
        out.end_object();
    }
    return out.end_object().end_object().take() + "\n";
}

}  // namespace

Result<Tables> tables(const List& list, const Measurements& measured, const Origin& origin,
                      const std::map<std::string, double>& poisson) {
    Tables out;
    if (!list.mixtures && list.columns.size() != 1) {
        out.notes.push_back(fmt::format(messages::kOneUniform, list.columns.size()));
        return out;
    }
    const Result<std::vector<Row>> rows = rows_of(list, measured);
    if (!rows) return rows.error();
    bool has_modulus = false;
    const size_t most = list.mixtures ? kMostMixtures : kMostValues;
    for (const Property& property : kProperties) {
        const std::vector<Row> in_order = sorted(*rows, list, property);
        if (in_order.size() < 2 || in_order.size() > most) {
            out.notes.push_back(
                fmt::format(messages::kTableRows, property.file, in_order.size(), most));
        } else if (list.mixtures && (list.columns.size() < 2 || list.columns.size() > 4)) {
            out.notes.push_back(
                fmt::format(messages::kTableMaterials, property.file, list.columns.size()));
        } else if (!is_monotonic(in_order, property)) {
            out.notes.push_back(
                fmt::format(messages::kTableNotMonotonic, property.file, property.name));
        } else {
            has_modulus |= &property == &kProperties.front();
            out.files.push_back({fmt::format("{}.json", property.file),
                                 table_text(list, in_order, property, origin)});
        }
    }
    if (list.mixtures) {
        if (std::optional<std::string> text =
                mechanics_text(list, *rows, origin, poisson, has_modulus, &out.notes))
            out.files.push_back({"mechanics.json", std::move(*text)});
    }
    return out;
}

}  // namespace openfab::specimens
