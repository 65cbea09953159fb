// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Shapes: their kernels against the interpreter, bit for bit, and bounds that hold every value in their boxes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "compiler/frontend/frontend.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"

namespace openfab::testing {
namespace {

constexpr int32_t kPoints = 1003;  // no multiple of 8
constexpr float kRadius = 6;
constexpr float kSide = 12;

uint32_t bits_of(float x) {
    return std::bit_cast<uint32_t>(x);
}

struct Body {
    const char* name;
    const char* text;  ///< of the value, of `float3 p`
    float
        decided;  ///< the least share of boxes 1/16 of the side that are decided; measured, less 0.02
};

ir::Module compile(const std::string& value) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const uint32_t file = sources.add(
        "shape.fl",
        "import solids;\nimport lattice;\nfablet A {\n    @uniform { float radius = 6; float "
        "table[3] = {1, 2, 3}; int count = 3; }\n"
        "    float field(float3 p) { return " +
            value +
            "; }\n"
            "    @Shape(@varying { ShapeAttributes attr, out float3 normal, out int octant }) {\n"
            "        normal = gradient(field, attr.p);\n        octant = attr.p.x > 0 ? 1 : 0;\n"
            "        return field(attr.p);\n    }\n}\n");
    auto module = frontend::compile_to_ir(sources, file, sink, {}, &fault);
    EXPECT_TRUE(module && sink.errors() == 0) << value << fault;
    return module ? std::move(*module) : ir::Module{};
}

/// Points of a cube about the origin, or boxes there.
StageInputs inputs_of(uint32_t seed, bool boxes, float side) {
    std::mt19937 random(seed);
    StageInputs inputs;
    inputs.elements = kPoints;
    for (int32_t axis = 0; axis < 3; ++axis) {
        std::vector<uint32_t> low, high;
        for (int32_t i = 0; i < kPoints; ++i) {
            const float at = (static_cast<float>(random() >> 8) * 0x1p-23f - 1) * kSide;
            low.push_back(bits_of(at));
            high.push_back(bits_of(at + side));
        }
        inputs.set(boxes ? OPENFAB_ARG_SHAPE_POINT_LO : OPENFAB_ARG_SHAPE_POINT, axis, 0, low);
        if (boxes) inputs.set(OPENFAB_ARG_SHAPE_POINT_HI, axis, 0, high);
        inputs.set(OPENFAB_ARG_FRAME, OPENFAB_FRAME_CENTER + axis, 0,
                   {bits_of(0.25f * static_cast<float>(axis))});
    }
    const uint32_t uniforms[] = {bits_of(kRadius), bits_of(1), bits_of(2), bits_of(3), 3};
    for (int32_t k = 0; k < 5; ++k)
        inputs.set(OPENFAB_ARG_UNIFORM, k, 0, {uniforms[k]});
    return inputs;
}

const Body kBodies[] = {
    {"ball", "solid_ball(p, radius)", 0.9f},
    {"torus", "solid_torus(p, radius, 2)", 0.9f},
    {"box", "solid_box(p, float3(8, 6, 4), 1)", 0.8f},
    {"capsule", "solid_capsule(p, float3(-4, -4, -4), float3(4, 4, 4), 2)", 0.8f},
    {"cone", "solid_round_cone(p, float3(-4, -4, -4), float3(4, 4, 4), 1, 3)", 0.6f},
    {"smooth", "solid_union_smooth(solid_ball(p, 4), solid_torus(p, radius, 2), 1)", 0.8f},
    {"cut", "solid_difference(solid_box(p, radius, 0), solid_ball(p, 5))", 0.8f},
    {"gyroid", "dot(sin(p / 3), cos(p.yzx / 3)) - 0.3", 0.7f},
    {"schwarz", "schwarz_d(p, 20) - 0.2", 0.5f},
    {"octet", "strut_octet(p, 16, 2)", 0.4f},
    {"wave", "p.z - sin(p.x) * cos(p.y) * table[1]", 0.8f},
};

TEST(Shapes, KernelsGiveTheBitsOfTheInterpreter) {
    for (const Body& body : kBodies) {
        SCOPED_TRACE(body.name);
        const ir::Module module = compile(body.text);
        ASSERT_EQ(module.fablets.size(), 1u);
        const passes::PipelineResult all =
            passes::run_pipeline(module.fablets[0], {.disabled = {"hoist_uniforms"}});
        ASSERT_EQ(all.fault, "");
        ASSERT_TRUE(all.stages.shape_segments.steps.empty());
        const ir::Stage& given = module.fablets[0].shape;
        const StageInputs points = inputs_of(1, false, 0);
        const StageResults expected = interpret(given, points);
        ASSERT_EQ(expected.size(), 5u);
        for (const ir::Stage* stage : {&all.stages.shape, &all.stages.shape_attributes}) {
            const bool value = stage == &all.stages.shape;
            const StageResults part(expected.begin() + (value ? 0 : 1),
                                    value ? expected.begin() + 1 : expected.end());
            const auto compiled = CompiledStage::make(*stage);
            ASSERT_NE(compiled, nullptr);
            expect_equal(*stage, part, *compiled, points);
        }
    }
}

/// Loops whose trips differ from point to point: segments, on a number of points that fills no group.
TEST(Shapes, LoopsGiveTheBitsOfTheInterpreter) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("loops.fl", R"(
fablet A {
    @uniform { float radius = 6; float table[3] = {1, 2, 3}; int count = 3; }
    @Shape(@varying { ShapeAttributes attr })
    {
        float3 p = attr.p;
        float d = length(p) - radius;
        @bound(64) while (d < 2 && p.x > -20) {
            p -= float3(2, 0.5, table[0]);
            @bound(8) for (int i = 0; i < count; ++i) d = min(d + 0.25, length(p.xy) - i * table[1] + p.z * 0.1);
        }
        return d;
    }
}
)");
    const auto module = frontend::compile_to_ir(sources, file, sink);
    ASSERT_TRUE(module);
    const passes::PipelineResult all =
        passes::run_pipeline(module->fablets[0], {.disabled = {"hoist_uniforms"}});
    ASSERT_FALSE(all.stages.shape_segments.steps.empty());
    const StageInputs points = inputs_of(4, false, 0);
    const auto compiled = CompiledStage::make(all.stages.shape);
    ASSERT_NE(compiled, nullptr);
    expect_equal(all.stages.shape, interpret(module->fablets[0].shape, points), *compiled, points);
}

