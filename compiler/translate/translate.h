// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Translates the checked tree to IR: functions are inlined, short loops unrolled, vectors split and
// branches turned into selects. Reports errors that are only detected here: a loop without a bound,
// an unassigned output.

#include "compiler/check/limits.h"
#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"

namespace openfab::translate {

struct TranslateOptions {
    bool enable_printf = false;  ///< compile `printf` and `assert` in
};

/// Translates a program in which `check` found no error. If this reports errors, the module is not
/// usable.
ir::Module translate(const check::Program& program, const TranslateOptions& options,
                     diag::Sink* sink);

}  // namespace openfab::translate
