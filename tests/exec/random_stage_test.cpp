// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Random stages: compiled code against the interpreter, with and without the passes, and under
// another schedule.

#include "tests/exec/random_stage.h"

#include <gtest/gtest.h>

#include <bit>

#include "compiler/passes/cut_segments.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/hoist_invariants.h"
#include "compiler/passes/simplify.h"
#include "tests/exec/compiled_stage.h"
#include "tests/exec/random_schedules.h"

namespace openfab::testing {

namespace {

constexpr int32_t kOperations = 120;
constexpr uint32_t kStages = 3;
constexpr uint32_t kLoopStages = 3;
constexpr uint32_t kCutStages = 400;

StageInputs random_inputs(uint32_t seed) {
    std::mt19937 random(seed);
    StageInputs inputs;
    inputs.elements = 2;
    const size_t count = 1024;
    const auto floats = [&] {
        std::vector<uint32_t> bits;
        for (size_t k = 0; k < count; ++k)
            bits.push_back(std::bit_cast<uint32_t>(random_float(&random)));
        return bits;
    };
    for (int32_t k = 0; k < kRandomFloats; ++k)
        inputs.set(OPENFAB_ARG_NEAREST, 0, k, floats());
    inputs.set(OPENFAB_ARG_DISTANCE, 0, 0, floats());
    for (int32_t k = 0; k < kRandomInts; ++k) {
        std::vector<uint32_t> bits;
        for (size_t j = 0; j < count; ++j)
            bits.push_back(static_cast<uint32_t>(random_int(&random)));
        inputs.set(OPENFAB_ARG_NEAREST, 1, k, bits);
    }
    inputs.set(OPENFAB_ARG_UNIFORM, kFloatUniform, 0,
               {std::bit_cast<uint32_t>(random_float(&random))});
    inputs.set(OPENFAB_ARG_UNIFORM, kIntUniform, 0, {static_cast<uint32_t>(random_int(&random))});
    inputs.set(OPENFAB_ARG_BLOCKS, 0, 0, {0, 8, static_cast<uint32_t>(-16), 24, 0, 64});
    return inputs;
}

TEST(RandomStage, CompiledEqualsInterpreted) {
    for (uint32_t seed = 1; seed <= kStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ir::Stage stage = random_stage(seed, kOperations);
        ASSERT_EQ(ir::verify(stage), "");
        const StageInputs inputs = random_inputs(seed);
        const StageResults expected = interpret(stage, inputs);
        passes::simplify(&stage);
        passes::eliminate_common_values(&stage);
        passes::eliminate_dead_values(&stage);
        expect_equal(stage, expected, interpret(stage, inputs), "after the passes");
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
        ASSERT_NE(compiled, nullptr);
        expect_equal(stage, expected, *compiled, inputs);
    }
}

void clean(ir::Stage* stage) {
    passes::simplify(stage);
    passes::eliminate_common_values(stage);
    passes::eliminate_dead_values(stage);
}

/// Quick: passes and cutting alone, in the interpreter.
TEST(RandomStage, PassesAndCuttingChangeNoBitOfLoops) {
    for (uint32_t seed = 1; seed <= kCutStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ir::Stage stage = random_looping_stage(seed, 60);
        ASSERT_EQ(ir::verify(stage), "");
        StageInputs inputs = random_inputs(seed);
        inputs.only = 24;
        const StageResults expected = interpret(stage, inputs);
        clean(&stage);
        ASSERT_EQ(ir::verify(stage), "") << ir::dump(stage);
        expect_equal(stage, expected, interpret(stage, inputs), "after the passes");
        passes::hoist_invariants(&stage);
        ASSERT_EQ(ir::verify(stage), "") << ir::dump(stage);
        expect_equal(stage, expected, interpret(stage, inputs), "after hoist_invariants");
        // As they come, and in pieces of a few operations.
        for (const size_t longest : {passes::kMaxKernelOperations, size_t{20}, size_t{5}}) {
            if (!passes::needs_segments(stage, longest)) continue;
            const passes::SegmentedStage segmented = passes::cut_segments(stage, longest);
            for (const ir::Stage& kernel : segmented.kernels)
                ASSERT_EQ(ir::verify(kernel), "") << ir::dump(kernel);
            ASSERT_EQ(ir::verify(segmented.last), "") << ir::dump(segmented.last);
            const StageResults cut = interpret_segments(stage, segmented, inputs);
            expect_equal(stage, expected, cut, "cut");
        }
        if (HasFailure()) {
            ADD_FAILURE() << ir::dump(stage);
            return;
        }
    }
}

TEST(RandomStage, CompiledLoopsEqualInterpreted) {
    for (uint32_t seed = 1; seed <= kLoopStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ir::Stage stage = random_looping_stage(seed, 60);
        const StageInputs inputs = random_inputs(seed);
        const StageResults expected = interpret(stage, inputs);
        clean(&stage);
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage);
        ASSERT_NE(compiled, nullptr);
        expect_equal(stage, expected, *compiled, inputs);
    }
}

TEST(RandomStage, SchedulesChangeNoBit) {
    const ir::Stage stage = random_stage(kStages + 1, kOperations / 2);
    const StageInputs inputs = random_inputs(7);
    const StageResults expected = interpret(stage, inputs);
    for (const char* text :
         {"slab.vectorize(column, 4)\n",
          "slab.split(column, co, ci, 3).reorder(z, ci, co).unroll(ci)\n"
          "values_*.compute_at(slab, co).vectorize(z, 4)\n",
          "values_*.compute_root()\nslab.fuse(z, column, all).parallel(all)\n"}) {
        SCOPED_TRACE(text);
        expect_schedule_changes_no_bit(stage, expected, inputs, text, {OPENFAB_ISA_AVX2});
    }
}

TEST(RandomStage, RandomSchedulesChangeNoBit) {
    const ir::Stage stage = random_stage(kStages + 2, kOperations / 2);
    expect_schedules_change_no_bit(stage, random_inputs(8), 1);
}

TEST(RandomStage, SlabsNormaliseWhatIsInterpreted) {
    for (uint32_t seed = 1; seed <= kStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const ir::Stage stage = random_stage(seed, kOperations / 2);
        const StageInputs inputs = random_inputs(seed);
        expect_equal_slab(stage, interpret(stage, inputs), inputs, {.isas = tested_isas()});
    }
}

TEST(RandomStage, SlabsGoOnAfterSegments) {
    for (uint32_t seed = 1; seed <= kLoopStages; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ir::Stage stage = random_looping_stage(seed, 40);
        clean(&stage);
        const StageInputs inputs = random_inputs(seed);
        expect_equal_slab(stage, interpret(stage, inputs), inputs, {.isas = tested_isas()});
    }
}

}  // namespace

}  // namespace openfab::testing
