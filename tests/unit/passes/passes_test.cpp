// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "base/infinity.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/form_surface_bounds.h"
#include "compiler/passes/hoist_uniforms.h"
#include "compiler/passes/pipeline.h"
#include "compiler/passes/simplify.h"

namespace openfab::passes {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class Values : public interp::Environment {
  public:
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        return std::bit_cast<uint32_t>(floats.at({kind, a, b}));
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    std::map<std::array<int32_t, 3>, float> floats;
};

ir::Stage stage_of(ir::StageKind kind) {
    ir::Stage stage;
    stage.kind = kind;
    return stage;
}

TEST(Simplify, FoldsConstantsAndKeepsSignedZero) {
    ir::Stage stage = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    const ValueId two = b.emit(Op::kAdd, {b.constant(1.0f), b.constant(1.0f)});
    const ValueId kept = b.emit(Op::kAdd, {x, b.constant(0.0f)});
    const ValueId same = b.emit(Op::kMul, {x, b.constant(1.0f)});
    stage.outputs = {{"two", OPENFAB_ARG_WEIGHT, 0, 0, two},
                     {"kept", OPENFAB_ARG_WEIGHT, 1, 0, kept},
                     {"same", OPENFAB_ARG_WEIGHT, 2, 0, same}};
    simplify(&stage);
    eliminate_dead_values(&stage);
    ASSERT_EQ(ir::verify(stage), "");
    EXPECT_EQ(stage.instrs[stage.outputs[0].value].op, Op::kConst);
    // -0 + 0 is 0, not -0.
    EXPECT_EQ(stage.instrs[stage.outputs[1].value].op, Op::kAdd);
    EXPECT_EQ(stage.instrs[stage.outputs[2].value].op, Op::kInput);
}

TEST(Simplify, DropsLookUpsThatNoPathReaches) {
    ir::Stage stage = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&stage);
    const ValueId u = b.constant(0.5f);
    const ValueId sample = b.emit(Op::kSample, {b.constant(false), u, u, u});
    stage.outputs = {{"s", OPENFAB_ARG_WEIGHT, 0, 0, sample}};
    simplify(&stage);
    EXPECT_EQ(stage.instrs[stage.outputs[0].value].op, Op::kConst);
}

TEST(EliminateCommonValues, KeepsOneOfEach) {
    ir::Stage stage = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&stage);
    const auto sum = [&] {
        const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
        return b.emit(Op::kAdd, {x, b.constant(2.0f)});
    };
    const ValueId product = b.emit(Op::kMul, {sum(), sum()});
    stage.outputs = {{"p", OPENFAB_ARG_WEIGHT, 0, 0, product}};
    eliminate_common_values(&stage);
    eliminate_dead_values(&stage);
    EXPECT_EQ(stage.instrs.size(), 4u);
    const ir::Instr& last = stage.instrs.back();
    EXPECT_EQ(last.args[0], last.args[1]);
}

/// u = f(uv.x) sampled; the value of the first derivative argument at x = 3, dx = 0.25.
float derivative_of(const std::function<ValueId(ir::Builder&, ValueId)>& f) {
    ir::Stage stage = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0);
    const ValueId sample =
        b.emit(Op::kSample, {b.constant(true), f(b, x), b.constant(0.0f), b.constant(1.0f)});
    stage.outputs = {{"s", OPENFAB_ARG_WEIGHT, 0, 0, sample}};
    attach_footprints(&stage);
    EXPECT_EQ(ir::verify(stage), "");
    const ir::Instr& completed = stage.instrs[stage.outputs[0].value];
    EXPECT_EQ(completed.args.size(), 10u);
    Values values;
    values.floats[{OPENFAB_ARG_NEAREST, 0, 0}] = 3.0f;
    for (int32_t axis = 0; axis < 3; ++axis) {
        values.floats[{OPENFAB_ARG_NEAREST_GRAD, 0, axis}] = axis == 0 ? 0.25f : 0.0f;
    }
    return std::bit_cast<float>(interp::evaluate_all(stage, values)[completed.args[4]]);
}

