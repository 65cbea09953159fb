// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a print runs. No voxel depends on it.

#include <cstdint>
#include <optional>

#include "abi/fablet_table.h"
#include "base/units.h"
#include "program/progress.h"

namespace openfab::program {

/// The best instruction set that fablets are compiled for, unless more is asked for:
/// docs/measurements/avx512.md tells why it is not AVX-512.
constexpr openfab_isa kUsualIsa = OPENFAB_ISA_AVX2;

struct RunOptions {
    int64_t memory_bytes = kDefaultMemoryBytes;
    /// Otherwise a print that needs more gets it, if the machine has it.
    bool memory_given = false;
    std::optional<int32_t> threads;  ///< empty: all cores
    ProgressMode progress = ProgressMode::kAuto;
    std::optional<double> slab_limit_seconds;  ///< a slab that takes longer ends the print
    bool no_cache = false;                     ///< converted pictures and scans are not kept
    bool estimate = false;
    bool dry_run = false;
    bool culling = true;                     ///< this and the next two are for tests
    std::optional<int32_t> slabs_in_flight;  ///< empty: as many as memory allows
    std::optional<openfab_isa> isa;          ///< the best to use
};

}  // namespace openfab::program
