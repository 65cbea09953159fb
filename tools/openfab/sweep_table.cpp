// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Tables of a uniform and the property that it gives, as `openfab mechanics cell --sweep` writes them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "base/text.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/module_text.h"
#include "tools/openfab/property_table.h"

namespace openfab::tools {

std::string constant_name(const std::string& stem) {
    std::string out;
    for (const char c : stem) {
        const char capital = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        const bool letter = capital >= 'A' && capital <= 'Z';
        const bool digit = capital >= '0' && capital <= '9';
        if (!letter && (out.empty() || !(digit || capital == '_'))) return {};
        out += capital;
    }
    return out;
}

std::string comment(const std::string& text) {
    constexpr size_t kWidth = 116;
    std::string out, line = "//";
    size_t at = 0;
    while (at < text.size()) {
        const size_t end = std::min(text.find(' ', at), text.size());
        if (line.size() > 2 && line.size() + end - at > kWidth) {
            out += line + "\n";
            line = "//";
        }
        line += " " + text.substr(at, end - at);
        at = end + 1;
    }
    return out + line + "\n";
}

namespace {

struct SweepRow {
    double at = 0, value = 0;
};

Error wrong(const JsonValue& at, const std::string& file, std::string what, std::string help = {}) {
    return error_at({file, at.line, at.column}, std::move(what), std::move(help));
}

Result<std::vector<SweepRow>> rows_of(const JsonValue& root, const std::string& file) {
    const JsonMember* rows = root.find("rows");
    constexpr size_t kMostRows = 64;
    if (!rows || rows->value.items.size() < 2 || rows->value.items.size() > kMostRows)
        return wrong(rows ? rows->value : root, file, fmt::format(messages::kSweepRows, kMostRows));
    std::vector<SweepRow> out;
    for (const JsonValue& item : rows->value.items) {
        const JsonMember* at = item.find("at");
        const JsonMember* value = item.find("value");
        for (const JsonMember* one : {at, value})
            if (!one || !one->value.is(JsonValue::Kind::kNumber) ||
                !std::isfinite(one->value.number))
                return wrong(item, file, messages::kSweepRow);
        const SweepRow row{at->value.number, value->value.number};
        if (!out.empty()) {
            const bool rises =
                out.size() == 1 ? row.value > out[0].value : out[1].value > out[0].value;
            if (row.value == out.back().value || (row.value > out.back().value) != rises)
                return wrong(item, file,
                             fmt::format(messages::kSweepNotMonotonic, out.size() + 1, row.value,
                                         out.back().value),
                             messages::kSweepNotMonotonicHelp);
        }
        out.push_back(row);
    }
    return out;
}

}  // namespace

Result<std::string> sweep_module(const JsonValue& json, const std::string& file) {
    std::string texts[3];
    for (const auto& [key, to] : {std::pair("parameter", &texts[0]),
                                  std::pair("property", &texts[1]), std::pair("unit", &texts[2])}) {
        const JsonMember* m = json.find(key);
        if (!m || !m->value.is(JsonValue::Kind::kString))
            return wrong(json, file, fmt::format(messages::kSweepTextMissing, key));
        *to = printable(m->value.text);
        std::erase(*to, '\\');
        std::erase(*to, '"');
    }
    const auto& [parameter, property, unit] = texts;
    const Result<std::vector<SweepRow>> rows = rows_of(json, file);
    if (!rows) return rows.error();
    const std::filesystem::path path(file);
    const std::string name = constant_name(path.stem().string());
    const std::string uniform = constant_name(parameter);
    if (name.empty() || uniform.empty())
        return user_error(fmt::format(messages::kCannotNameConstants,
                                      name.empty() ? path.stem().string() : parameter),
                          messages::kCannotNameConstantsHelp);
    const auto front = static_cast<float>(rows->front().value),
               back = static_cast<float>(rows->back().value);
    const float first = std::min(front, back), last = std::max(front, back);
    std::string function = path.stem().string() + "_" + parameter;
    for (char& c : function)
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    std::string out =
        comment(fmt::format("Made of {} by `openfab property`: change that, not this.",
                            path.filename().string())) +
        comment(
            fmt::format("The {} that gives a {}, in {}, in straight lines between {} cells that "
                        "were computed; outside of them that of the nearer end.",
                        parameter, property, unit, rows->size())) +
        fmt::format(
            "const float {0}_LOWEST = {1}, {0}_HIGHEST = {2};\n\nfloat {3}(float value)\n{{\n",
            name, first, last, function) +
        fmt::format(
            "    assert(value >= {0}_LOWEST && value <= {0}_HIGHEST,\n           \"the {1} "
            "%g is outside of its table, %g to %g\", value, {0}_LOWEST, {0}_HIGHEST);\n"
            "    float at = {2};\n    float part = 0;\n",
            name, property, static_cast<float>(rows->front().at));
    for (size_t i = 1; i < rows->size(); ++i)
        out += fmt::format(
            "    part = saturate((value - {0}) / ({1} - {0}));\n"
            "    if (part > 0) at = lerp({2}, {3}, part);\n",
            static_cast<float>((*rows)[i - 1].value), static_cast<float>((*rows)[i].value),
            static_cast<float>((*rows)[i - 1].at), static_cast<float>((*rows)[i].at));
    return out + "    return at;\n}\n";
}

}  // namespace openfab::tools