TEST(AttachFootprints, DifferentiatesEachOperation) {
    using B = ir::Builder;
    EXPECT_EQ(derivative_of([](B&, ValueId x) { return x; }), 0.25f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) { return b.emit(Op::kMul, {x, x}); }), 1.5f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) { return b.emit(Op::kAdd, {x, x}); }), 0.5f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) {
                  return b.emit(Op::kSub, {b.constant(1.0f), x});
              }),
              -0.25f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) { return b.emit(Op::kNeg, {x}); }), -0.25f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) { return b.emit(Op::kFloor, {x}); }), 0.0f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) {
                  return b.emit(Op::kMod, {x, b.constant(2.0f)});
              }),
              0.25f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) {
                  return b.emit(Op::kMax, {x, b.constant(5.0f)});
              }),
              0.0f);
    EXPECT_EQ(derivative_of([](B& b, ValueId x) {
                  return b.emit(Op::kMin, {x, b.constant(5.0f)});
              }),
              0.25f);
    EXPECT_EQ(
        derivative_of([](B& b, ValueId x) { return b.emit(Op::kAbs, {b.emit(Op::kNeg, {x})}); }),
        0.25f);
    EXPECT_NEAR(derivative_of([](B& b, ValueId x) {
                    return b.emit(Op::kDiv, {b.constant(1.0f), x});
                }),
                -0.25f / 9.0f, 1e-7f);
    EXPECT_NEAR(derivative_of([](B& b, ValueId x) { return b.emit(Op::kSqrt, {x}); }),
                0.125f / std::sqrt(3.0f), 1e-7f);
}

ir::Stage displacing_stage() {
    ir::Stage stage = stage_of(ir::StageKind::kSurface);
    ir::Builder b(&stage);
    for (int32_t axis = 0; axis < 3; ++axis) {
        const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_SURFACE_IN, 0, axis);
        stage.outputs.push_back({"d", OPENFAB_ARG_POSITION, 0, axis, d});
    }
    return stage;
}

struct Moved {
    std::array<float, 3> by;
    uint32_t status;
};

Moved move(std::array<float, 3> d, float limit) {
    ir::Stage stage = displacing_stage();
    bound_displacement(&stage);
    EXPECT_EQ(ir::verify(stage), "");
    Values values;
    for (int32_t axis = 0; axis < 3; ++axis) {
        values.floats[{OPENFAB_ARG_SURFACE_IN, 0, axis}] = d[static_cast<size_t>(axis)];
        values.floats[{OPENFAB_ARG_SURFACE_ATTR, OPENFAB_SURFACE_P, axis}] = 0.0f;
    }
    values.floats[{OPENFAB_ARG_FRAME, OPENFAB_FRAME_MAX_DISPLACEMENT, 0}] = limit;
    const std::vector<uint32_t> out = interp::evaluate(stage, values);
    return {
        {std::bit_cast<float>(out[0]), std::bit_cast<float>(out[1]), std::bit_cast<float>(out[2])},
        out[3]};
}

TEST(BoundDisplacement, MakesFiniteAndCuts) {
    const Moved kept = move({1.0f, 2.0f, 2.0f}, kInfinity);
    EXPECT_EQ(kept.by, (std::array<float, 3>{1.0f, 2.0f, 2.0f}));
    EXPECT_EQ(kept.status, 0u);
    EXPECT_EQ(move({1.0f, 2.0f, 2.0f}, 3.0f).status, 0u);
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
        const Moved none = move({1.0f, bad, 2.0f}, 1.0f);
        EXPECT_EQ(none.by, (std::array<float, 3>{0.0f, 0.0f, 0.0f}));
        EXPECT_EQ(none.status, 1u);
    }
    for (const float size : {2.0f, 1e3f, 1e20f, 1e38f}) {
        const Moved cut = move({size, -size, size * 0.5f}, 1.5f);
        EXPECT_EQ(cut.status, 2u);
        const double length = std::sqrt(static_cast<double>(cut.by[0]) * cut.by[0] +
                                        static_cast<double>(cut.by[1]) * cut.by[1] +
                                        static_cast<double>(cut.by[2]) * cut.by[2]);
        EXPECT_LE(length, 1.5);
        EXPECT_GT(length, 1.4999);
    }
}

