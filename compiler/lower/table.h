// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The constant tables of abi/fablet_table.h as C source, and the list of kernels that they
// name.

#include <string>
#include <vector>

#include "compiler/lower/fablet_data.h"

namespace openfab::lower {

struct KernelUnit {
    size_t fablet = 0;  ///< index in the list
    KernelSlot slot;
    openfab_isa isa = OPENFAB_ISA_SSE41;
    std::string function;  ///< unique in the program
};

/// Lists every kernel of every fablet for every instruction set, the slowest to compile first.
std::vector<KernelUnit> list_kernels(const std::vector<FabletUnit>& fablets,
                                     const std::vector<openfab_isa>& isas);

/// Returns C source that defines `openfab_fablets`, to be compiled after the text of
/// abi/fablet_table.h.
std::string table_source(const std::vector<FabletUnit>& fablets,
                         const std::vector<openfab_isa>& isas);

}  // namespace openfab::lower
