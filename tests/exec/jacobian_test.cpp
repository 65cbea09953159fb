// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiled derivatives, in floats, against central differences in double.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/passes/form_jacobian.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"
#include "tests/support/derivatives/double_inputs.h"

namespace openfab::testing {
namespace {

constexpr const char* kHead =
    "fablet A { @uniform { float u = 0.7; float3 v = float3(0.3, -0.4, 0.9); float4 w = float4(1, "
    "2, 0.5, 0.25);"
    " Material m0, m1; }\n float f(float3 p) {";
constexpr const char* kTail =
    "}\n@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc;"
    " mc.Set(m0, 3 + f(attr.voxelCenter)); mc.Set(m1, 5 + w.w * attr.voxelCenter.x); return mc; } "
    "}";
constexpr int32_t kFloats = 8;

class CompiledBody : public ::testing::TestWithParam<const char*> {};

TEST_P(CompiledBody, HasTheDerivativesOfCentralDifferences) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::string text = kHead + std::string(GetParam()) + kTail;
    const auto module = frontend::compile_to_ir(sources, sources.add("a.fl", text), sink);
    ASSERT_TRUE(module.has_value()) << diag::render_text(sink, sources);
    ir::Fablet fablet = module->fablets[0];
    const ir::Stage volume = fablet.volume;
    std::vector<passes::Direction> directions;
    for (int32_t k = 0; k < kFloats; ++k)
        directions.push_back({{{k, -1}}});
    passes::Jacobian jacobian = passes::form_jacobian(fablet, directions);
    ASSERT_TRUE(jacobian.none.empty());
    fablet.volume = std::move(jacobian.stage);
    // What a program of derivatives does, but for the values that it computes once.
    passes::PipelineOptions options;
    options.disabled = {"hoist_uniforms", "form_volume_bounds"};
    const passes::PipelineResult result = passes::run_pipeline(fablet, options);
    ASSERT_EQ(result.fault, "");
    const auto compiled = CompiledStage::make(result.stages.volume);
    ASSERT_NE(compiled, nullptr);

    StageInputs inputs;
    inputs.elements = 1;
    inputs.set(OPENFAB_ARG_BLOCKS, 0, 0, {16, static_cast<uint32_t>(-4), 3});
    DoubleInputs doubles;
    doubles.set_defaults(fablet);
    for (int32_t k = 0; k < kFloats; ++k) {
        const auto value = static_cast<float>(doubles.uniform(k));
        inputs.set(OPENFAB_ARG_UNIFORM, k, 0, {std::bit_cast<uint32_t>(value)});
    }
    constexpr float kPitch = 0.17f;
    for (int32_t k = 0; k < OPENFAB_FRAME_COUNT; ++k) {
        const float value = k < 9 && k % 4 == 0 ? kPitch : k >= 9 && k < 12 ? -0.6f : 0.0f;
        inputs.set(OPENFAB_ARG_FRAME, k, 0, {std::bit_cast<uint32_t>(value)});
        doubles.numbers[{OPENFAB_ARG_FRAME, k, 0}] = value;
    }
    // Every instruction set has the interpreter's bits.
    const StageResults got = interpret(result.stages.volume, inputs);
    expect_equal(result.stages.volume, got, *compiled, inputs);
    int compared = 0;
    for (size_t element = 0; element < 512; element += 7) {
        const auto z = static_cast<double>(element % 8), x = static_cast<double>(element / 8 % 8),
                   y = static_cast<double>(element / 64);
        doubles.numbers[{ir::kVoxelCoord, 0, 0}] = 16 + x + 0.5;
        doubles.numbers[{ir::kVoxelCoord, 1, 0}] = -4 + y + 0.5;
        doubles.numbers[{ir::kVoxelCoord, 2, 0}] = 3 + z + 0.5;
        for (int32_t k = 0; k < kFloats; ++k) {
            const auto expected = differences(volume, doubles, k);
            if (!expected) continue;
            for (size_t slot = 0; slot < 2; ++slot) {
                const double other = (*expected)[slot];
                const auto mine =
                    std::bit_cast<float>(got[2 + 2 * static_cast<size_t>(k) + slot][element]);
                EXPECT_NEAR(mine, other, 1e-4 * std::max(std::fabs(other), 0.1))
                    << "value " << k << ", element " << element;
                ++compared;
            }
        }
    }
    EXPECT_GT(compared, 900);
}

INSTANTIATE_TEST_SUITE_P(
    All, CompiledBody,
    ::testing::Values(
        "return noise(p * u + v) + w.x * simplex(p * w.y) + cellular(p * u + v).x * w.z;",
        "return length(p - v) * exp(-w.x * dot(p, p) / 9) + atan2(w.y + p.y, 9 + u) + pow(u, w.y);",
        "float s = u; int i = 0; @bound(30) while (i < int(3 + 2 * abs(p.x))) { s = s * 0.5 + "
        "sin(s * p.y + w.x); i++; } return s;",
        "return smoothstep(-1.0, 2 + v.z, u * p.x) + min(w.x * p.x, w.y) + noise_gradient(p * u).x "
        "* w.z;"));

}  // namespace
}  // namespace openfab::testing
