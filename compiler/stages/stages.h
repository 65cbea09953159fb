// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fixed-function stages between the fablet's amounts and the printer's slices, as Halide
// algorithms: normalise (compiler/lower/algorithm/normalise.h) and pack. (The dither between them is
// runtime/dither/dither_row.h.) Their arguments and buffer shapes are in abi/stage_table.h. Their
// twins in tests/support/reference give the same bits; how they run is in schedules/.

#include <Halide.h>

#include <string>

#include "compiler/lower/algorithm/kernel.h"

namespace openfab::stages {

struct Stage {
    std::string name;           ///< of the stage and its schedule file
    Halide::Pipeline pipeline;  ///< with all outputs
    lower::Kernel kernel;       ///< the Funcs that a schedule may name
};

/// Makes the normalise stage, for any number of slots.
Stage normalise();
/// Makes the pack stage; `bits` per voxel is 4 or 8.
Stage pack(int bits);

}  // namespace openfab::stages