TEST(Shapes, BoundsHoldTheValuesAndDecideMostBoxes) {
    constexpr float kBox = 2 * kSide / 16;
    for (const Body& body : kBodies) {
        SCOPED_TRACE(body.name);
        const ir::Module module = compile(body.text);
        ASSERT_EQ(module.fablets.size(), 1u);
        const passes::PipelineResult all =
            passes::run_pipeline(module.fablets[0], {.disabled = {"hoist_uniforms"}});
        ASSERT_EQ(all.stages.shape_bounds.outputs.size(), 2u);
        const StageInputs boxes = inputs_of(2, true, kBox);
        const StageResults bounds = interpret(all.stages.shape_bounds, boxes);
        const auto compiled = CompiledStage::make(all.stages.shape_bounds);
        ASSERT_NE(compiled, nullptr);
        expect_equal(all.stages.shape_bounds, bounds, *compiled, boxes);
        std::vector<float> least(kPoints, INFINITY), most(kPoints, -INFINITY);
        std::mt19937 random(3);
        constexpr int kSamples = 40;
        for (int sample = 0; sample < kSamples; ++sample) {
            StageInputs points = boxes;
            for (int32_t axis = 0; axis < 3; ++axis) {
                std::vector<uint32_t> at;
                for (size_t i = 0; i < kPoints; ++i) {
                    const auto low = std::bit_cast<float>(
                        boxes.values.at({OPENFAB_ARG_SHAPE_POINT_LO, axis, 0})[i]);
                    const auto high = std::bit_cast<float>(
                        boxes.values.at({OPENFAB_ARG_SHAPE_POINT_HI, axis, 0})[i]);
                    // Corners first.
                    const float along = sample < 8 ? static_cast<float>(sample >> axis & 1)
                                                   : static_cast<float>(random() >> 8) * 0x1p-24f;
                    at.push_back(
                        bits_of(along == 1 ? high : std::min(low + along * (high - low), high)));
                }
                points.set(OPENFAB_ARG_SHAPE_POINT, axis, 0, at);
            }
            const StageResults values = interpret(all.stages.shape, points);
            for (size_t i = 0; i < kPoints; ++i) {
                const auto value = std::bit_cast<float>(values[0][i]);
                const auto lo = std::bit_cast<float>(bounds[0][i]),
                           hi = std::bit_cast<float>(bounds[1][i]);
                EXPECT_FALSE(value < lo || value > hi)
                    << value << " is not in " << lo << " to " << hi;
                least[i] = std::min(least[i], value);
                most[i] = std::max(most[i], value);
            }
        }
        // Of boxes that look one-sided, how many the bounds know to be so.
        int one_sided = 0, decided = 0, unknown = 0;
        for (size_t i = 0; i < kPoints; ++i) {
            const auto lo = std::bit_cast<float>(bounds[0][i]),
                       hi = std::bit_cast<float>(bounds[1][i]);
            if (std::isnan(lo)) ++unknown;
            if (most[i] < 0 || least[i] >= 0) {
                ++one_sided;
                if (hi < 0 || lo >= 0) ++decided;
            }
        }
        const float share = static_cast<float>(decided) / static_cast<float>(one_sided);
        RecordProperty(body.name,
                       fmt::format("{:.3f} of {}, {} unknown", share, one_sided, unknown));
        EXPECT_GE(share, body.decided) << unknown << " of " << kPoints << " unknown";
    }
}

}  // namespace
}  // namespace openfab::testing
