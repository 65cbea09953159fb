// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/uniform_value.h"

#include <algorithm>
#include <variant>
#include <vector>

#include "world/uniform_values.h"

namespace openfab::viewer {

namespace {

constexpr size_t kMostValues = 4096;

void write_curve(const world::Curve& curve, JsonText* out) {
    out->begin_object().key("keys").begin_array();
    for (const std::vector<double>& key : curve.keys) {
        out->begin_array();
        for (const double number : key)
            out->value(number);
        out->end_array();
    }
    out->end_array();
    if (curve.interpolation)
        out->member("interpolation", world::interpolation_name(*curve.interpolation));
    out->end_object();
}

}  // namespace

bool is_uniform_value(const JsonValue& value) {
    if (value.is(JsonValue::Kind::kObject))
        return world::uniform_binding(value, {}, "the value").has_value();
    const auto single = [](const JsonValue& one) {
        return one.is(JsonValue::Kind::kNumber) || one.is(JsonValue::Kind::kBool) ||
               one.is(JsonValue::Kind::kString);
    };
    if (!value.is(JsonValue::Kind::kArray)) return single(value);
    return !value.items.empty() && value.items.size() <= kMostValues &&
           std::all_of(value.items.begin(), value.items.end(), single);
}

void write_binding(const world::UniformBinding& binding, JsonText* out) {
    out->begin_array();
    if (const auto* numbers = std::get_if<std::vector<double>>(&binding.value)) {
        for (const double number : *numbers) {
            if (binding.boolean) {
                out->value(number != 0);
            } else {
                out->value(number);
            }
        }
    } else if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value)) {
        for (const std::string& name : *names)
            out->value(name);
    } else {
        write_curve(std::get<world::Curve>(binding.value), out);
    }
    out->end_array();
}

void write_override(const std::string& json, JsonText* out) {
    const Result<JsonValue> value = parse_json(json, "value");
    if (!value) {
        out->null();
    } else if (value->is(JsonValue::Kind::kArray)) {
        out->value(*value);
    } else {
        out->begin_array().value(*value).end_array();
    }
}

}  // namespace openfab::viewer
