// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The slopes of goals: of amounts, by derivatives of fractions.
#include <algorithm>
#include <set>
#include <utility>

#include "program/rates.h"
#include "tools/fit/print_values.h"

namespace openfab::fit {

namespace {

/// From as many unknowns on the kernels with derivatives are worth their compilation: each takes an evaluation otherwise.
constexpr std::ptrdiff_t kLeastUnknowns = 4;

/// Of an amount, of how it changes with those of materials.
double slope_of(const Goal& goal, const std::vector<world::Material>& materials,
                const std::vector<double>& ml, std::span<const double> change_ml) {
    double all = 0, of = 0, all_change = 0, of_change = 0;
    for (size_t m = 0; m < materials.size(); ++m) {
        const double weight = goal.quantity == Quantity::kWeight ? materials[m].density_g_cm3 : 1;
        const bool counts = goal.material < 0 || static_cast<size_t>(goal.material) == m;
        all += ml[m] * weight;
        all_change += change_ml[m] * weight;
        if (!counts) continue;
        of += ml[m] * weight;
        of_change += change_ml[m] * weight;
    }
    if (goal.quantity != Quantity::kShare) return of_change;
    return all > 0 ? (of_change - of / all * all_change) / all : 0;
}

}  // namespace

Result<void> PrintValues::set_up_slopes() {
    const auto is_linear = [](const Goal& goal) {
        return goal.quantity == Quantity::kShare || goal.quantity == Quantity::kVolume ||
               goal.quantity == Quantity::kWeight;
    };
    const auto moving = std::ranges::count_if(
        goals_.unknowns, [](const Unknown& unknown) { return !unknown.is_discrete(); });
    if (moving < kLeastUnknowns || !std::ranges::all_of(goals_.goals, is_linear)) return {};
    std::set<std::string> elements, names;
    for (const Unknown& unknown : goals_.unknowns) {
        if (unknown.is_discrete()) continue;
        elements.insert(unknown.element);
        names.insert(unknown.object + "." + unknown.element);
    }
    auto out = std::make_unique<Slopes>();
    out->compiled = workload_->compile_derivatives({elements.begin(), elements.end()});
    if (out->compiled == nullptr) return {};
    const openfab_fablet_list& fablets = out->compiled->program->fablets();
    const auto directions_of = [&](const openfab_fablet& fablet) {
        int32_t k = 0;
        while (fablets.fablets[k] != &fablet)
            ++k;
        return std::span<const int32_t>(out->compiled->directions[static_cast<size_t>(k)]);
    };
    for (const auto& [object, regions] : regions_by_object()) {
        program::Options print = print_;
        print.only_object = object.empty() ? print_.only_object : object;
        std::vector<program::RateColumns> columns;
        bool none = false;
        auto kept =
            program::KeptPrint::create(print, fablets, interrupt_, [&](const program::Job& job) {
                columns.clear();
                auto rates =
                    program::find_rates(job, {names.begin(), names.end()}, directions_of, &columns);
                none = !rates;
                return rates;
            });
        // Such as effects of a process, which mix what lies side by side.
        if (none) return {};
        if (!kept) return kept.error();
        out->prints[object] = std::move(*kept);
        out->columns.clear();
        out->scales.clear();
        for (const program::RateColumns& of : columns) {
            const auto all = static_cast<size_t>(of.first + of.components * of.array_length);
            out->scales.resize(std::max(out->scales.size(), all));
        }
        for (const Unknown& unknown : goals_.unknowns) {
            out->columns.push_back(-1);
            if (unknown.is_discrete()) continue;
            const auto of = std::ranges::find(columns, unknown.object + "." + unknown.element,
                                              &program::RateColumns::name);
            out->columns.back() = of->first + unknown.number;
            out->scales[static_cast<size_t>(out->columns.back())] = unknown.max - unknown.min;
        }
    }
    slopes_ = std::move(out);
    return {};
}

Result<std::vector<double>> PrintValues::slopes(const std::vector<double>& unknowns) {
    const std::vector<std::string> settings = settings_of(unknowns);
    const std::vector<world::Material>& materials = kept_->world().materials;
    std::vector<program::RegionRates> by_region(goals_.regions.size());
    for (const auto& [object, regions] : regions_by_object()) {
        std::vector<program::SumRegion> asked;
        for (const size_t r : regions)
            asked.push_back(goals_.regions[r].voxels);
        auto rates = slopes_->prints.at(object)->rates(settings, asked, program::SumPitch::kCoarse,
                                                       slopes_->scales);
        if (!rates) return rates.error();
        for (size_t k = 0; k < regions.size(); ++k)
            by_region[regions[k]] = std::move((*rates)[k]);
    }
    std::vector<double> out;
    for (const Goal& goal : goals_.goals) {
        const program::RegionRates& of = by_region[goal.region];
        const size_t count = of.mixed_ml.size();
        for (const int32_t column : slopes_->columns) {
            if (column < 0) continue;
            out.push_back(slope_of(
                goal, materials, of.mixed_ml,
                std::span(of.change_ml).subspan(static_cast<size_t>(column) * count, count)));
        }
    }
    return out;
}

}  // namespace openfab::fit
