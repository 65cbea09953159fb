// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Why a print stopped, for its record.

#include "backends/job/record.h"
#include "base/result.h"

namespace openfab::program {

/// Says why a print that failed with `error` stopped.
job::StopReason stop_reason(const Error& error);

/// Says that a signal has come.
job::StopReason signal_reason();

}  // namespace openfab::program
