// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The vocabulary of the IR's text form: names of inputs and outputs, of stages and of uniform
// kinds, and the spelling of constants.

#include <cstdint>
#include <string>

#include "compiler/ir/ir.h"

namespace openfab::ir {

/// Returns the name of an openfab_arg_kind or a kVoxelCoord kind; null if there is none.
const char* kind_name(int32_t kind);
const char* stage_name(StageKind kind);
const char* uniform_kind_name(openfab_uniform_kind kind);
const char* query_result_name(int32_t kind);
/// Returns an instruction without its number and its arguments: `mul float`, `const int 3`.
std::string instr_text(const Instr& instr);
/// True for operations whose `a` is written before their arguments.
bool has_a(Op op);

/// Returns the shortest text that reads back to the same bits: `true`, `-3`, `7`, `0.1`; a NaN as
/// `nan:0x7fc00000`.
std::string constant_text(Type type, uint32_t bits);

}  // namespace openfab::ir
