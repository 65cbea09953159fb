// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/fablet_data.h"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "compiler/ir/choices.h"
#include "compiler/lower/algorithm/args.h"
#include "compiler/lower/code/compile.h"

namespace openfab::lower {

SlabStages stages_inside_slab(const passes::KernelStages& stages) {
    SlabStages out;
    out.after_segments = !stages.volume_segments.steps.empty();
    if (!out.after_segments && !stages.volume_demand.outputs.empty())
        out.demand = &stages.volume_demand;
    if (!stages.dither.outputs.empty()) out.dither = &stages.dither;
    return out;
}

std::vector<KernelSlot> kernel_slots(const passes::KernelStages& stages) {
    std::vector<KernelSlot> out;
    const auto add = [&](const ir::Stage& stage, openfab_kernel openfab_fablet::*kernel) {
        if (stage.outputs.empty()) return;
        out.push_back({&stage, {}, kernel, nullptr, 0, schedule_name(stage.kind)});
    };
    const auto add_segments = [&](const passes::SegmentedStage& segmented,
                                  openfab_segments openfab_fablet::*segments) {
        for (size_t k = 0; k < segmented.kernels.size(); ++k) {
            const ir::Stage& stage = segmented.kernels[k];
            out.push_back({&stage,
                           {},
                           nullptr,
                           segments,
                           k,
                           fmt::format("{}{}", schedule_name(stage.kind), k)});
        }
    };
    if (stages.surface_segments.steps.empty()) add(stages.surface, &openfab_fablet::surface);
    add_segments(stages.surface_segments, &openfab_fablet::surface_segments);
    add(stages.surface_bounds, &openfab_fablet::surface_bounds);
    const SlabStages inside = stages_inside_slab(stages);
    const bool slab = !stages.slab().outputs.empty();
    add(stages.slab(), &openfab_fablet::slab);
    if (slab) out.back().inside = inside;
    add_segments(stages.volume_segments, &openfab_fablet::volume_segments);
    add(stages.volume_bounds, &openfab_fablet::volume_bounds);
    add(stages.derived, &openfab_fablet::derived);
    if (!slab || inside.after_segments) add(stages.volume_demand, &openfab_fablet::volume_demand);
    const auto add_of_shape = [&](const ir::Stage& stage, const passes::SegmentedStage& segmented,
                                  openfab_kernel openfab_shape::*kernel,
                                  openfab_segments openfab_shape::*segments) {
        const std::string name = schedule_name(stage.kind);
        for (size_t k = 0; k < segmented.kernels.size(); ++k) {
            KernelSlot& slot = out.emplace_back();
            slot.stage = &segmented.kernels[k];
            slot.segment = k;
            slot.name = fmt::format("{}_segment{}", name, k);
            slot.shape_segments = segments;
        }
        if (!segmented.kernels.empty() || stage.outputs.empty()) return;
        KernelSlot& slot = out.emplace_back();
        slot.stage = &stage;
        slot.name = name;
        slot.shape_kernel = kernel;
    };
    add_of_shape(stages.shape, stages.shape_segments, &openfab_shape::values,
                 &openfab_shape::value_segments);
    add_of_shape(stages.shape_attributes, stages.shape_attribute_segments,
                 &openfab_shape::attributes, &openfab_shape::attribute_segments);
    add_of_shape(stages.shape_bounds, {}, &openfab_shape::bounds, nullptr);
    return out;
}

const uint32_t* FabletData::keep_bits(const std::vector<uint32_t>& bits) {
    return bits.empty() ? nullptr : bits_.emplace_back(bits).data();
}

const double* FabletData::keep_limits(const ir::Uniform& uniform) {
    const std::optional<std::array<double, 2>> limits = ir::limits(uniform);
    return limits ? limits_.emplace_back(*limits).data() : nullptr;
}

const openfab_varying* FabletData::keep_varyings(const std::vector<ir::Varying>& varyings) {
    std::vector<openfab_varying>& out = varyings_.emplace_back();
    for (const ir::Varying& v : varyings) {
        out.push_back({keep(v.name), keep(v.type_name), scalar_type(v.type), v.components, v.source,
                       keep_bits(v.default_bits)});
    }
    return out.data();
}

openfab_kernel FabletData::make_kernel_entry(const ir::Stage& stage, const SlabStages& inside) {
    const KernelArgs collected = collect_args(stage, inside);
    const std::vector<openfab_arg>& args = args_.emplace_back(collected.all());
    return {{}, static_cast<int32_t>(args.size()), args.data(), collected.packed ? 1 : 0};
}

openfab_segments FabletData::make_segments(const passes::SegmentedStage& segmented) {
    std::vector<openfab_kernel>& kernels = kernels_.emplace_back();
    for (const ir::Stage& stage : segmented.kernels)
        kernels.push_back(make_kernel_entry(stage));
    std::vector<openfab_query>& queries = queries_.emplace_back();
    for (const passes::SegmentQuery& q : segmented.queries) {
        const auto& outputs = query_outputs_.emplace_back(q.outputs);
        queries.push_back({q.object,
                           q.guard,
                           {q.point[0], q.point[1], q.point[2]},
                           q.stop,
                           q.seed,
                           static_cast<int32_t>(outputs.size()),
                           outputs.data()});
    }
    std::vector<openfab_printf>& printfs = printfs_.emplace_back();
    for (const passes::SegmentPrintf& p : segmented.printfs) {
        const auto& values = values_.emplace_back(p.values);
        printfs.push_back({keep(p.call.format), p.call.is_assert ? 1 : 0, keep(p.call.source),
                           p.call.line, p.call.column, p.guard, static_cast<int32_t>(values.size()),
                           values.data()});
    }
    std::vector<openfab_scalar_type>& states = states_.emplace_back();
    for (const ir::Type type : segmented.states)
        states.push_back(scalar_type(type));
    const auto& steps = steps_.emplace_back(segmented.steps);
    const auto& elements = elements_.emplace_back(segmented.elements);
    const auto count = [](const auto& list) { return static_cast<int32_t>(list.size()); };
    return {count(steps),   steps.data(),   count(kernels),  kernels.data(),
            count(queries), queries.data(), count(printfs),  printfs.data(),
            count(states),  states.data(),  count(elements), elements.data()};
}

FabletData::FabletData(const FabletUnit& unit) {
    const ir::Fablet& fablet = *unit.fablet;
    for (const ir::Uniform& u : fablet.uniforms) {
        const std::string choices = ir::choices(u);
        const char* type = keep(choices.empty() ? u.type_name : u.type_name + "\n" + choices);
        uniforms_.push_back({keep(u.name), type, u.kind, scalar_type(u.type), u.components,
                             u.array_length, u.first_index, keep_bits(u.default_bits),
                             keep_limits(u)});
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
    table_.has_dither = fablet.has_dither ? 1 : 0;
    table_.has_surface = fablet.has_surface ? 1 : 0;
    table_.surface_input_count = static_cast<int32_t>(fablet.surface_inputs.size());
    table_.surface_inputs = keep_varyings(fablet.surface_inputs);
    table_.surface_output_count = static_cast<int32_t>(fablet.surface_outputs.size());
    table_.surface_outputs = keep_varyings(fablet.surface_outputs);
    table_.nearest_count = static_cast<int32_t>(fablet.nearest.size());
    table_.nearest = keep_varyings(fablet.nearest);
    const passes::KernelStages& stages = *unit.stages;
    for (const KernelSlot& slot : kernel_slots(stages)) {
        if (slot.kernel != nullptr)
            table_.*slot.kernel = make_kernel_entry(*slot.stage, slot.inside);
    }
    table_.derived_count = static_cast<int32_t>(stages.derived.outputs.size());
    table_values_ = stages.table_values;
    table_.table_value_count = static_cast<int32_t>(table_values_.size());
    table_.table_values = table_values_.empty() ? nullptr : table_values_.data();
    const std::vector<openfab_arg>& fields = args_.emplace_back(collect_fields(stages.volume));
    table_.field_count = static_cast<int32_t>(fields.size());
    table_.fields = fields.data();
    // The table holds the argument list of a segmented surface stage, too.
    if (!stages.surface_segments.steps.empty()) {
        table_.surface = make_kernel_entry(stages.surface);
        table_.surface_segments = make_segments(stages.surface_segments);
    }
    if (!stages.volume_segments.steps.empty())
        table_.volume_segments = make_segments(stages.volume_segments);
    if (fablet.has_shape) make_shape(fablet, stages);
}

void FabletData::make_shape(const ir::Fablet& fablet, const passes::KernelStages& stages) {
    shape_.is_distance = fablet.shape_is_distance ? 1 : 0;
    shape_.output_count = static_cast<int32_t>(fablet.shape_outputs.size());
    shape_.outputs = keep_varyings(fablet.shape_outputs);
    // Of a segmented stage, too: these are the buffers of its batch.
    shape_.values = make_kernel_entry(stages.shape);
    if (!stages.shape_attributes.outputs.empty())
        shape_.attributes = make_kernel_entry(stages.shape_attributes);
    if (!stages.shape_bounds.outputs.empty())
        shape_.bounds = make_kernel_entry(stages.shape_bounds);
    if (!stages.shape_segments.steps.empty())
        shape_.value_segments = make_segments(stages.shape_segments);
    if (!stages.shape_attribute_segments.steps.empty())
        shape_.attribute_segments = make_segments(stages.shape_attribute_segments);
    table_.shape = &shape_;
}

}  // namespace openfab::lower
