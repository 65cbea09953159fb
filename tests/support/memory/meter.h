// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measures the allocations in part of a test. A program that links this gets counting operators new
// and delete; malloc in C libraries is not counted.

#include <cstdint>
#include <ctime>

namespace openfab::testing {

/// What takes so much of a processor hangs. Milliseconds are usual: a machine that does other things
/// does not come near it.
constexpr double kHangSeconds = 300;

class Meter {
  public:
    Meter();
    /// Returns the peak of allocated bytes since the meter was made, above those allocated before.
    int64_t peak_bytes() const;
    /// Returns the processor time since then, independent of other programs.
    double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

  private:
    int64_t before_;
    std::clock_t start_ = std::clock();
};

}  // namespace openfab::testing