TEST(FormSurfaceBounds, BoundsWhatTheStageReturns) {
    const ir::Stage bounds = form_surface_bounds(displacing_stage());
    ASSERT_EQ(ir::verify(bounds), "");
    const auto ends = [&](float lo, float hi) {
        Values values;
        for (int32_t axis = 0; axis < 3; ++axis) {
            values.floats[{OPENFAB_ARG_SURFACE_IN_LO, 0, axis}] = axis == 0 ? lo : 0.0f;
            values.floats[{OPENFAB_ARG_SURFACE_IN_HI, 0, axis}] = axis == 0 ? hi : 0.0f;
        }
        const std::vector<uint32_t> out = interp::evaluate(bounds, values);
        return std::array<float, 2>{std::bit_cast<float>(out[0]), std::bit_cast<float>(out[1])};
    };
    EXPECT_EQ(ends(1.0f, 2.0f), (std::array<float, 2>{1.0f, 2.0f}));
    EXPECT_EQ(ends(0.0f, 0.0f), (std::array<float, 2>{0.0f, 0.0f}));
    EXPECT_TRUE(std::isnan(ends(kNan, kNan)[0]));
    EXPECT_TRUE(std::isnan(ends(kNan, kNan)[1]));
}

TEST(HoistUniforms, ComputesOnceWhatSeveralStagesTakeFromUniforms) {
    ir::Stage volume = stage_of(ir::StageKind::kVolume);
    {
        ir::Builder b(&volume);
        const ValueId u = b.input(Type::kFloat, OPENFAB_ARG_UNIFORM, 0, 0);
        const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
        const ValueId root = b.emit(Op::kSqrt, {b.emit(Op::kMul, {u, b.constant(3.0f)})});
        const ValueId w = b.emit(Op::kMul, {b.emit(Op::kAdd, {root, d}), u});
        volume.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, w},
                          {"v", OPENFAB_ARG_WEIGHT, 1, 0, root}};
    }
    ir::Stage surface = stage_of(ir::StageKind::kSurface);
    {
        ir::Builder b(&surface);
        const ValueId u = b.input(Type::kFloat, OPENFAB_ARG_UNIFORM, 0, 0);
        const ValueId product = b.emit(Op::kMul, {u, b.constant(3.0f)});
        const ValueId x = b.emit(Op::kAdd, {b.input(Type::kFloat, OPENFAB_ARG_SURFACE_IN, 0, 0),
                                            b.emit(Op::kSqrt, {product})});
        surface.outputs = {{"x", OPENFAB_ARG_POSITION, 0, 0, x},
                           {"y", OPENFAB_ARG_POSITION, 0, 1, product}};
    }
    UniformHoister hoister(4);
    for (ir::Stage* stage : {&volume, &surface}) {
        hoister.hoist(stage);
        eliminate_dead_values(stage);
        EXPECT_EQ(ir::verify(*stage), "");
    }
    EXPECT_EQ(ir::print(hoister.derived()),
              "  stage derived\n"
              "    %0 = input float uniform 0 0\n"
              "    %1 = const float 3\n"
              "    %2 = mul float %0 %1\n"
              "    %3 = sqrt float %2\n"
              "    output derived_0 derived 0 0 %3\n"
              "    output derived_1 derived 1 0 %2\n");
    // u itself, d, the derived value; sum and product.
    EXPECT_EQ(volume.instrs.size(), 5u) << ir::print(volume);
    EXPECT_EQ(surface.instrs.size(), 4u) << ir::print(surface);
    EXPECT_EQ(surface.instrs[surface.outputs[1].value].a, 5);
}

TEST(Pipeline, LeavesOutWhatIsSwitchedOff) {
    ir::Fablet fablet;
    fablet.volume = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&fablet.volume);
    const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    fablet.volume.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, d}};
    EXPECT_EQ(run_pipeline(fablet).stages.volume_bounds.outputs.size(), 2u);
    PipelineOptions options;
    options.disabled = {"form_volume_bounds"};
    const PipelineResult result = run_pipeline(fablet, options);
    EXPECT_EQ(result.fault, "");
    EXPECT_TRUE(result.stages.volume_bounds.outputs.empty());
    EXPECT_TRUE(result.stages.surface.outputs.empty());
}

}  // namespace

}  // namespace openfab::passes
