// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/uniform_values.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "base/near_miss.h"
#include "world/messages.h"

namespace openfab::world {
namespace {

using Kind = JsonValue::Kind;

/// Flattens numbers, booleans or strings; arrays may hold arrays (of the same) one level down.
bool flatten(const JsonValue& value, int depth, UniformBinding* out, bool* first, Kind* kind,
             const JsonValue** culprit) {
    if (value.is(Kind::kArray) && depth < 2) {
        for (const JsonValue& item : value.items) {
            if (!flatten(item, depth + 1, out, first, kind, culprit)) return false;
        }
        return true;
    }
    const bool allowed =
        value.is(Kind::kNumber) || value.is(Kind::kBool) || value.is(Kind::kString);
    if (!allowed || (!*first && value.kind != *kind)) {
        *culprit = &value;
        return false;
    }
    if (*first) {
        *first = false;
        *kind = value.kind;
        out->boolean = value.is(Kind::kBool);
        if (value.is(Kind::kString)) out->value = std::vector<std::string>();
    }
    if (value.is(Kind::kString)) {
        std::get<std::vector<std::string>>(out->value).push_back(value.text);
    } else {
        std::get<std::vector<double>>(out->value)
            .push_back(value.is(Kind::kBool) ? (value.boolean ? 1 : 0) : value.number);
    }
    return true;
}

/// As [x, y], [x, r, g, b] or [x, [r, g, b]].
Result<std::vector<double>> curve_key(const JsonValue& value, const SourceLocation& location,
                                      const std::string& what) {
    UniformBinding numbers;
    bool first = true;
    Kind kind = Kind::kNull;
    const JsonValue* culprit = nullptr;
    const bool flat =
        value.is(Kind::kArray) && flatten(value, 0, &numbers, &first, &kind, &culprit);
    if (!flat || first || kind != Kind::kNumber) {
        return error_at({location.file, value.line, value.column}, what + messages::kKeyNoNumbers,
                        messages::kKeyNoNumbersHelp);
    }
    return std::get<std::vector<double>>(std::move(numbers.value));
}

/// Reads {"keys": [...], "interpolation": "cubic"}.
Result<UniformBinding> curve_binding(const JsonValue& value, const SourceLocation& location,
                                     const std::string& what) {
    UniformBinding out;
    out.location = location;
    Curve curve;
    const std::vector<std::string> known = {"keys", "interpolation"};
    bool any = false;
    for (const JsonMember& m : value.members) {
        const SourceLocation at{location.file, m.value.line, m.value.column};
        if (m.key == "keys") {
            any = true;
            if (!m.value.is(Kind::kArray))
                return error_at(at, fmt::format(messages::kKeysNoArray, what));
            for (const JsonValue& item : m.value.items) {
                Result<std::vector<double>> key = curve_key(item, location, what);
                if (!key) return key.error();
                curve.keys.push_back(std::move(*key));
            }
        } else if (m.key == "interpolation") {
            for (const auto how : {Curve::Interpolation::kStep, Curve::Interpolation::kLinear,
                                   Curve::Interpolation::kCubic}) {
                if (m.value.is(Kind::kString) && m.value.text == interpolation_name(how))
                    curve.interpolation = how;
            }
            if (!curve.interpolation) {
                return error_at(at, fmt::format(messages::kInterpolationNone, what),
                                messages::kInterpolationNoneHelp);
            }
        } else {
            return error_at(at, fmt::format(messages::kKeyMissing, what, m.key),
                            suggest(m.key, known));
        }
    }
    if (!any) {
        return error_at(location, what + messages::kObjectWithoutKeys,
                        messages::kObjectWithoutKeysHelp);
    }
    out.value = std::move(curve);
    return out;
}

}  // namespace

const char* interpolation_name(Curve::Interpolation interpolation) {
    switch (interpolation) {
        case Curve::Interpolation::kStep:
            return "step";
        case Curve::Interpolation::kLinear:
            return "linear";
        case Curve::Interpolation::kCubic:
            return "cubic";
    }
    return "cubic";
}

Result<UniformBinding> uniform_binding(const JsonValue& value, const SourceLocation& location,
                                       const std::string& what) {
    if (value.is(Kind::kObject)) return curve_binding(value, location, what);
    UniformBinding out;
    out.location = location;
    bool first = true;
    Kind kind = Kind::kNull;
    const JsonValue* culprit = nullptr;
    if (!flatten(value, 0, &out, &first, &kind, &culprit)) {
        const bool mixed = !first && culprit->kind != kind && !culprit->is(Kind::kArray) &&
                           !culprit->is(Kind::kObject);
        return error_at({location.file, culprit->line, culprit->column},
                        fmt::format("{} {}", what,
                                    mixed ? messages::kMixedValues
                                          : fmt::format("holds {}", culprit->kind_name())),
                        messages::kMixedValuesHelp);
    }
    if (first) return error_at(location, what + messages::kEmptyArray, messages::kEmptyArrayHelp);
    return out;
}

UniformBindings read_uniforms(const JsonValue& value, const std::string& what, JsonReader* json) {
    UniformBindings out;
    if (!json->named_things(value, "uniforms")) return out;
    for (const JsonMember& m : value.members) {
        Result<UniformBinding> binding = uniform_binding(
            m.value, json->location(m.value), fmt::format("uniform `{}` of {}", m.key, what));
        if (!binding) {
            json->fail_with(binding.error());
            return out;
        }
        out.emplace(m.key, std::move(*binding));
    }
    return out;
}

}  // namespace openfab::world
