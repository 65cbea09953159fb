// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/stage_arguments.h"

#include <algorithm>
#include <bit>
#include <variant>

namespace openfab::testing {

namespace {

/// Returns the texels, info or min-max values of the texture that `arg` names.
void set_texture(const openfab_arg& arg, const StageInputs& inputs, abi::KernelBuffer* buffer) {
    const TestTexture& t = inputs.textures.at(static_cast<size_t>(arg.a));
    const bool info = arg.b == OPENFAB_TEXTURE_INFO;
    const auto& floats = arg.b == OPENFAB_TEXTURE_TEXELS ? t.texels : t.minmax;
    const void* data = info ? static_cast<const void*>(t.info.data()) : floats.data();
    buffer->set_dense(abi::halide_type(arg.scalar), data,
                      {static_cast<int32_t>(info ? t.info.size() : floats.size())});
}

}  // namespace

bool is_scalar(int32_t kind) {
    return kind == OPENFAB_ARG_UNIFORM || kind == OPENFAB_ARG_FRAME ||
           kind == OPENFAB_ARG_INSTANCE || kind == OPENFAB_ARG_BLOCK_SIZE;
}

const std::vector<uint32_t>& object_values(const StageInputs& inputs,
                                           std::deque<std::vector<uint32_t>>* kept) {
    std::vector<uint32_t>& out = kept->emplace_back();
    for (const auto& [key, bits] : inputs.values) {
        if (key[0] != OPENFAB_ARG_UNIFORM) continue;
        const auto a = static_cast<size_t>(key[1]);
        if (out.size() <= a) out.resize(a + 1, 0x7fc00000u);
        out[a] = bits[0];
    }
    return out;
}

const void* input_argument(const openfab_arg& arg, const StageInputs& inputs,
                           const std::vector<int32_t>& columns, size_t count,
                           std::deque<abi::KernelBuffer>* buffers,
                           std::deque<std::vector<uint32_t>>* kept) {
    if (is_scalar(arg.kind)) return inputs.values.at({arg.kind, arg.a, arg.b}).data();
    abi::KernelBuffer& buffer = buffers->emplace_back();
    const halide_type_t type = abi::halide_type(arg);
    if (arg.kind == OPENFAB_ARG_VALUES) {
        const std::vector<uint32_t>& values = object_values(inputs, kept);
        buffer.set_dense(type, values.data(), {static_cast<int32_t>(values.size())});
    } else if (arg.kind == OPENFAB_ARG_TEXTURE) {
        set_texture(arg, inputs, &buffer);
    } else if (arg.kind == OPENFAB_ARG_BLOCKS) {
        buffer.set_dense(type, inputs.values.at({arg.kind, 0, 0}).data(), {3, inputs.elements});
    } else if (arg.kind == OPENFAB_ARG_GROUPS) {
        buffer.set_dense(type, columns.data(), {static_cast<int32_t>(columns.size())});
    } else {
        buffer.set_dense(type, inputs.values.at({arg.kind, arg.a, arg.b}).data(),
                         {static_cast<int32_t>(count)});
    }
    return buffer.raw();
}

std::unique_ptr<lower::LoadedProgram> load_stages(const passes::KernelStages& stages,
                                                  const lower::ProgramOptions& options) {
    ir::Fablet fablet;
    fablet.name = "Test";
    fablet.has_shape = !stages.shape.outputs.empty() || !stages.shape_attributes.outputs.empty() ||
                       !stages.shape_bounds.outputs.empty();
    auto loaded = lower::load_program({{&fablet, &stages, "test.fl", 1}}, options);
    if (auto* fault = std::get_if<lower::Fault>(&loaded)) {
        ADD_FAILURE() << fault->trouble
                      << (fault->schedule ? fault->schedule->message + fault->schedule->help : "");
        return nullptr;
    }
    return std::move(std::get<0>(loaded));
}

const void* SegmentHost::input(const openfab_arg& arg) {
    if (is_scalar(arg.kind)) return inputs_.values.at({arg.kind, arg.a, arg.b}).data();
    abi::KernelBuffer& buffer = buffers_.emplace_back();
    const halide_type_t type = abi::halide_type(arg.scalar);
    if (arg.kind == OPENFAB_ARG_VALUES) {
        const std::vector<uint32_t>& values = object_values(inputs_, &padded_);
        buffer.set_dense(type, values.data(), {static_cast<int32_t>(values.size())});
    } else if (arg.kind == OPENFAB_ARG_TEXTURE) {
        set_texture(arg, inputs_, &buffer);
    } else if (arg.kind == OPENFAB_ARG_BLOCKS) {
        buffer.set_dense(type, inputs_.values.at({arg.kind, 0, 0}).data(), {3, inputs_.elements});
    } else {
        std::vector<uint32_t>& padded =
            padded_.emplace_back(inputs_.values.at({arg.kind, arg.a, arg.b}));
        padded.resize(elements_, 0x7fc00000u);
        buffer.set_dense(type, padded.data(), {static_cast<int32_t>(elements_)});
    }
    return buffer.raw();
}

segments::OutputView SegmentHost::output(const openfab_arg& arg) {
    const auto at = std::ranges::find_if(stage_outputs_, [&](const ir::Output& o) {
        return o.kind == arg.kind && o.a == arg.a && o.b == arg.b;
    });
    if (at == stage_outputs_.end()) {
        ADD_FAILURE() << "an output of kind " << arg.kind << " that is no state";
        return {};
    }
    std::vector<uint32_t>& values = (*outputs_)[static_cast<size_t>(at - stage_outputs_.begin())];
    return {values.data()};
}

abi::KernelStatus SegmentHost::query(const openfab_query& query, std::span<const int32_t> groups,
                                     const segments::States& states) {
    for (const int32_t group : groups) {
        for (int32_t i = 8 * group; i < 8 * group + 8; ++i) {
            const auto at = [&](int32_t k) { return std::bit_cast<float>(states[k][i]); };
            for (int32_t k = 0; k < query.output_count; ++k) {
                const openfab_query_output& out = query.outputs[k];
                states[out.state][i] =
                    states[query.guard][i] == 0
                        ? 0
                        : answer(out.kind, out.b, at(query.point[0]), at(query.point[1]),
                                 at(query.point[2]), query.stop < 0 ? 0 : at(query.stop),
                                 query.seed < 0 ? 0 : states[query.seed][i]);
            }
        }
    }
    return {};
}

}  // namespace openfab::testing
