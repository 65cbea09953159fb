// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slab kernels written in Halide by hand, with schedules of their own: what a programmer makes who
// has no OpenFL. They take the arguments of the compiled kernels (abi/fablet_table.h), compute the
// same for each column (positions, values, amounts, codes and fractions) and give the same bits.

#include <string>
#include <string_view>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "compiler/lower/code/load_code.h"

namespace openfab::by_hand {

struct HandKernel {
    std::vector<openfab_arg> args;
    lower::LoadedKernel loaded;
};

/// Compiles the kernel for a fablet of the gallery, `MarbleTable` or `SoftToy`.
Result<HandKernel> compile(std::string_view fablet, openfab_isa isa);

}  // namespace openfab::by_hand
