// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A stage under other schedules than the default one, against the interpreter.

#include <string>
#include <vector>

#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

/// Compiles the stage, which is one kernel, under a schedule, and compares what it computes with what
/// is expected, to the bit: of a volume stage what the slab kernel makes of it.
void expect_schedule_changes_no_bit(const ir::Stage& stage, const StageResults& expected,
                                    const StageInputs& inputs, const std::string& schedule,
                                    const std::vector<openfab_isa>& isas);

/// Same, for random legal schedules, for each instruction set in turn: twenty in a long run, else a
/// few. Failures name the schedule.
void expect_schedules_change_no_bit(const ir::Stage& stage, const StageInputs& inputs,
                                    uint32_t seed);

}  // namespace openfab::testing
