// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the Funcs of a kernel compute and move for one place of theirs, by their definitions: a
// voxel of the slab kernel. A schedule changes neither, but for what it computes twice.

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/lower/schedule/kernel_request.h"

namespace openfab::lower {

struct FuncCost {
    std::string func;
    int64_t operations = 0;     ///< arithmetic and comparisons; of a reduction one step
    int64_t bytes_read = 0;     ///< of other Funcs and of the kernel's arguments
    int64_t bytes_written = 0;  ///< of its values
};

/// Returns those of the kernel's own Funcs, consumers first; the runtime's stages are not among them.
std::vector<FuncCost> func_costs(const KernelRequest& request);

}  // namespace openfab::lower
