// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/materials.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

constexpr size_t kMostMaterialBytes = 4 << 20;

struct MaterialReader {
    std::string file;

    Error at(const JsonValue& value, std::string what, std::string help = {}) const {
        return error_at({file, value.line, value.column}, std::move(what), std::move(help));
    }
    Error at(const JsonMember& member, std::string what, std::string help = {}) const {
        return error_at({file, member.line, member.column}, std::move(what), std::move(help));
    }
};

/// Reads a modulus; that of a single number is at what the material says.
Result<ConditionedNumber> modulus_of(const MaterialReader& in, const JsonMember& material,
                                     const JsonValue& young, const Conditions& measured,
                                     const Conditions& asked) {
    const std::string name = fmt::format("`E_MPa` of `{}`", material.key);
    Result<ConditionedNumber> out = number_at(young, name, asked, in.file);
    if (!out || (!measured.temperature_C && !measured.rate_1_s)) return out;
    if (out->is_conditioned || !measured.temperature_C || !measured.rate_1_s)
        return in.at(material, fmt::format(messages::kBothConditions, material.key));
    const bool other =
        (asked.temperature_C && *asked.temperature_C != *measured.temperature_C) ||
        (asked.rate_1_s && std::abs(std::log(*asked.rate_1_s / *measured.rate_1_s)) > 1e-3);
    if (other)
        return in.at(young,
                     fmt::format(messages::kOtherConditions, name, *measured.temperature_C,
                                 *measured.rate_1_s),
                     messages::kOtherConditionsHelp);
    out->is_conditioned = true;
    return out;
}

Result<Material> read_material(const MaterialReader& in, const JsonMember& member,
                               const Conditions& asked) {
    static constexpr const char* kKeys[] = {
        "E_MPa",        "T_C",           "rate_1_s",          "nu",
        "strength_MPa", "density_g_cm3", "conductivity_W_mK", "conductivity_S_m",
        "in_table",     "source"};
    if (!member.value.is(JsonValue::Kind::kObject))
        return in.at(member.value,
                     fmt::format(messages::kNotAnObject, member.key, member.value.kind_name()));
    Material m;
    m.name = member.key;
    std::optional<double> poisson;
    const JsonValue* young = nullptr;
    Conditions measured;
    for (const JsonMember& one : member.value.members) {
        if (std::ranges::find(kKeys, one.key) == std::end(kKeys))
            return in.at(one, fmt::format(messages::kMaterialWithout, one.key),
                         fmt::format(messages::kChooseFrom, fmt::join(kKeys, ", ")));
        if (one.key == "source" || one.key == "in_table") {
            if (!one.value.is(JsonValue::Kind::kString))
                return in.at(one.value, fmt::format(messages::kMustBeText, one.key));
            (one.key == "source" ? m.source : m.called) = one.value.text;
            continue;
        }
        if (one.key == "E_MPa") {
            young = &one.value;
            continue;
        }
        if (!one.value.is(JsonValue::Kind::kNumber) || !std::isfinite(one.value.number))
            return in.at(one.value, fmt::format(messages::kMustBeNumber, one.key));
        const double v = one.value.number;
        if (one.key == "nu") {
            // Nearer to the ends one modulus is lost beside the other.
            if (!(v >= -0.999 && v <= 0.4999))
                return in.at(one.value, fmt::format(messages::kPoissonOutside, v),
                             messages::kPoissonOutsideHelp);
            poisson = v;
            continue;
        }
        if (one.key == "T_C") {
            measured.temperature_C = v;
            continue;
        }
        if (!(v > 0)) return in.at(one.value, fmt::format(messages::kNotAboveZero, one.key, v));
        if (one.key == "rate_1_s") measured.rate_1_s = v;
        if (one.key == "strength_MPa") m.strength_MPa = v;
        if (one.key == "density_g_cm3") m.density_g_cm3 = v;
        if (one.key == "conductivity_W_mK") m.conductivity = v;
        if (one.key == "conductivity_S_m") m.conductivity_S_m = v;
    }
    // What only conducts needs none.
    if (!young && !poisson && (m.conductivity || m.conductivity_S_m)) return m;
    if (!young)
        return in.at(member, fmt::format(messages::kNoModulus, member.key), messages::kGiveModulus);
    if (!poisson)
        return in.at(member, fmt::format(messages::kNoPoisson, member.key),
                     messages::kNoPoissonHelp);
    const Result<ConditionedNumber> number = modulus_of(in, member, *young, measured, asked);
    if (!number) return number.error();
    m.young_MPa = number->value;
    m.conditioned = number->is_conditioned;
    m.poisson = *poisson;
    return m;
}

}  // namespace

std::optional<Law> law_of(const std::string& name) {
    for (size_t i = 0; i < std::size(kLawNames); ++i)
        if (name == kLawNames[i]) return static_cast<Law>(i);
    return std::nullopt;
}

const Material* Properties::find(const std::string& name) const {
    const auto found = std::ranges::find(materials, name, &Material::name);
    return found == materials.end() ? nullptr : &*found;
}

