// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/compiled_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <numeric>
#include <random>

#include "abi/nearest_stage.h"
#include "abi/stages.h"
#include "compiler/interp/evaluate.h"
#include "runtime/segments/driver.h"
#include "tests/support/reference/dither.h"

namespace openfab::testing {

namespace {

constexpr int32_t kVoxels = 512;
constexpr uint32_t kUnwritten = 0xdeadbeefu;
constexpr size_t kMostReports = 5;

bool is_scalar(int32_t kind) {
    return kind == OPENFAB_ARG_UNIFORM || kind == OPENFAB_ARG_FRAME ||
           kind == OPENFAB_ARG_INSTANCE || kind == OPENFAB_ARG_BLOCK_SIZE;
}

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
        return answer(result.kind, result.b, at(1), at(2), at(3));
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
            states_[out.state] =
                state(query.guard) == 0 ? 0 : answer(out.kind, out.b, at(0), at(1), at(2));
        }
    }

    const passes::SegmentedStage& segmented_;
    const interp::Environment& outer_;
    std::vector<uint32_t> states_;
};

/// Returns all values of the object, by number; what no test gives is a NaN.
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

/// Returns the texels, info or min-max values of the texture that `arg` names.
void set_texture(const openfab_arg& arg, const StageInputs& inputs, abi::KernelBuffer* buffer) {
    const TestTexture& t = inputs.textures.at(static_cast<size_t>(arg.a));
    const bool info = arg.b == OPENFAB_TEXTURE_INFO;
    const auto& floats = arg.b == OPENFAB_TEXTURE_TEXELS ? t.texels : t.minmax;
    const void* data = info ? static_cast<const void*>(t.info.data()) : floats.data();
    buffer->set_dense(abi::halide_type(arg.scalar), data,
                      {static_cast<int32_t>(info ? t.info.size() : floats.size())});
}

/// The address of a scalar, or of a buffer that is added to `buffers`, of `count` values where it
/// has one per element.
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

/// Flat buffers of the batch, in whole groups, and the answers to queries.
class SegmentHost : public segments::Arguments, public segments::Handler {
  public:
    /// `outputs`: of `stage`, by number, for those that are no states.
    SegmentHost(const StageInputs& inputs, size_t elements,
                const std::vector<ir::Output>& stage_outputs = {}, StageResults* outputs = nullptr)
        : inputs_(inputs),
          elements_((elements + 7) / 8 * 8),
          stage_outputs_(stage_outputs),
          outputs_(outputs) {}

    const void* input(const openfab_arg& arg) override {
        if (is_scalar(arg.kind)) return inputs_.values.at({arg.kind, arg.a, arg.b}).data();
        abi::KernelBuffer& buffer = buffers_.emplace_back();
        const halide_type_t type = abi::halide_type(arg.scalar);
        if (arg.kind == OPENFAB_ARG_VALUES) {
            const std::vector<uint32_t>& values = object_values(inputs_, &padded_);
            buffer.set_dense(type, values.data(), {static_cast<int32_t>(values.size())});
        } else if (arg.kind == OPENFAB_ARG_TEXTURE) {
            set_texture(arg, inputs_, &buffer);
        } else if (arg.kind == OPENFAB_ARG_BLOCKS) {
            buffer.set_dense(type, inputs_.values.at({arg.kind, 0, 0}).data(),
                             {3, inputs_.elements});
        } else {
            std::vector<uint32_t>& padded =
                padded_.emplace_back(inputs_.values.at({arg.kind, arg.a, arg.b}));
            padded.resize(elements_, 0x7fc00000u);
            buffer.set_dense(type, padded.data(), {static_cast<int32_t>(elements_)});
        }
        return buffer.raw();
    }
    segments::OutputView output(const openfab_arg& arg) override {
        const auto at = std::ranges::find_if(stage_outputs_, [&](const ir::Output& o) {
            return o.kind == arg.kind && o.a == arg.a && o.b == arg.b;
        });
        if (at == stage_outputs_.end()) {
            ADD_FAILURE() << "an output of kind " << arg.kind << " that is no state";
            return {};
        }
        std::vector<uint32_t>& values =
            (*outputs_)[static_cast<size_t>(at - stage_outputs_.begin())];
        return {values.data()};
    }
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override {
        for (const int32_t group : groups) {
            for (int32_t i = 8 * group; i < 8 * group + 8; ++i) {
                const auto at = [&](int32_t k) { return std::bit_cast<float>(states[k][i]); };
                for (int32_t k = 0; k < query.output_count; ++k) {
                    const openfab_query_output& out = query.outputs[k];
                    states[out.state][i] = states[query.guard][i] == 0
                                               ? 0
                                               : answer(out.kind, out.b, at(query.point[0]),
                                                        at(query.point[1]), at(query.point[2]));
                }
            }
        }
        return {};
    }
    void printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                const segments::States& /*states*/) override {}

  private:
    const StageInputs& inputs_;
    const size_t elements_;
    const std::vector<ir::Output> stage_outputs_;
    StageResults* outputs_;
    std::deque<abi::KernelBuffer> buffers_;
    std::deque<std::vector<uint32_t>> padded_;
};

