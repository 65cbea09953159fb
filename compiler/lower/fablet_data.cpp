// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/fablet_data.h"

#include "compiler/lower/args.h"
#include "compiler/lower/compile.h"

namespace openfab::lower {

std::vector<KernelPlace> kernel_places(const passes::KernelStages& stages) {
    std::vector<KernelPlace> out;
    const auto add = [&](const ir::Stage& stage, openfab_kernel openfab_fablet::*kernel) {
        if (!stage.outputs.empty()) out.push_back({&stage, kernel, schedule_name(stage.kind)});
    };
    add(stages.surface, &openfab_fablet::surface);
    add(stages.surface_bounds, &openfab_fablet::surface_bounds);
    add(stages.volume, &openfab_fablet::volume);
    add(stages.volume_bounds, &openfab_fablet::volume_bounds);
    return out;
}

const uint32_t* FabletData::keep_bits(const std::vector<uint32_t>& bits) {
    return bits.empty() ? nullptr : bits_.emplace_back(bits).data();
}

const openfab_varying* FabletData::keep_varyings(const std::vector<ir::Varying>& varyings) {
    std::vector<openfab_varying>& out = varyings_.emplace_back();
    for (const ir::Varying& v : varyings) {
        out.push_back({keep(v.name), keep(v.type_name), scalar_type(v.type), v.components, v.source,
                       keep_bits(v.default_bits)});
    }
    return out.data();
}

openfab_kernel FabletData::make_kernel_entry(const ir::Stage& stage) {
    const std::vector<openfab_arg>& args = args_.emplace_back(collect_args(stage).all());
    return {{nullptr, nullptr}, static_cast<int32_t>(args.size()), args.data()};
}

FabletData::FabletData(const FabletUnit& unit) {
    const ir::Fablet& fablet = *unit.fablet;
    for (const ir::Uniform& u : fablet.uniforms) {
        uniforms_.push_back({keep(u.name), keep(u.type_name), u.kind, scalar_type(u.type),
                             u.components, u.array_length, u.first_index,
                             keep_bits(u.default_bits)});
    }
    table_.abi_version = OPENFAB_ABI_VERSION;
    table_.name = keep(fablet.name);
    table_.source_name = keep(unit.source_name);
    table_.hash = unit.hash;
    table_.uniform_count = static_cast<int32_t>(uniforms_.size());
    table_.uniforms = uniforms_.data();
    table_.uniform_value_count = fablet.uniform_value_count;
    table_.texture_count = fablet.texture_count;
    table_.object_count = fablet.object_count;
    table_.slot_count = fablet.slot_count;
    table_.void_slot = fablet.void_slot;
    table_.has_surface = fablet.has_surface ? 1 : 0;
    table_.surface_input_count = static_cast<int32_t>(fablet.surface_inputs.size());
    table_.surface_inputs = keep_varyings(fablet.surface_inputs);
    table_.surface_output_count = static_cast<int32_t>(fablet.surface_outputs.size());
    table_.surface_outputs = keep_varyings(fablet.surface_outputs);
    table_.nearest_count = static_cast<int32_t>(fablet.nearest.size());
    table_.nearest = keep_varyings(fablet.nearest);
    for (const KernelPlace& place : kernel_places(*unit.stages))
        table_.*place.kernel = make_kernel_entry(*place.stage);
}

}  // namespace openfab::lower
