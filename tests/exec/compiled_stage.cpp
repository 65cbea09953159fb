// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/compiled_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <numeric>

#include "compiler/interp/evaluate.h"
#include "runtime/segments/driver.h"
#include "tests/exec/stage_arguments.h"

namespace openfab::testing {

namespace {

constexpr uint32_t kUnwritten = 0xdeadbeefu;
constexpr size_t kMostReports = 5;

class ElementEnvironment : public interp::Environment {
  public:
    ElementEnvironment(const StageInputs& inputs, bool volume, size_t element)
        : inputs_(inputs), volume_(volume), element_(element) {}

    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        if (kind >= ir::kVoxelCoord) return voxel_coord(kind, a);
        const std::vector<uint32_t>& values = inputs_.values.at({kind, a, b});
        return values.at(is_scalar(kind) ? 0 : element_);
    }
    interp::TextureView texture(int32_t index) const override {
        const TestTexture& t = inputs_.textures.at(static_cast<size_t>(index));
        return {t.texels, t.info};
    }

    uint32_t query(const ir::Instr& /*query*/, const ir::Instr& result,
                   std::span<const uint32_t> args) const override {
        const auto at = [&](size_t k) { return std::bit_cast<float>(args[k]); };
        const bool walks = args.size() > 4;
        return answer(result.kind, result.b, at(1), at(2), at(3), walks ? at(4) : 0,
                      walks ? args[5] : 0);
    }

  private:
    uint32_t voxel_coord(int32_t kind, int32_t axis) const {
        const size_t block = volume_ ? element_ / kVoxels : element_;
        const auto& blocks = inputs_.values.at({OPENFAB_ARG_BLOCKS, 0, 0});
        auto index = static_cast<int32_t>(blocks.at(block * 3 + static_cast<size_t>(axis)));
        const size_t voxel = element_ % kVoxels;
        const std::array<size_t, 3> offset = {voxel / 8 % 8, voxel / 64, voxel % 8};
        if (kind == ir::kVoxelCoord)
            index += static_cast<int32_t>(offset.at(static_cast<size_t>(axis)));
        if (kind == ir::kVoxelCoordHi) {
            index += static_cast<int32_t>(inputs_.values.at({OPENFAB_ARG_BLOCK_SIZE, 0, 0})[0]) - 1;
        }
        return std::bit_cast<uint32_t>(static_cast<float>(index) + 0.5f);
    }

    const StageInputs& inputs_;
    bool volume_;
    size_t element_;
};

/// One element is a voxel.
bool of_voxels(ir::StageKind kind) {
    return kind == ir::StageKind::kVolume || kind == ir::StageKind::kVolumeDemand;
}

size_t element_count(const ir::Stage& stage, const StageInputs& inputs) {
    return static_cast<size_t>(inputs.elements) * (of_voxels(stage.kind) ? kVoxels : 1);
}

ir::Stage* member(passes::KernelStages* stages, ir::StageKind kind) {
    switch (kind) {
        case ir::StageKind::kSurface:
            return &stages->surface;
        case ir::StageKind::kSurfaceBounds:
            return &stages->surface_bounds;
        case ir::StageKind::kVolume:
            return &stages->volume;
        case ir::StageKind::kVolumeDemand:
            return &stages->volume_demand;
        case ir::StageKind::kShape:
            return &stages->shape;
        case ir::StageKind::kShapeAttributes:
            return &stages->shape_attributes;
        case ir::StageKind::kShapeBounds:
            return &stages->shape_bounds;
        default:
            break;
    }
    return &stages->volume_bounds;
}

const openfab_kernel& member(const openfab_fablet& fablet, ir::StageKind kind) {
    switch (kind) {
        case ir::StageKind::kSurface:
            return fablet.surface;
        case ir::StageKind::kSurfaceBounds:
            return fablet.surface_bounds;
        case ir::StageKind::kVolume:
            return fablet.slab;
        case ir::StageKind::kVolumeDemand:
            return fablet.volume_demand;
        case ir::StageKind::kShape:
            return fablet.shape->values;
        case ir::StageKind::kShapeAttributes:
            return fablet.shape->attributes;
        case ir::StageKind::kShapeBounds:
            return fablet.shape->bounds;
        default:
            break;
    }
    return fablet.volume_bounds;
}

/// Interprets a segmented stage for one voxel.
class SegmentWalk : public interp::Environment {
  public:
    SegmentWalk(const passes::SegmentedStage& segmented, const interp::Environment& outer)
        : segmented_(segmented), outer_(outer), states_(segmented.states.size(), 0) {
        states_[0] = 1;
    }

    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return kind == OPENFAB_ARG_STATE ? states_[a] : outer_.input(kind, a, b);
    }
    interp::TextureView texture(int32_t index) const override { return outer_.texture(index); }

