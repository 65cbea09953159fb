// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The constant tables of abi/fablet_table.h as C source.

#include <string>
#include <vector>

#include "compiler/lower/code/fablet_data.h"
#include "compiler/lower/code/kernel_cache.h"

namespace openfab::lower {

/// A kernel of a program.
struct KernelUnit {
    size_t fablet = 0;  ///< index in the list
    KernelSlot slot;
    KernelRequest request;  ///< kernels of one code have one function
    KernelKey key;
};

/// Returns C source that defines `openfab_fablets` with these kernels, to be compiled after the
/// text of abi/fablet_table.h. `stored_bytes`: of each fablet's kernels.
std::string table_source(const std::vector<FabletUnit>& fablets,
                         const std::vector<KernelUnit>& kernels,
                         const std::vector<int64_t>& stored_bytes);

}  // namespace openfab::lower
