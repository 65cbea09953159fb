// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The functions of the IR (ir::is_function): the value of each, and its expansion into primitive
// operations. Both come from one formula (machine.h), so they agree to the bit; compiler/lower and
// the schedules never see them. compiler/functions/README.md states ranges, errors, periods and
// special values.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::functions {

/// Returns the bits of a function's result; `args` are the bits of its arguments.
uint32_t evaluate(const ir::Instr& instr, std::span<const uint32_t> args);

/// Returns a function's result in double, from arguments in double or integers; not of a hash. The elementary ones are
/// the C library's.
double evaluate_wide(const ir::Instr& instr, std::span<const double> args);

/// Returns the bits of an operation's or a function's result if all its arguments are constants of
/// the stage; empty otherwise, and for lookups, loops, queries and printfs.
std::optional<uint32_t> fold(const ir::Stage& stage, const ir::Instr& instr);

/// Appends the primitive operations of `instr`, whose arguments are values of the stage that
/// `builder` writes. Returns the result's value.
ir::ValueId expand(const ir::Instr& instr, ir::Builder* builder);

/// Returns the number of operations that `expand` makes of `instr`.
size_t operations(const ir::Instr& instr);

}  // namespace openfab::functions
