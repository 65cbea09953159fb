// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What this machine can do at most: what the stages of a print are held against.

#include <cstdint>
#include <string>

#include "abi/fablet_table.h"

namespace openfab::tuner {

struct Machine {
    int32_t threads = 1;
    /// Bytes a second to and from memory, of one thread and of all at once: a(i) = b(i) + s c(i).
    double bandwidth_one = 0, bandwidth_all = 0;
    /// Multiplications and additions a second, likewise. Kernels never fuse the two.
    double operations_one = 0, operations_all = 0;

    /// Return the share of one thread while all work.
    double bandwidth_each() const { return bandwidth_all / threads; }
    double operations_each() const { return operations_all / threads; }
};

/// Returns the processor's name, as the system has it.
std::string processor_name();

/// Measures it, in about a second and 96 MiB.
Machine measure_machine(int32_t threads, openfab_isa isa);

}  // namespace openfab::tuner
