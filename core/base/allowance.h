// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What this process may take of the machine: processors and memory that its affinity, and the control groups that it is
// in, leave it. A job of 4 cores on a node of 128 starts 4 threads. Control groups of version 1 and 2, at the places
// where they are mounted; limits of the groups around one count, too.

#include <cstdint>
#include <string>

namespace openfab {

/// What control groups leave.
struct GroupAllowance {
    double processors = 1e9;  ///< of quotas: processor seconds a second
    int64_t memory_bytes =
        INT64_MAX;  ///< limit less what is taken, but for pages of files that were not used of late
    bool operator==(const GroupAllowance&) const = default;
};

/// Reads the groups of this process. `root` stands before every path: tests have one of their own.
GroupAllowance read_group_allowance(const std::string& root = "");

/// Returns how many processors this process may use, from 1 on: the smaller of its affinity and quotas, of which a part
/// of a processor counts whole. Quotas are asked once.
int usable_cores();

/// Returns the memory that the machine has free for this process, page cache included, within the
/// limits of its control groups; 0 where the system does not tell.
int64_t available_memory_bytes();

/// Returns the budget of a program that was told none: kDefaultMemoryBytes, or four fifths of what control groups leave.
int64_t default_memory_bytes();

}  // namespace openfab