Result<std::vector<Material>> Properties::of(const std::vector<std::string>& names,
                                             std::span<const uint8_t> used, bool stiff) const {
    std::vector<Material> out;
    for (size_t k = 0; k < names.size(); ++k) {
        const std::string& name = names[k];
        const Material* m = find(name);
        if (used[k] == 0) {
            out.push_back(m ? *m : Material{});
            out.back().name = name;
            out.back().used = false;
            if (!(out.back().young_MPa > 0)) out.back().young_MPa = 1;
            continue;
        }
        if (!m) {
            std::vector<std::string> known;
            for (const Material& one : materials)
                known.push_back(one.name);
            return user_error(
                fmt::format(messages::kMaterialUnknown, file, name, fmt::join(known, ", ")),
                fmt::format(messages::kMaterialUnknownHelp, name));
        }
        if (stiff && !(m->young_MPa > 0))
            return user_error(fmt::format(messages::kNoModulusIn, file, name),
                              messages::kGiveModulus);
        out.push_back(*m);
    }
    return out;
}

Result<PropertyTable> read_property_table(const std::filesystem::path& file,
                                          const Conditions& asked) {
    const MaterialReader in{file.string()};
    const Result<std::string> text = read_text_file(file, kMostMaterialBytes);
    if (!text) return text.error();
    const Result<JsonValue> json = parse_json(*text, file.string());
    if (!json) return json.error();
    const JsonMember* materials = json->find("materials");
    const JsonMember* rows = json->find("rows");
    if (!materials || !rows || !materials->value.is(JsonValue::Kind::kArray) ||
        !rows->value.is(JsonValue::Kind::kArray))
        return in.at(*json, messages::kTableIncomplete, messages::kTableIncompleteHelp);
    const JsonMember* unit = json->find("unit");
    if (!unit || unit->value.text != "MPa") return in.at(*json, messages::kTableUnit);
    PropertyTable out;
    for (const JsonValue& one : materials->value.items)
        out.materials.push_back(one.text);
    for (const JsonValue& one : rows->value.items) {
        const JsonMember* mixture = one.find("mixture");
        const JsonMember* value = one.find("value");
        if (!mixture || !value || mixture->value.items.size() != out.materials.size())
            return in.at(one, fmt::format(messages::kRowIncomplete, out.materials.size()));
        const Result<ConditionedNumber> number = number_at(value->value, "`value`", asked, in.file);
        if (!number) return number.error();
        PropertyTable::Row row{{}, number->value};
        if (const JsonMember* deviation = one.find("deviation")) {
            if (!(deviation->value.number >= 0))
                return in.at(deviation->value, messages::kDeviationNegative);
            row.deviation = deviation->value.number;
        }
        double sum = 0;
        for (const JsonValue& share : mixture->value.items) {
            row.mixture.push_back(share.number);
            sum += share.number;
        }
        if (std::abs(sum - 1) > 1e-3) return in.at(mixture->value, messages::kSharesNotOne);
        out.rows.push_back(std::move(row));
    }
    if (out.rows.size() < 2) return in.at(rows->value, messages::kTooFewRows);
    return out;
}

Result<Properties> read_properties(const std::filesystem::path& file, const Conditions& asked) {
    const MaterialReader in{file.string()};
    const Result<std::string> text = read_text_file(file, kMostMaterialBytes);
    if (!text) return Error{text.error().code, text.error().text(), messages::kNoMaterialsFile, {}};
    const Result<JsonValue> json = parse_json(*text, file.string());
    if (!json) return json.error();
    if (!json->is(JsonValue::Kind::kObject)) return in.at(*json, messages::kNoObject);
    Properties out;
    out.file = file.string();
    out.asked = asked;
    for (const JsonMember& one : json->members) {
        if (one.key == "materials" && one.value.is(JsonValue::Kind::kObject)) {
            for (const JsonMember& member : one.value.members) {
                Result<Material> m = read_material(in, member, asked);
                if (!m) return m.error();
                out.materials.push_back(std::move(*m));
            }
        } else if (one.key == "law" && one.value.is(JsonValue::Kind::kString)) {
            const std::optional<Law> law = law_of(one.value.text);
            if (!law)
                return in.at(one.value, fmt::format(messages::kNoSuchLaw, one.value.text),
                             fmt::format(messages::kChooseFrom, fmt::join(kLawNames, ", ")));
            out.law = *law;
        } else if (one.key == "table" && one.value.is(JsonValue::Kind::kString)) {
            Result<PropertyTable> table =
                read_property_table(file.parent_path() / one.value.text, asked);
            if (!table) return table.error();
            out.table = std::move(*table);
            if (!json->find("law")) out.law = Law::kTable;
        } else {
            return in.at(one, fmt::format(messages::kKeyUnknown, one.key),
                         messages::kKeyUnknownHelp);
        }
    }
    if (out.materials.empty()) return in.at(*json, messages::kNoMaterials);
    if (out.law == Law::kTable && !out.table) return in.at(*json, messages::kLawTableMissing);
    return out;
}

std::filesystem::path properties_beside(const std::filesystem::path& input) {
    std::string name = input.filename().string();
    for (const char* end : {".fab.json", ".json", ".fl", ".ofr"})
        if (name.ends_with(end)) {
            name.resize(name.size() - std::string_view(end).size());
            break;
        }
    std::error_code status;
    const std::filesystem::path own = input.parent_path() / (name + ".mechanics.json");
    if (std::filesystem::exists(own, status)) return own;
    return input.parent_path() / "mechanics.json";
}

}  // namespace openfab::mechanics
