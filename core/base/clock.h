// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Time and memory of this process.

#include <chrono>
#include <cstdint>

namespace openfab {

/// Returns a monotonic time; only differences have a meaning.
inline double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Returns the seconds since the process started, to the kernel's 10 ms.
double process_age_seconds();

/// Return the seconds of processor time that all threads of the process, or the calling one, took so
/// far.
double processor_seconds();
double thread_processor_seconds();

/// Return the resident memory of the process now, and its peak since the program was loaded.
int64_t resident_bytes();
int64_t peak_resident_bytes();

}  // namespace openfab
