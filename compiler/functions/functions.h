// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The functions of the IR (ir::is_function): what each gives, and the primitive operations that it
// stands for. Both come from one formula (machine.h), so they agree to the bit; compiler/lower and
// the schedules know nothing of them. compiler/functions/README.md states ranges, errors, periods
// and special values.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::functions {

/// Bits of one function's result; `args` are the bits of its arguments.
uint32_t evaluate(const ir::Instr& instr, std::span<const uint32_t> args);

/// The bits of an operation's or a function's result where all its arguments are constants of the
/// stage. Empty elsewhere, and for what does more than compute: look-ups, loops, queries, prints.
std::optional<uint32_t> fold(const ir::Stage& stage, const ir::Instr& instr);

/// Appends the primitive operations of `instr`, whose arguments are values of the stage that
/// `builder` writes; the result's value.
ir::ValueId expand(const ir::Instr& instr, ir::Builder* builder);

/// How many operations `expand` gives for a function of so many arguments.
size_t operations(const ir::Instr& instr);

}  // namespace openfab::functions
