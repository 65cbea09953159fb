// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `--probe X,Y,Z`: what a fablet makes of one voxel, before the dither.

#include <atomic>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "program/options.h"

namespace openfab::program {

/// Evaluates the voxel that holds the point of `--probe`, and writes to standard output a line of
/// JSON: `{"mm": […], "pitch_mm": […], "fractions": {"white": 0.25, …}, "provenance": {…}}`. The
/// middle of the voxel, and of each material the fraction that a whole print's dither would get; of
/// support there is none. The provenance tells whether a print was made of the same.
Result<void> run_probe(const Options& options, const openfab_fablet_list& fablets,
                       const std::atomic<bool>& interrupt);

}  // namespace openfab::program