    /// Returns the outputs by slot.
    std::map<int32_t, uint32_t> run() {
        for (size_t at = 0; at < segmented_.steps.size();) {
            const openfab_step& step = segmented_.steps[at++];
            const auto a = static_cast<size_t>(step.a);
            if (step.kind == OPENFAB_STEP_KERNEL) run_kernel(segmented_.kernels[a]);
            if (step.kind == OPENFAB_STEP_QUERY) run_query(segmented_.queries[a]);
            if (step.kind == OPENFAB_STEP_ELEMENTS) move(segmented_.elements[a]);
            const bool loop = step.kind == OPENFAB_STEP_LOOP;
            const bool end = step.kind == OPENFAB_STEP_LOOP_END;
            if ((loop && states_[a] == 0) || (end && states_[a] != 0)) {
                at = static_cast<size_t>(step.b);
            }
        }
        const std::vector<uint32_t> values = interp::evaluate(segmented_.last, *this);
        std::map<int32_t, uint32_t> out;
        for (size_t k = 0; k < values.size(); ++k)
            out[segmented_.last.outputs[k].a] = values[k];
        return out;
    }

  private:
    void run_kernel(const ir::Stage& kernel) {
        const std::vector<uint32_t> values = interp::evaluate(kernel, *this);
        for (size_t k = 0; k < values.size(); ++k)
            states_[kernel.outputs[k].a] = values[k];
    }
    void move(const openfab_elements& elements) {
        if (elements.guard >= 0 && states_[elements.guard] == 0) return;
        const auto each = [&](int32_t k) -> uint32_t& {
            return states_[elements.first + k * elements.apart];
        };
        const auto picked = [&]() -> uint32_t& {
            const auto index = static_cast<int32_t>(states_[elements.index]);
            return each(std::clamp(index, 0, elements.count - 1));
        };
        if (elements.kind == OPENFAB_ELEMENTS_LOAD) {
            states_[elements.value] = picked();
        } else if (elements.kind == OPENFAB_ELEMENTS_STORE) {
            picked() = states_[elements.value];
        } else {
            for (int32_t k = 0; k < elements.count; ++k)
                each(k) = states_[elements.value + k * elements.value_apart];
        }
    }
    void run_query(const passes::SegmentQuery& query) {
        const auto state = [&](int32_t k) { return states_[k]; };
        const auto at = [&](size_t k) { return std::bit_cast<float>(state(query.point[k])); };
        for (const openfab_query_output& out : query.outputs) {
            const float stop = query.stop < 0 ? 0 : std::bit_cast<float>(state(query.stop));
            const uint32_t seed = query.seed < 0 ? 0 : state(query.seed);
            states_[out.state] = state(query.guard) == 0
                                     ? 0
                                     : answer(out.kind, out.b, at(0), at(1), at(2), stop, seed);
        }
    }

    const passes::SegmentedStage& segmented_;
    const interp::Environment& outer_;
    std::vector<uint32_t> states_;
};

bool same(ir::Type type, uint32_t a, uint32_t b) {
    if (a == b) return true;
    return type == ir::Type::kFloat && std::isnan(std::bit_cast<float>(a)) &&
           std::isnan(std::bit_cast<float>(b));
}

}  // namespace

