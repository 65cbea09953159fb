// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Large arrays and many materials: compiled code against the interpreter, bit for bit, and how its
// size grows, which is what compiling takes. Sizes of text are counted, not seconds.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <random>
#include <string>

#include "compiler/frontend/frontend.h"
#include "compiler/lower/code/compile.h"
#include "compiler/lower/code/fablet_data.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"
#include "tests/support/load_module.h"

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr uint32_t kTop = 0x80000000u;
constexpr int32_t kBools = 5000;  // uniforms from here on

/// Inputs of one block, or of so many cubes; `per_element` values of NEAREST (0, 0) and (0, 1).
StageInputs inputs_of(int32_t elements, size_t per_element) {
    std::mt19937 random(7);
    StageInputs inputs;
    inputs.elements = elements;
    std::vector<uint32_t> indices(per_element), floats(per_element);
    const std::vector<uint32_t> edges = {0,    1,        38,   39,       40, 4095,
                                         4096, kTop - 1, kTop, kTop + 5, ~0u};
    for (size_t k = 0; k < per_element; ++k) {
        indices[k] = k < edges.size() ? edges[k] : random() % 5000;
        floats[k] = std::bit_cast<uint32_t>(static_cast<float>(random() % 4096) * 0.01f - 5.0f);
    }
    inputs.set(OPENFAB_ARG_NEAREST, 0, 0, indices);
    inputs.set(OPENFAB_ARG_NEAREST, 0, 2, indices);
    inputs.set(OPENFAB_ARG_NEAREST, 0, 1, floats);
    for (int32_t k = 0; k < 5000; ++k)
        inputs.set(OPENFAB_ARG_UNIFORM, k, 0, {static_cast<uint32_t>(random()) & 0x7effffffu});
    for (int32_t k = kBools; k < kBools + 40; ++k)
        inputs.set(OPENFAB_ARG_UNIFORM, k, 0, {k % 3 == 0 ? 1u : 0u});
    return inputs;
}

// Every type of index and element; far, near and negative indices.
TEST(ManyValues, TablesAreWhatTheInterpreterReads) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolume;
    ir::Builder b(&stage);
    for (const Type of_index : {Type::kInt, Type::kUint}) {
        const ValueId index =
            b.input(of_index, OPENFAB_ARG_NEAREST, 0, of_index == Type::kInt ? 0 : 2);
        for (const Type type : {Type::kFloat, Type::kInt, Type::kUint, Type::kBool}) {
            for (const auto& [first, step, count] :
                 {std::array{0, 1, 40}, std::array{7, 1, 4096}, std::array{2, 3, 1000}}) {
                ir::Instr table;
                table.op = Op::kTable;
                table.type = type;
                table.a = type == Type::kBool ? kBools : first;
                table.b = step;
                table.bits = static_cast<uint32_t>(type == Type::kBool ? 13 : count);
                table.args = {index};
                const ValueId value = b.append(table);
                stage.outputs.push_back(
                    {fmt::format("t{}", stage.outputs.size()), OPENFAB_ARG_WEIGHT, 0, 0, value});
            }
        }
    }
    // A table's element names that of another.
    const ValueId inner = b.append(stage.instrs[stage.outputs[4].value]);
    ir::Instr outer = stage.instrs[stage.outputs[0].value];
    outer.args = {b.binary(Op::kBitAnd, inner, b.constant(31))};
    stage.outputs.push_back({"nested", OPENFAB_ARG_WEIGHT, 0, 0, b.append(outer)});
    ASSERT_EQ(ir::verify(stage), "");
    const StageInputs inputs = inputs_of(1, 512);
    const auto compiled = CompiledStage::make(stage);
    ASSERT_NE(compiled, nullptr);
    expect_equal(stage, interpret(stage, inputs), *compiled, inputs);
}

/// A stage with so many outputs that share values.
ir::Stage wide_stage(ir::StageKind kind, int32_t outputs) {
    ir::Stage stage;
    stage.kind = kind;
    ir::Builder b(&stage);
    const ValueId x = b.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, 1);
    const ValueId index = b.input(Type::kInt, OPENFAB_ARG_NEAREST, 0, 0);
    for (int32_t k = 0; k < outputs; ++k) {
        const ValueId number = b.constant(static_cast<float>(k));
        ValueId value = b.emit(Op::kMax, {b.constant(0.0f), b.emit(Op::kSub, {x, number})});
        if (k % 7 == 3) value = b.select(b.binary(Op::kEq, index, b.constant(k)), x, value);
        if (k % 11 == 5) value = b.constant(0.25f);
        if (k % 13 == 6) value = x;
        stage.outputs.push_back({fmt::format("o{}", k), OPENFAB_ARG_WEIGHT, k, 0, value});
    }
    return stage;
}

