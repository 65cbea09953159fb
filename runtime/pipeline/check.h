// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "runtime/pipeline/print.h"

namespace openfab::slab {

/// Refuses what the pipeline cannot run: an unknown dither, too many materials, a pitch or memory
/// budget that makes no sense, and (our bug) a fablet whose kernels ask for arguments that do not
/// belong to their stage.
Result<void> check_input(const PrintInput& input, const PrintOptions& options);

}  // namespace openfab::slab