std::unique_ptr<CompiledStage> CompiledStage::make(const ir::Stage& stage,
                                                   const lower::ProgramOptions& options) {
    auto out = std::make_unique<CompiledStage>();
    out->stage_ = stage;
    out->isas_ = options.isas;
    passes::KernelStages stages;
    if (stage.kind == ir::StageKind::kVolume) {
        ir::Stage live = stage;
        ir::drop_dead_values(&live);
        for (size_t k = 0; k < live.outputs.size(); ++k)
            live.outputs[k].a = static_cast<int32_t>(k);
        stages.volume_segments =
            passes::cut_segments(live, passes::kMaxSegmentOperations, passes::Amounts::kStates);
    } else {
        *member(&stages, stage.kind) = stage;
        if (stage.kind == ir::StageKind::kShape && passes::needs_segments(stage))
            stages.shape_segments = passes::cut_segments(stage);
        if (stage.kind == ir::StageKind::kShapeAttributes && passes::needs_segments(stage))
            stages.shape_attribute_segments = passes::cut_segments(stage);
    }
    out->program_ = load_stages(stages, options);
    return out->program_ == nullptr ? nullptr : std::move(out);
}

StageResults CompiledStage::run(openfab_isa isa, const StageInputs& inputs) const {
    const openfab_fablet& fablet = *program_->fablets().fablets[0];
    const openfab_segments& segments = fablet.shape == nullptr ? fablet.volume_segments
                                       : stage_.kind == ir::StageKind::kShapeAttributes
                                           ? fablet.shape->attribute_segments
                                           : fablet.shape->value_segments;
    if (segments.step_count > 0) return run_segments(segments, isa, inputs);
    const openfab_kernel& kernel = member(*program_->fablets().fablets[0], stage_.kind);
    const size_t count = element_count(stage_, inputs);
    const size_t first_output = static_cast<size_t>(kernel.arg_count) - stage_.outputs.size();
    // One element beyond what the kernel may write.
    StageResults results(stage_.outputs.size(), std::vector<uint32_t>(count + 1, kUnwritten));
    std::vector<uint8_t> demand;
    std::vector<int32_t> columns((count + 7) / 8);
    std::iota(columns.begin(), columns.end(), 0);
    std::deque<abi::KernelBuffer> buffers;
    std::deque<std::vector<uint32_t>> kept;
    std::vector<uint32_t> packed(results.size() * count + 1, kUnwritten);
    abi::KernelCall call(kernel, isa);
    for (int32_t k = 0; k < kernel.arg_count; ++k) {
        const openfab_arg& arg = kernel.args[k];
        if (static_cast<size_t>(k) < first_output) {
            call.set(k, input_argument(arg, inputs, columns, count, &buffers, &kept));
            continue;
        }
        if (kernel.packed != 0) {
            abi::KernelBuffer& all = buffers.emplace_back();
            all.set_dense(abi::halide_type(OPENFAB_UINT), packed.data(),
                          {inputs.elements, static_cast<int32_t>(results.size())});
            call.set(k, all.raw());
            break;
        }
        abi::KernelBuffer& buffer = buffers.emplace_back();
        const uint32_t* data = results[static_cast<size_t>(k) - first_output].data();
        if (arg.kind == OPENFAB_ARG_DEMAND) {
            demand.resize(count);
            buffer.set_columns(abi::halide_type(arg), demand.data(),
                               static_cast<int32_t>(columns.size()));
        } else {
            buffer.set_dense(abi::halide_type(arg), data, {inputs.elements});
        }
        call.set(k, buffer.raw());
    }
    EXPECT_TRUE(call.run().ok());
    std::copy(demand.begin(), demand.end(), results[0].begin());
    EXPECT_EQ(packed.back(), kUnwritten) << "written past the end";
    for (size_t k = 0; k < results.size() && kernel.packed != 0; ++k)
        std::copy_n(&packed[k * count], count, results[k].begin());
    for (auto& result : results) {
        EXPECT_EQ(result.back(), kUnwritten) << "written past the end";
        result.pop_back();
    }
    return results;
}

StageResults CompiledStage::run_segments(const openfab_segments& segments, openfab_isa isa,
                                         const StageInputs& inputs) const {
    const size_t count = element_count(stage_, inputs);
    const size_t whole = (count + 7) / 8 * 8;
    StageResults written(stage_.outputs.size(), std::vector<uint32_t>(whole, kUnwritten));
    SegmentHost host(inputs, whole, stage_.outputs, &written);
    segments::Driver driver;
    const std::vector<uint8_t> wanted((count + 7) / 8, 255);
    EXPECT_TRUE(driver.run(segments, isa, wanted, &host, &host).ok());
    if (stage_.kind == ir::StageKind::kShape || stage_.kind == ir::StageKind::kShapeAttributes) {
        for (auto& result : written)
            result.resize(count);
        return written;
    }
    StageResults results;
    for (size_t k = 0; k < stage_.outputs.size(); ++k) {
        const uint32_t* values = driver.states()[1 + static_cast<int32_t>(k)];
        results.emplace_back(values, values + count);
    }
    return results;
}

