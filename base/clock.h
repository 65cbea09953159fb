// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clocks and memory of this process.

#include <chrono>
#include <cstdint>

namespace openfab::slab {

/// For differences only.
inline double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Since the process started, to the kernel's 10 ms.
double process_age_seconds();

/// Resident memory of the process now, and its highest since the program was loaded.
int64_t resident_bytes();
int64_t peak_resident_bytes();

}  // namespace openfab::slab
