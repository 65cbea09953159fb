// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The slab kernel of a volume stage against the twin of normalise.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <deque>

#include "abi/nearest_stage.h"
#include "abi/stages.h"
#include "tests/exec/compiled_stage.h"
#include "tests/exec/stage_arguments.h"
#include "tests/support/reference/dither.h"

namespace openfab::testing {

namespace {

/// The stage with those of its outputs that can be amounts, numbered anew.
ir::Stage with_float_outputs(const ir::Stage& stage, const StageResults& all,
                             StageResults* amounts) {
    ir::Stage out = stage;
    out.outputs.clear();
    for (size_t k = 0; k < stage.outputs.size(); ++k) {
        if (stage.instrs[stage.outputs[k].value].type != ir::Type::kFloat) continue;
        out.outputs.push_back(stage.outputs[k]);
        out.outputs.back().a = static_cast<int32_t>(amounts->size());
        amounts->push_back(all[k]);
    }
    ir::drop_dead_values(&out);
    return out;
}

/// The outputs of a slab kernel.
struct SlabResults {
    std::vector<uint8_t> codes;
    std::vector<uint16_t> unusable;
    std::vector<std::vector<uint16_t>> fractions;  ///< of each channel, columns 16 values apart
};

/// Answers from a test's inputs, with noise where a voxel needs none.
struct InputSource : openfab_nearest_source {
    InputSource(const openfab_fablet& of, const StageInputs& from,
                const std::vector<int32_t>& listed)
        : openfab_nearest_source{answer_request}, fablet(of), inputs(from), columns(listed) {}

    static int answer_request(openfab_nearest_source* source,
                              const openfab_nearest_request* request) {
        const auto& self = *static_cast<InputSource*>(source);
        for (int32_t i = 0; i < request->count; ++i) {
            const size_t index = static_cast<size_t>(request->first + i);
            if (index >= self.columns.size()) break;
            for (int32_t f = 0; f < self.fablet.field_count; ++f) {
                const openfab_arg& arg = self.fablet.fields[f];
                float* to =
                    request->results + i * request->column_stride + f * request->field_stride;
                for (int32_t z = 0; z < 8; ++z) {
                    uint32_t bits = self.inputs.values.at(
                        {arg.kind, arg.a, arg.b})[static_cast<size_t>(8 * self.columns[index] + z)];
                    if (request->demand[i * request->demand_stride + z] == 0) bits ^= 0x2545f491u;
                    std::memcpy(to + z, &bits, sizeof(bits));
                }
            }
        }
        return 0;
    }

