// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/process.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "program/messages.h"
#include "runtime/pipeline/slab_parts.h"
#include "runtime/process/kinds/kinds.h"

namespace openfab::program {

Result<void> load_process_options(const Options& options, world::Printer* printer) {
    if (!options.process_file.empty()) {
        Result<world::Process> process =
            world::load_process(options.process_file, printer->process);
        if (!process) return process.error();
        printer->process = std::move(*process);
    }
    // Mistakes are told before the parts are bound, which may take long.
    if (const auto effects = process::read_effects(printer->process); !effects)
        return effects.error();
    if (options.as_built) {
        // The machine undoes both.
        printer->process.scale = {1, 1, 1};
        printer->process.field.clear();
    }
    return {};
}

void scale_build(const world::Process& process, world::World* world, pipeline::PrintInput* input) {
    const Vec3d &scale = process.scale, &about = process.about_mm;
    if (scale == Vec3d{1, 1, 1}) return;
    for (world::Placement& placement : world->build) {
        Affine3d& to_build = placement.transform;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                to_build.m[static_cast<size_t>(3 * row + column)] *= scale[row];
            to_build.t[row] = about[row] + scale[row] * (to_build.t[row] - about[row]);
        }
    }
    input->process.emplace_back(
        "process scale", fmt::format("{} x {} x {} about {}, {}, {} mm", scale.x, scale.y, scale.z,
                                     about.x, about.y, about.z));
}

void warn_of_costs(const world::Process& process, pipeline::PrintInput* input) {
    if (!process.cost) return;
    const std::vector<process::PrintMaterial> materials = named_materials(*input);
    const auto warn_of = [&](const char* key, const world::ByMaterial& numbers) {
        if (numbers.others) return;
        std::string idle, without;
        for (const auto& [name, number] : numbers.named) {
            if (process::material_code(materials, name) == 0)
                idle += fmt::format("{}`{}`", idle.empty() ? "" : ", ", name);
        }
        for (const pipeline::SliceMaterial& material : input->materials) {
            if (numbers.named.contains(material.name) || numbers.named.contains(material.channel))
                continue;
            without += fmt::format("{}`{}`", without.empty() ? "" : ", ", material.name);
        }
        if (idle.empty() || without.empty()) return;
        input->warnings.push_back(fmt::format(messages::kCostIdle, key, idle, without));
    };
    warn_of("price_ml", process.cost->price_ml);
    warn_of("waste_ml_swath", process.cost->waste_ml_swath);
}

std::vector<process::PrintMaterial> named_materials(const pipeline::PrintInput& input) {
    std::vector<process::PrintMaterial> out;
    for (const pipeline::SliceMaterial& material : input.materials)
        out.push_back({material.name, material.channel});
    return out;
}

Result<std::vector<std::unique_ptr<process::Effect>>> open_effects(const Options& options,
                                                                   const world::Printer& printer,
                                                                   pipeline::PrintInput* input) {
    const auto materials = static_cast<int32_t>(input->materials.size());
    const process::Print print{
        printer,
        named_materials(*input),
        pipeline::model_materials(input->parts, materials, input->support_code),
        input->pitch_mm,
        options.altered.solid,
        options.as_built};
    auto effects =
        process::open_effects(print, options.effects, {&input->warnings, &input->process});
    if (!effects) return effects.error();
    for (const auto& effect : *effects) {
        if (effect->leaves_parts()) input->margin_vox = input->margin_vox + effect->reach();
    }
    return effects;
}

}  // namespace openfab::program
