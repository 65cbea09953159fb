// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/uniform_values.h"

#include <fmt/format.h>

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

}  // namespace

Result<UniformBinding> uniform_binding(const JsonValue& value, const SourceLocation& location,
                                       const std::string& what) {
    UniformBinding out;
    out.location = location;
    bool first = true;
    Kind kind = Kind::kNull;
    const JsonValue* culprit = nullptr;
    if (!flatten(value, 0, &out, &first, &kind, &culprit)) {
        const bool mixed = !first && culprit->kind != kind && !culprit->is(Kind::kArray) &&
                           !culprit->is(Kind::kObject);
        return error_at(
            {location.file, culprit->line, culprit->column},
            fmt::format(
                "{} {}", what,
                mixed ? "mixes kinds of values" : fmt::format("holds {}", culprit->kind_name())),
            "it must be a number, a boolean, the name of a texture or material, or an array of "
            "these");
    }
    if (first) return error_at(location, what + " is an empty array", "give its values");
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
