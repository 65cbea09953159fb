// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Rules that grow: their kernels against the interpreter, bit for bit, with and without loops that are not unrolled.

#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "abi/grow_table.h"
#include "compiler/frontend/frontend.h"
#include "compiler/ir/grows.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"

namespace openfab::testing {
namespace {

constexpr int32_t kNodes = 1003;  // no multiple of 8

constexpr const char* kBegin = R"(
struct Node {
    float3 end[2];
    float radius[2];
    int children;
    float reach;
    float3x3 frame;
    uint seed;
    bool flat;
    float age[2];
};
fablet A {
    @uniform { int count = 3; float angle = 0.4; }
    @Grow(@varying { GrowAttributes attr, Node parent })
    {
        Node n = parent;
        float4 luck = hash4(attr.path, 7);
)";
constexpr const char* kTurn = R"(
        float c = cos(angle + luck.x), s = sin(angle + luck.x);
        n.frame = mul(parent.frame, float3x3(c, -s, 0, s, c, 0, 0, 0, 1));
        n.end[0] = parent.end[1];
        n.end[1] = n.end[0] + n.frame[attr.child % 3] * luck.y;
        n.radius[0] = parent.radius[1];
        n.radius[1] = 0.7 * n.radius[0] + 0.01 * attr.child;
        n.children = attr.level < count ? 2 + int(luck.z * 2) : 0;
        n.reach = length(n.end[1] - n.end[0]) * 2;
        n.seed = parent.seed ^ attr.path;
        n.flat = n.children == 0;
        n.age[0] = parent.age[1];
        n.age[1] = float(attr.level) / 8;
)";
constexpr const char* kLoop = R"(
        float3 p = parent.end[1];
        @bound(64) while (length(p) > 3 && n.children < 9) {
            p *= 0.8;
            n.children += 1;
        }
        @bound(8) for (int i = 0; i < attr.child; ++i) n.radius[0] += 0.5 * n.radius[1];
        n.end[1] = p;
)";
constexpr const char* kEnd = "        return n;\n    }\n}\n";

StageInputs inputs_of(const ir::Fablet& fablet) {
    std::mt19937 random(3);
    StageInputs inputs;
    inputs.elements = kNodes;
    const auto fill = [&](int32_t kind, int32_t a, int32_t b, const auto& make) {
        std::vector<uint32_t> bits;
        for (int32_t i = 0; i < kNodes; ++i)
            bits.push_back(make());
        inputs.set(kind, a, b, bits);
    };
    for (size_t m = 0; m < fablet.shape_outputs.size(); ++m) {
        for (int32_t k = 0; k < fablet.shape_outputs[m].components; ++k) {
            fill(OPENFAB_ARG_GROW_PARENT, static_cast<int32_t>(m), k, [&]() -> uint32_t {
                if (fablet.shape_outputs[m].type == ir::Type::kBool) return random() & 1;
                if (fablet.shape_outputs[m].type != ir::Type::kFloat) return random() % 12;
                return std::bit_cast<uint32_t>(static_cast<float>(random() >> 8) * 0x1p-21f - 4);
            });
        }
    }
    fill(OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_CHILD, 0, [&] { return random() % 8; });
    fill(OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_LEVEL, 0, [&] { return random() % 8; });
    fill(OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_PATH, 0,
         [&] { return static_cast<uint32_t>(random()); });
    inputs.set(OPENFAB_ARG_UNIFORM, 0, 0, {3});
    inputs.set(OPENFAB_ARG_UNIFORM, 1, 0, {std::bit_cast<uint32_t>(0.4f)});
    return inputs;
}

TEST(Grow, KernelsGiveTheBitsOfTheInterpreter) {
    for (const bool loops : {false, true}) {
        SCOPED_TRACE(loops);
        source::SourceManager sources;
        diag::Sink sink;
        std::string fault;
        const uint32_t file =
            sources.add("grow.fl", std::string(kBegin) + (loops ? kLoop : kTurn) + kEnd);
        const auto module = frontend::compile_to_ir(sources, file, sink, {}, &fault);
        ASSERT_TRUE(module && sink.errors() == 0) << fault;
        const ir::Fablet& fablet = module->fablets[0];
        EXPECT_TRUE(ir::grows(fablet));
        const passes::PipelineResult all =
            passes::run_pipeline(fablet, {.disabled = {"hoist_uniforms"}});
        ASSERT_EQ(all.fault, "");
        EXPECT_TRUE(all.stages.shape.outputs.empty());
        EXPECT_EQ(all.stages.shape_attribute_segments.steps.empty(), !loops);
        const StageInputs inputs = inputs_of(fablet);
        const StageResults expected = interpret(fablet.shape, inputs);
        ASSERT_EQ(expected.size(), 23u);
        const auto compiled = CompiledStage::make(all.stages.shape_attributes);
        ASSERT_NE(compiled, nullptr);
        expect_equal(all.stages.shape_attributes, expected, *compiled, inputs);
    }
}

}  // namespace
}  // namespace openfab::testing
