// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/random_schedules.h"

#include <gtest/gtest.h>

#include <set>

#include "compiler/lower/code/compile.h"
#include "tests/support/long_run.h"
#include "tests/support/schedules/schedule_space.h"

namespace openfab::testing {

void expect_schedule_changes_no_bit(const ir::Stage& stage, const StageResults& expected,
                                    const StageInputs& inputs, const std::string& schedule,
                                    const std::vector<openfab_isa>& isas) {
    auto parsed = schedule::read({"test.sched", schedule});
    const auto* fault = std::get_if<schedule::Fault>(&parsed);
    ASSERT_EQ(fault, nullptr) << fault->message;
    lower::ProgramOptions options;
    options.isas = isas;
    for (const openfab_isa isa : isas) {
        options.schedules[{lower::schedule_name(stage.kind), isa}] =
            std::get<schedule::Schedule>(parsed);
    }
    if (stage.kind == ir::StageKind::kVolume) {
        expect_equal_slab(stage, expected, inputs, options);
        return;
    }
    const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage, options);
    ASSERT_NE(compiled, nullptr);
    expect_equal(stage, expected, *compiled, inputs);
}

void expect_schedules_change_no_bit(const ir::Stage& stage, const StageInputs& inputs,
                                    uint32_t seed) {
    ASSERT_EQ(ir::verify(stage), "");
    const int count = long_run() ? 20 : 3;
    const StageResults expected = interpret(stage, inputs);
    const std::vector<openfab_isa> isas = tested_isas();
    std::mt19937 random(seed);
    std::set<std::string> seen;
    const ir::Stage made = stage.kind == ir::StageKind::kVolume ? slab_stage(stage) : stage;
    for (int k = 0; k < count; ++k) {
        const openfab_isa isa = isas[static_cast<size_t>(k) % isas.size()];
        const std::string text = ScheduleSpace({{&made, {}, "kernel", isa}}).sample(&random);
        seen.insert(text);
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", schedule " << k << ":\n"
                                          << text);
        expect_schedule_changes_no_bit(stage, expected, inputs, text, {isa});
        if (::testing::Test::HasFailure()) return;
    }
    // Almost all of them differ.
    EXPECT_GE(seen.size(), static_cast<size_t>(count * 3 / 4));
}

}  // namespace openfab::testing
