// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/random_schedules.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/schedules/schedule_space.h"

namespace openfab::testing {

void expect_schedules_change_no_bit(const ir::Stage& stage, const StageInputs& inputs,
                                    uint32_t seed, int count) {
    ASSERT_EQ(ir::verify(stage), "");
    const StageResults expected = interpret(stage, inputs);
    const std::vector<openfab_isa> isas = tested_isas();
    std::mt19937 random(seed);
    std::set<std::string> seen;
    for (int k = 0; k < count; ++k) {
        const openfab_isa isa = isas[static_cast<size_t>(k) % isas.size()];
        const ScheduleSpace space([&] { return lower::make_kernel(stage, isa); });
        const std::string text = space.sample(&random);
        seen.insert(text);
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", schedule " << k << ":\n"
                                          << text);
        auto parsed = lower::read_schedule({"random.sched", text});
        ASSERT_NE(std::get_if<lower::Schedule>(&parsed), nullptr);
        lower::ProgramOptions options;
        options.isas = {isa};
        options.schedules[{lower::schedule_name(stage.kind), isa}] =
            std::get<lower::Schedule>(parsed);
        const std::unique_ptr<CompiledStage> compiled = CompiledStage::make(stage, options);
        ASSERT_NE(compiled, nullptr);
        expect_equal(stage, expected, *compiled, inputs);
        if (::testing::Test::HasFailure()) return;
    }
    // Almost all of them differ.
    EXPECT_GE(seen.size(), static_cast<size_t>(count * 3 / 4));
}

}  // namespace openfab::testing
