// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/cost.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace openfab::program {

namespace {

/// Returns the number for a material: by its name, its channel, or that of the others.
std::optional<double> number_of(const world::ByMaterial& numbers,
                                const pipeline::SliceMaterial& material) {
    for (const std::string& name : {material.name, material.channel}) {
        const auto found = numbers.named.find(name);
        if (found != numbers.named.end()) return found->second;
    }
    return numbers.others;
}

/// Passes of the head in a layer.
int64_t passes_a_layer(const world::Cost& cost, const pipeline::PrintInfo& info) {
    if (cost.swath_mm <= 0) return cost.passes;
    constexpr double kSlack = 1e-9;  // of a size that is a whole number of swaths
    const double swaths = std::ceil(info.size.y * info.pitch_mm.y / cost.swath_mm - kSlack);
    return static_cast<int64_t>(std::max(swaths, 1.0)) * cost.passes;
}

}  // namespace

double print_seconds(const world::Printer& printer, const pipeline::PrintInfo& info,
                     int32_t slices) {
    const std::optional<world::Cost>& cost = printer.process.cost;
    if (!cost || (cost->seconds_pass <= 0 && !cost->seconds_layer))
        return printer.layer_time_s * slices;
    return slices * (cost->seconds_layer.value_or(0) +
                     static_cast<double>(passes_a_layer(*cost, info)) * cost->seconds_pass);
}

std::optional<pipeline::PrintCost> print_cost(const world::Printer& printer,
                                              const pipeline::PrintInfo& info, int32_t slices,
                                              const std::vector<double>& ml_by_code) {
    if (!printer.process.cost) return std::nullopt;
    const world::Cost& cost = *printer.process.cost;
    pipeline::PrintCost out;
    out.currency = cost.currency;
    out.passes = passes_a_layer(cost, info) * slices;
    out.seconds = print_seconds(printer, info, slices);
    for (size_t code = 1; code < ml_by_code.size(); ++code) {
        const pipeline::SliceMaterial& material = info.materials[code - 1];
        pipeline::MaterialCost line{material.name, ml_by_code[code], 0, {}};
        if (line.ml > 0)
            line.waste_ml = static_cast<double>(out.passes) *
                            number_of(cost.waste_ml_swath, material).value_or(0);
        if (const std::optional<double> price = number_of(cost.price_ml, material)) {
            line.money = *price * (line.ml + line.waste_ml);
            out.money += *line.money;
        }
        out.materials.push_back(std::move(line));
    }
    return out;
}

void add_cost(const world::Printer& printer, const pipeline::PrintInfo& info,
              pipeline::PrintStatistics* statistics) {
    const double voxel_ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    statistics->print_seconds = print_seconds(printer, info, statistics->slices);
    statistics->cost = print_cost(printer, info, statistics->slices,
                                  ml_by_code(statistics->voxels_by_code, voxel_ml));
}

std::vector<double> ml_by_code(const std::vector<int64_t>& voxels_by_code, double voxel_ml) {
    std::vector<double> ml;
    for (const int64_t voxels : voxels_by_code)
        ml.push_back(static_cast<double>(voxels) * voxel_ml);
    return ml;
}

}  // namespace openfab::program