    const openfab_fablet& fablet;
    const StageInputs& inputs;
    const std::vector<int32_t>& columns;
};

/// After the segments of the fablet, if it has any.
SlabResults run_slab(const openfab_fablet& fablet, openfab_isa isa, const StageInputs& inputs,
                     const std::vector<int32_t>& columns, const abi::Channels& channels) {
    const openfab_kernel& kernel = fablet.slab;
    const size_t voxels = static_cast<size_t>(inputs.elements) * kVoxels;
    SegmentHost host(inputs, voxels);
    segments::Driver driver;
    if (fablet.volume_segments.step_count > 0) {
        // Other columns have no state to read.
        std::vector<uint8_t> wanted(voxels / 8, 0);
        for (const int32_t column : columns)
            wanted[static_cast<size_t>(column)] = 255;
        EXPECT_TRUE(driver.run(fablet.volume_segments, isa, wanted, &host, &host).ok());
    }
    InputSource source(fablet, inputs, columns);
    openfab_nearest_source* const source_address = &source;
    SlabResults out;
    std::deque<std::vector<uint32_t>> kept;
    const size_t m = columns.size();
    const auto outputs = static_cast<size_t>(channels.count()) + 2;
    std::vector<uint16_t> packed(8 * outputs * m);
    out.codes.resize(8 * m);
    out.unusable.resize(8 * m);
    out.fractions.assign(static_cast<size_t>(channels.count()), std::vector<uint16_t>(16 * m));
    std::deque<abi::KernelBuffer> buffers;
    abi::KernelCall call(kernel, isa);
    for (int32_t k = 0; k < kernel.arg_count; ++k) {
        const openfab_arg& arg = kernel.args[k];
        const halide_type_t type = abi::halide_type(arg);
        const auto count = static_cast<int32_t>(m);
        if (arg.kind == OPENFAB_ARG_NEAREST_SOURCE) {
            call.set(k, &source_address);
            continue;
        }
        if (arg.kind == OPENFAB_ARG_STATE) {
            abi::KernelBuffer& buffer = buffers.emplace_back();
            buffer.set_dense(type, driver.states()[arg.a], {static_cast<int32_t>(voxels)});
            call.set(k, buffer.raw());
            continue;
        }
        if (arg.kind < OPENFAB_ARG_CHANNELS) {
            call.set(k, input_argument(arg, inputs, columns, voxels, &buffers, &kept));
            continue;
        }
        abi::KernelBuffer& buffer = buffers.emplace_back();
        if (arg.kind == OPENFAB_ARG_VALUES) {
            const std::vector<uint32_t>& values = object_values(inputs, &kept);
            buffer.set_dense(type, values.data(), {static_cast<int32_t>(values.size())});
        }
        if (kernel.packed != 0 && arg.kind == OPENFAB_ARG_CODE) {
            buffer.set_dense({halide_type_uint, 16, 1}, packed.data(),
                             {8, static_cast<int32_t>(outputs), count});
            call.set(k, buffer.raw());
            break;
        }
        if (arg.kind == OPENFAB_ARG_CHANNELS)
            buffer.set_dense(type, channels.table(), {OPENFAB_CHANNEL_ROWS, channels.count()});
        if (arg.kind == OPENFAB_ARG_CODE) buffer.set_columns(type, out.codes.data(), count);
        if (arg.kind == OPENFAB_ARG_UNUSABLE) buffer.set_columns(type, out.unusable.data(), count);
        if (arg.kind == OPENFAB_ARG_FRACTION)
            buffer.set_columns(type, out.fractions[arg.a].data(), count, 16);
        call.set(k, buffer.raw());
    }
    EXPECT_TRUE(call.run().ok());
    for (size_t i = 0; i < 8 * m && kernel.packed != 0; ++i) {
        const uint16_t* from = &packed[i / 8 * 8 * outputs + i % 8];
        out.codes[i] = static_cast<uint8_t>(from[0]);
        out.unusable[i] = from[8];
        for (size_t c = 0; c < out.fractions.size(); ++c)
            out.fractions[c][i / 8 * 16 + i % 8] = from[8 * (2 + c)];
    }
    return out;
}

}  // namespace

ir::Stage slab_stage(const ir::Stage& stage) {
    StageResults none;
    return with_float_outputs(stage, StageResults(stage.outputs.size()), &none);
}

void expect_equal_slab(const ir::Stage& stage, const StageResults& expected,
                       const StageInputs& inputs, const lower::ProgramOptions& options,
                       const ir::Stage* demand) {
    StageResults amounts;
    passes::KernelStages stages;
    stages.volume = with_float_outputs(stage, expected, &amounts);
    if (passes::needs_segments(stages.volume)) {
        stages.volume_segments = passes::cut_segments(stages.volume);
    } else if (demand != nullptr) {
        stages.volume_demand = *demand;
    }
    const std::unique_ptr<lower::LoadedProgram> program = load_stages(stages, options);
    if (program == nullptr) return;
    constexpr int32_t kMaterials = 2;
    std::vector<int32_t> materials, columns;
    for (size_t s = 0; s < amounts.size(); ++s)
        materials.push_back(static_cast<int32_t>((5 * s + 2) % (kMaterials + 1)));
    // Not all of them, and not in order.
    for (int32_t c = inputs.elements * kVoxels / 8; c-- > 0;) {
        if (c % 5 != 3) columns.push_back(c);
    }
    while (columns.size() % OPENFAB_LISTED_COLUMNS != 0)
        columns.push_back(columns.back());
    const abi::Channels channels(materials);
    for (const openfab_isa isa : options.isas) {
        const SlabResults got =
            run_slab(*program->fablets().fablets[0], isa, inputs, columns, channels);
        for (size_t i = 0; i < 8 * columns.size(); ++i) {
            const size_t voxel = static_cast<size_t>(8 * columns[i / 8]) + i % 8;
            std::vector<float> weights;
            for (const std::vector<uint32_t>& of_slot : amounts)
                weights.push_back(std::bit_cast<float>(of_slot[voxel]));
            int64_t unusable = 0;
            const std::vector<uint16_t> fractions =
                reference::normalise(weights, materials, kMaterials, &unusable);
            const auto pure = std::find(fractions.begin(), fractions.end(), 65535);
            const auto code =
                pure == fractions.end() ? int64_t{OPENFAB_CODE_MIXED} : pure - fractions.begin();
            ASSERT_EQ(got.codes[i], code) << "voxel " << voxel;
            ASSERT_EQ(got.unusable[i], unusable) << "voxel " << voxel;
            for (int32_t c = 0; c < channels.count(); ++c) {
                const int32_t material = channels.material(c);
                if (material < 0) continue;
                const size_t at = i / 8 * 16 + i % 8;
                ASSERT_EQ(got.fractions[c][at], fractions[material]) << "voxel " << voxel;
            }
        }
    }
}

}  // namespace openfab::testing
