// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tells the processes that records of prints name from others.

#include <cstdint>
#include <string>

namespace openfab::job {

/// Returns the name of this machine.
std::string host_name();

/// Returns a number that no earlier process of the same number has: when it started. 0 where there is no such process.
int64_t start_of_process(int64_t process);

}  // namespace openfab::job
