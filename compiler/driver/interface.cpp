// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/interface.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "compiler/ir/choices.h"
#include "compiler/ir/grows.h"
#include "compiler/ir/text.h"

namespace openfab::driver {

namespace {

std::string json_value(ir::Type type, uint32_t bits) {
    std::string text = ir::constant_text(type, bits);
    if (type == ir::Type::kFloat && !std::isfinite(std::bit_cast<float>(bits))) {
        return json_string(text);
    }
    return text;
}

std::string json_default(ir::Type type, const std::vector<uint32_t>& bits) {
    if (bits.empty()) return "null";
    std::string out;
    for (uint32_t value : bits)
        out += (out.empty() ? "" : ",") + json_value(type, value);
    return "[" + out + "]";
}

template <typename T, typename F>
std::string json_list(const std::vector<T>& list, const F& item) {
    std::string out;
    for (const T& value : list)
        out += (out.empty() ? "" : ",") + item(value);
    return "[" + out + "]";
}

/// Returns the names of a uniform's values as members of its object; nothing if they have none.
std::string json_choices(const ir::Uniform& u) {
    std::string list;
    const std::string lines = ir::choices(u);
    for (size_t at = 0; at < lines.size();) {
        const size_t end = std::min(lines.find('\n', at), lines.size());
        const std::string line = lines.substr(at, end - at);
        const size_t value = line.find('\t');
        const size_t label = line.find('\t', value + 1);
        list += fmt::format(R"({}{{"name":{},"label":{},"value":{}}})", list.empty() ? "" : ",",
                            json_string(line.substr(0, value)), json_string(line.substr(label + 1)),
                            line.substr(value + 1, label - value - 1));
        at = end + 1;
    }
    if (list.empty()) return "";
    const std::string of = u.type == ir::Type::kInt ? ",\"enum\":" + json_string(u.type_name) : "";
    return of + ",\"choices\":[" + list + "]";
}

std::string json_uniform(const ir::Uniform& u) {
    std::string annotations;
    const std::string choices = json_choices(u);
    for (const auto& [name, text] : u.annotations) {
        if (name == ir::kChoices) continue;
        annotations += fmt::format("{}{}:{}", annotations.empty() ? "" : ",", json_string(name),
                                   json_string(text));
    }
    return fmt::format(
        R"({{"name":{},"type":{},"kind":"{}","components":{},"array_length":{},"default":{},"annotations":{{{}}}{}}})",
        json_string(u.name),
        json_string(!choices.empty() && u.type == ir::Type::kInt ? "int" : u.type_name),
        ir::uniform_kind_name(u.kind), u.components, u.array_length,
        json_default(u.type, u.default_bits), annotations, choices);
}

std::string json_source(const std::vector<ir::Varying>& list, int32_t source) {
    return source < 0 ? "null" : json_string(list[source].name);
}

std::string json_fablet(const ir::Fablet& f) {
    const auto input = [](const ir::Varying& v) {
        return fmt::format(R"({{"name":{},"type":{},"default":{}}})", json_string(v.name),
                           json_string(v.type_name), json_default(v.type, v.default_bits));
    };
    const auto output = [&](const ir::Varying& v) {
        return fmt::format(R"({{"name":{},"type":{},"copies":{}}})", json_string(v.name),
                           json_string(v.type_name), json_source(f.surface_inputs, v.source));
    };
    const auto shape_output = [](const ir::Varying& v) {
        return fmt::format(R"({{"name":{},"type":{}}})", json_string(v.name),
                           json_string(v.type_name));
    };
    const auto nearest = [&](const ir::Varying& v) {
        return fmt::format(R"({{"name":{},"type":{},"from":{}}})", json_string(v.name),
                           json_string(v.type_name), json_source(f.surface_outputs, v.source));
    };
    return fmt::format(
        R"({{"name":{},"has_surface":{},"has_dither":{},"has_shape":{},"has_grow":{},"shape_is_distance":{},"shape_outputs":{},"uniforms":{},"surface_inputs":{},"surface_outputs":{},"nearest":{},"uses_void":{}}})",
        json_string(f.name), f.has_surface, f.has_dither, f.has_shape && !ir::grows(f),
        ir::grows(f), f.shape_is_distance, json_list(f.shape_outputs, shape_output),
        json_list(f.uniforms, json_uniform), json_list(f.surface_inputs, input),
        json_list(f.surface_outputs, output), json_list(f.nearest, nearest), f.void_slot >= 0);
}

}  // namespace

std::string describe(const ir::Module& module) {
    return fmt::format("{{\"fablets\":{}}}\n", json_list(module.fablets, json_fablet));
}

}  // namespace openfab::driver
