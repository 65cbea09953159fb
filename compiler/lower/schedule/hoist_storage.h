// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `store_at` and `store_root`: memory that is taken in a loop outside the one where a Func is
// computed, once for all steps between. Halide has the same directives, but goes further: it slides a
// window along such loops, and folds what is stored, so that steps compute only what those before did
// not. No stage here reads its neighbours, so there is nothing to gain; and where steps overlap all the
// same, by a loop over the inner part of a split or by a factor that does not divide, Halide 14 begins
// loops before the first column, or stores values that are wrong. So it is told of one place, where a
// Func is computed, and memory is moved out when the loops are made.

#include <Halide.h>

#include "compiler/lower/schedule/scheduled_kernel.h"

namespace openfab::lower {

/// Returns the pass that moves memory out, where its size is the same in all steps. Halide takes it
/// over; the kernel must outlive it.
Halide::Internal::IRMutator* make_storage_hoister(const ScheduledKernel& kernel);

}  // namespace openfab::lower
