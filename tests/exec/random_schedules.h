// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A stage under random schedules, against the interpreter.

#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

/// How many schedules a kernel is tried with.
constexpr int kRandomSchedules = 20;

/// Compiles the stage, which is one kernel, under `count` random legal schedules, for each
/// instruction set in turn, and compares what each computes to the bit. Failures name the schedule.
void expect_schedules_change_no_bit(const ir::Stage& stage, const StageInputs& inputs,
                                    uint32_t seed, int count = kRandomSchedules);

}  // namespace openfab::testing
