// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::pipeline {

/// Rejects input that the pipeline cannot run: an unknown dither, too many materials, a pitch or
/// memory budget out of range, and (our bug) a fablet whose kernels take arguments that do not
/// belong to their stage.
Result<void> check_input(const PrintInput& input, const PrintOptions& options);

}  // namespace openfab::pipeline
