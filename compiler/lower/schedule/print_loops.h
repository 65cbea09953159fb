// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The loops of a scheduled kernel, as text.

#include <string>
#include <vector>

#include "compiler/lower/schedule/kernel_memory.h"
#include "compiler/lower/schedule/scheduled_kernel.h"

namespace openfab::lower {

/// Returns one line a loop, indented by its depth, in the order in which they run; before a Func's
/// loops what is stored of it, from list_storage.
std::string print_loops(const ScheduledKernel& kernel, const std::vector<FuncStorage>& storage);

}  // namespace openfab::lower
