// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checked tree to IR: functions are inlined, short loops unrolled, vectors split and branches
// turned into selects. What only shows here is reported here: a loop without a bound, an index that
// is no constant, an output that stays unassigned.

#include "compiler/check/limits.h"
#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"

namespace openfab::sema {

struct TranslateOptions {
    bool prints = false;  ///< `printf` and `assert` do something
};

/// Only for a program that `check` found no error in. Where this reports errors the module is not
/// usable.
ir::Module translate(const Program& program, const TranslateOptions& options, diag::Sink* sink);

}  // namespace openfab::sema