std::unique_ptr<lower::LoadedProgram> load(const passes::KernelStages& stages,
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
    out->program_ = load(stages, options);
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

uint32_t answer(int32_t kind, int32_t b, float x, float y, float z) {
    switch (kind) {
        case OPENFAB_QUERY_DISTANCE:
            return std::bit_cast<uint32_t>((x - y) * 0.5f + z);
        case OPENFAB_QUERY_ATTRIBUTE:
            return x > y ? 3u : 0xfffffff0u;
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
    const std::unique_ptr<lower::LoadedProgram> program = load(stages, options);
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

TestTexture make_texture(int32_t width, int32_t height, int32_t channels, int32_t wrap,
                         int32_t filter, uint32_t seed, float ramp) {
    std::mt19937 random(seed);
    TestTexture out;
    struct Level {
        int32_t w, h;
        std::vector<float> texels, lo, hi;
    };
    Level level{width, height, {}, {}, {}};
    for (int32_t k = 0; k < width * height * channels; ++k) {
        const float noise = static_cast<float>(random() >> 8) * 0x1p-24f;
        const auto along = static_cast<float>(k / channels % width) / static_cast<float>(width);
        level.texels.push_back(ramp * along + (1.0f - ramp) * noise);
    }
    level.lo = level.hi = level.texels;
    out.info = {channels, 0, wrap, filter, 0, wrap, 0, 0};
    while (true) {
        out.info[1]++;
        out.info.insert(out.info.end(), {static_cast<int32_t>(out.texels.size()), level.w, level.h,
                                         static_cast<int32_t>(out.minmax.size())});
        out.texels.insert(out.texels.end(), level.texels.begin(), level.texels.end());
        for (size_t k = 0; k < level.lo.size(); ++k) {
            out.minmax.push_back(level.lo[k]);
            out.minmax.push_back(level.hi[k]);
        }
        if (level.w == 1 && level.h == 1) return out;
        Level next{(level.w + 1) / 2, (level.h + 1) / 2, {}, {}, {}};
        for (int32_t y = 0; y < next.h; ++y) {
            for (int32_t x = 0; x < next.w; ++x) {
                for (int32_t c = 0; c < channels; ++c) {
                    float sum = 0;
                    float number = 0;
                    float lo = 2;
                    float hi = -1;
                    for (int32_t j = 2 * y; j < std::min(2 * y + 2, level.h); ++j) {
                        for (int32_t i = 2 * x; i < std::min(2 * x + 2, level.w); ++i) {
                            const auto at = static_cast<size_t>((j * level.w + i) * channels + c);
                            sum += level.texels[at];
                            number += 1;
                            lo = std::min(lo, level.lo[at]);
                            hi = std::max(hi, level.hi[at]);
                        }
                    }
                    next.texels.push_back(sum / number);
                    next.lo.push_back(lo);
                    next.hi.push_back(hi);
                }
            }
        }
        level = std::move(next);
    }
}

}  // namespace openfab::testing
