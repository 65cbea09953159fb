// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What LLVM cannot go on after, as an object file that may not be written: it aborts the process,
// unless it is told whom to call.

#include "compiler/lower/code/fault.h"

namespace openfab::lower {

/// Has `end` called in place of an abort; it must not return. For programs of our own alone: a
/// library has no say in how its host ends.
void end_fatal_errors_by(void (*end)(const Fault& fault));

}  // namespace openfab::lower