uint32_t answer(int32_t kind, int32_t b, float x, float y, float z, float stop, uint32_t seed) {
    switch (kind) {
        case OPENFAB_QUERY_DISTANCE:
            return std::bit_cast<uint32_t>((x - y) * 0.5f + z);
        case OPENFAB_QUERY_ATTRIBUTE:
            return x > y ? 3u : 0xfffffff0u;
        case OPENFAB_QUERY_END:
            return std::bit_cast<uint32_t>(x + 2 * stop);
        case OPENFAB_QUERY_END_ON:
            return seed & (y > stop ? 3u : 5u);
        default:
            return std::bit_cast<uint32_t>(b == 1 ? y + 0.25f : x - 0.5f);
    }
}

StageResults interpret_segments(const ir::Stage& stage, const passes::SegmentedStage& segmented,
                                const StageInputs& inputs) {
    size_t count = element_count(stage, inputs);
    if (inputs.only > 0) count = std::min(count, inputs.only);
    StageResults results(stage.outputs.size(), std::vector<uint32_t>(count));
    for (size_t element = 0; element < count; ++element) {
        const ElementEnvironment environment(inputs, true, element);
        for (const auto& [slot, bits] : SegmentWalk(segmented, environment).run())
            results[slot][element] = bits;
    }
    return results;
}

StageResults interpret(const ir::Stage& stage, const StageInputs& inputs) {
    size_t count = element_count(stage, inputs);
    if (inputs.only > 0) count = std::min(count, inputs.only);
    StageResults results(stage.outputs.size(), std::vector<uint32_t>(count));
    for (size_t element = 0; element < count; ++element) {
        const ElementEnvironment environment(inputs, of_voxels(stage.kind), element);
        const std::vector<uint32_t> values = interp::evaluate(stage, environment);
        for (size_t k = 0; k < values.size(); ++k)
            results[k][element] = values[k];
    }
    return results;
}

void expect_equal(const ir::Stage& stage, const StageResults& expected, const StageResults& got,
                  const std::string& what) {
    ASSERT_EQ(expected.size(), got.size());
    size_t reports = 0;
    for (size_t k = 0; k < expected.size(); ++k) {
        const ir::Output& output = stage.outputs[k];
        const ir::Type type = stage.instrs[output.value].type;
        ASSERT_EQ(expected[k].size(), got[k].size());
        for (size_t element = 0; element < expected[k].size(); ++element) {
            if (same(type, expected[k][element], got[k][element])) continue;
            ADD_FAILURE() << what << ": " << output.name << " at element " << element
                          << ": expected " << std::hex << expected[k][element] << ", got "
                          << got[k][element];
            if (++reports == kMostReports) return;
            break;
        }
    }
}

void expect_equal(const ir::Stage& stage, const StageResults& expected,
                  const CompiledStage& compiled, const StageInputs& inputs) {
    for (const openfab_isa isa : compiled.isas()) {
        expect_equal(stage, expected, compiled.run(isa, inputs), abi::isa_name(isa));
    }
}

ir::Stage make_displacing_stage(int32_t args) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kSurface;
    ir::Builder b(&stage);
    std::vector<ir::ValueId> values = {b.constant(true)};
    for (int32_t k = 0; k < args; ++k)
        values.push_back(b.input(ir::Type::kFloat, OPENFAB_ARG_SURFACE_IN, 0, k));
    const ir::ValueId x = b.sample(0, 0, values);
    const ir::ValueId zero = b.constant(0.0f);
    stage.outputs = {{"x", OPENFAB_ARG_POSITION, 0, 0, x},
                     {"y", OPENFAB_ARG_POSITION, 0, 1, zero},
                     {"z", OPENFAB_ARG_POSITION, 0, 2, zero}};
    return stage;
}

}  // namespace openfab::testing
