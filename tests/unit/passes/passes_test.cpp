// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "base/infinity.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/form_surface_bounds.h"
#include "compiler/passes/pipeline.h"

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

/// u = f(uv.x) sampled; the value of the first derivative argument at x = 3, dx = 0.25.
float derivative_of(const std::function<ValueId(ir::Builder&, ValueId)>& f) {
    ir::Stage stage = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, 0);
    const ValueId sample =
        b.sample(0, 0, {b.constant(true), f(b, x), b.constant(0.0f), b.constant(1.0f)});
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
        values.floats[{OPENFAB_ARG_SURFACE_IN, 0, axis}] = d[axis];
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
    // A normal whose length is rounded up.
    const Moved along = move({1.0f, 2.0f, 2.0f}, std::nextafter(3.0f, 0.0f));
    EXPECT_EQ(along.status, 0u);
    EXPECT_LT(along.by[0], 1.0f);
    EXPECT_EQ(move({1.0f, 2.0f, 2.0f}, 2.9999f).status, 2u);
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

TEST(Pipeline, LeavesOutWhatIsSwitchedOff) {
    ir::Fablet fablet;
    fablet.volume = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&fablet.volume);
    const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    const ValueId x = b.input(Type::kFloat, ir::kVoxelCoord, 0, 0);
    const ValueId near = b.emit(Op::kLt, {x, b.constant(1.0f)});
    const ValueId w = b.select(near, d, b.constant(0.0f));
    fablet.volume.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, w}};
    const KernelStages all = run_pipeline(fablet).stages;
    EXPECT_EQ(all.volume_bounds.outputs.size(), 3u) << "both ends, and whether it looks";
    EXPECT_EQ(all.volume_demand.outputs.size(), 1u);
    PipelineOptions options;
    options.disabled = {"form_volume_bounds", "form_demand"};
    const PipelineResult result = run_pipeline(fablet, options);
    EXPECT_EQ(result.fault, "");
    EXPECT_TRUE(result.stages.volume_bounds.outputs.empty());
    EXPECT_TRUE(result.stages.volume_demand.outputs.empty());
    EXPECT_TRUE(result.stages.surface.outputs.empty());
}

/// So that the order of the table is the order of the stages passed to `after`.
TEST(Pipeline, RunsPassesInTheOrderOfTheirNames) {
    ir::Fablet fablet;
    fablet.volume = stage_of(ir::StageKind::kVolume);
    ir::Builder b(&fablet.volume);
    const ValueId d = b.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    fablet.volume.outputs = {{"w", OPENFAB_ARG_WEIGHT, 0, 0, d}};
    std::vector<std::string> first_told;
    PipelineOptions options;
    options.after = [&](const std::string& pass, const ir::Stage& /*stage*/,
                        const std::string& /*reason*/) {
        if (std::find(first_told.begin(), first_told.end(), pass) == first_told.end())
            first_told.push_back(pass);
    };
    run_pipeline(fablet, options);
    std::vector<std::string> names;
    for (const PassName& pass : pass_names()) {
        // Passes on the surface and on the shape have nothing to run on.
        const std::string name = pass.name;
        if (name != "form_surface_bounds" && name != "bound_displacement" &&
            name != "form_shape_bounds")
            names.push_back(name);
    }
    EXPECT_EQ(first_told, names);
}

}  // namespace

}  // namespace openfab::passes