TEST(ManyValues, ManyStatesAreWhatTheInterpreterGives) {
    for (const int32_t outputs : {17, 64, 256}) {
        const ir::Stage stage = wide_stage(ir::StageKind::kVolume, outputs);
        const StageInputs inputs = inputs_of(1, 512);
        const auto compiled = CompiledStage::make(stage);
        ASSERT_NE(compiled, nullptr);
        expect_equal(stage, interpret(stage, inputs), *compiled, inputs);
    }
}

TEST(ManyValues, ManyBoundsAreWhatTheInterpreterGives) {
    const ir::Stage stage = wide_stage(ir::StageKind::kVolumeBounds, 60);
    for (const int32_t cubes : {3, 8, 21}) {
        const StageInputs inputs = inputs_of(cubes, static_cast<size_t>(cubes));
        const auto compiled = CompiledStage::make(stage);
        ASSERT_NE(compiled, nullptr);
        expect_equal(stage, interpret(stage, inputs), *compiled, inputs);
    }
}

TEST(ManyValues, ManySlotsAreNormalisedInTheSlabKernel) {
    const ir::Stage stage = wide_stage(ir::StageKind::kVolume, 40);
    const StageInputs inputs = inputs_of(1, 512);
    lower::ProgramOptions options;
    options.isas = tested_isas();
    expect_equal_slab(stage, interpret(stage, inputs), inputs, options);
}

/// The text of all kernels of a fablet.
size_t lowered_size(const std::string& text, lower::TextForm form) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("many.fl", text), sink);
    EXPECT_TRUE(module.has_value());
    if (!module) return 0;
    const passes::PipelineResult made = passes::run_pipeline(module->fablets[0]);
    EXPECT_EQ(made.fault, "");
    size_t size = 0;
    for (const lower::KernelSlot& slot : lower::kernel_slots(made.stages)) {
        const auto out =
            lower::emit_text({slot.stage, slot.inside, "k", OPENFAB_ISA_AVX2, nullptr}, form);
        const auto* lowered = std::get_if<std::string>(&out);
        EXPECT_NE(lowered, nullptr) << slot.name;
        size += lowered != nullptr ? lowered->size() : 0;
    }
    return size;
}

std::string fablet_of(const std::string& uniforms, const std::string& body,
                      const std::string& more = "") {
    return fmt::format(R"(fablet Many {{
    @uniform {{ {} }}
    @Volume(@varying {{ VolumeAttributes attr }})
    {{
        int k = (int)attr.voxelCenter.x;
        MaterialComposition mc;
        {}
        return mc;
    }}
    {}
}})",
                       uniforms, body, more);
}

std::string materials(int count, const std::string& more = "") {
    std::string body;
    for (int k = 0; k < count; ++k)
        body += fmt::format("mc.Set(m[{0}], max(0, 1 - abs(attr.voxelCenter.x - {0})));\n", k);
    return fablet_of(fmt::format("Material m[{}];", count), body, more);
}

// Twice the elements are the same code.
TEST(ManyValues, CodeDoesNotGrowWithATable) {
    const auto of = [](int count) {
        const std::string text =
            fablet_of(fmt::format("Material a, b; float t[{}]; float3 c[{}];", count, count / 4),
                      "mc.Set(a, t[k]); mc.Set(b, t[k ^ 5] + c[k].y);");
        return lowered_size(text, lower::TextForm::kLlvm);
    };
    const size_t small = of(64);
    EXPECT_LT(static_cast<double>(of(4096)), 1.05 * static_cast<double>(small));
    EXPECT_LT(static_cast<double>(of(16384)), 1.05 * static_cast<double>(small));
}

// Twice the materials are twice the code, not four times.
TEST(ManyValues, CodeGrowsWithMaterialsAsTheyAre) {
    const std::string rule = "@Dither(@varying { DitherAttributes attr }) { return 1; }";
    for (const std::string& more : {std::string(), rule}) {
        const auto of = [&](int count) {
            return static_cast<double>(
                lowered_size(materials(count, more), lower::TextForm::kStmt));
        };
        const double one = of(24), two = of(48), four = of(96);
        EXPECT_LT(four - two, 2.4 * (two - one)) << more;
    }
}

// What takes long says so once, while it compiles.
TEST(ManyValues, LongCompilationsAreForetold) {
    source::SourceManager sources;
    diag::Sink sink;
    const auto module = frontend::compile_to_ir(sources, sources.add("t.fl", materials(20)), sink);
    ASSERT_TRUE(module);
    std::vector<std::string> told;
    lower::ProgramOptions options;
    options.foretell = [&](const std::string& text) { told.push_back(text); };
    options.foretell_after = 0;
    options.foretell_from = 0;
    ASSERT_EQ(load_module(*module, options).index(), 0u);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_TRUE(told[0].starts_with("1 of ")) << told[0];
    told.clear();
    options.foretell_after = 1e9;
    ASSERT_EQ(load_module(*module, options).index(), 0u);
    EXPECT_TRUE(told.empty());
}

}  // namespace

}  // namespace openfab::testing
