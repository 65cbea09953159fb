// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts the allocations of a part of a test. A program that links this has counting operators new
// and delete; malloc by C libraries is not counted.

#include <cstdint>
#include <ctime>

namespace openfab::testing {

class Meter {
  public:
    Meter();
    /// Returns the peak of allocated bytes since the meter was made, above those allocated before.
    int64_t peak_bytes() const;
    /// Since then, of processors, which other programs share.
    double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

  private:
    int64_t before_;
    std::clock_t start_ = std::clock();
};

}  // namespace openfab::testing
