// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/rates.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "abi/curve_table.h"
#include "abi/element_name.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

const openfab_uniform* find_uniform(const openfab_fablet& fablet, const std::string& name) {
    const auto* end = fablet.uniforms + fablet.uniform_count;
    const auto* found =
        std::find_if(fablet.uniforms, end, [&](const auto& u) { return name == u.name; });
    return found == end ? nullptr : found;
}

Error no_derivative(const std::string& name, const std::string& why) {
    Error error = user_error(fmt::format(messages::kNoRate, name, why));
    error.help = messages::kNoRateHelp;
    return error;
}

/// The uniform, or the element of one, of `OBJECT.UNIFORM`.
std::string asked_of(const std::string& name) {
    const size_t dot = name.rfind('.');
    return dot == std::string::npos ? "" : name.substr(dot + 1);
}

}  // namespace

Result<pipeline::Rates> find_rates(const Job& job, const std::vector<std::string>& names,
                                   const DirectionsOf& directions_of,
                                   std::vector<RateColumns>* columns) {
    const std::vector<part::Part>& parts = job.input.parts;
    pipeline::Rates out;
    for (const part::Part& part : parts)
        out.of_parts.emplace_back(directions_of(*part.fablet).size(), -1);
    if (!job.effects.empty()) return user_error(messages::kRatesWithEffects);
    for (const std::string& name : names) {
        const size_t dot = name.rfind('.');
        const std::string object = name.substr(0, dot);
        const abi::Element element = abi::element_of(asked_of(name));
        const openfab_uniform* declared = nullptr;
        abi::Numbers numbers;
        int32_t of_one = 1;  // numbers
        bool placed = false;
        for (size_t i = 0; i < parts.size(); ++i) {
            if (parts[i].name != object) continue;
            placed = true;
            declared = find_uniform(*parts[i].fablet, element.name);
            if (declared == nullptr) break;
            const bool curve = declared->kind == OPENFAB_UNIFORM_CURVE;
            const int32_t length = curve ? abi::kCurveKeys : declared->array_length;
            if (element.index >= length)
                return no_derivative(name,
                                     fmt::format(messages::kRateBeyond, element.name, length));
            of_one = curve ? abi::curve_channels(declared->components) : declared->components;
            numbers = abi::numbers_of(element, of_one, length);
            const openfab_uniform* key =
                curve ? find_uniform(*parts[i].fablet, asked_of(name)) : nullptr;
            const std::span<const int32_t> directions = directions_of(*parts[i].fablet);
            for (int32_t k = 0; k < numbers.count; ++k) {
                const int32_t direction = !curve ? declared->first_index + numbers.first + k
                                          : key != nullptr
                                              ? key->first_index + k * declared->components
                                              : -1;
                const auto at = std::ranges::find(directions, direction);
                if (at == directions.end())
                    return no_derivative(name,
                                         fmt::format(messages::kRateOfType, declared->type_name));
                out.of_parts[i][static_cast<size_t>(at - directions.begin())] = out.columns + k;
            }
        }
        if (!placed) return no_derivative(name, fmt::format(messages::kRateOfNone, object));
        if (declared == nullptr)
            return no_derivative(name, fmt::format(messages::kRateUndeclared, element.name));
        columns->push_back({name, out.columns, of_one,
                            element.index < 0 ? declared->array_length : 1, declared->type_name});
        out.columns += numbers.count;
    }
    return out;
}

}  // namespace openfab::program
