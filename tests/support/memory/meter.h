// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts what a piece of a test allocates. A program that links this has operators new and delete
// that keep count; what C libraries take by malloc is not in it.

#include <cstdint>
#include <ctime>

namespace openfab::testing {

class Meter {
  public:
    Meter();
    /// The most that was there at once since the meter was made, besides what was there before.
    int64_t peak_bytes() const;
    /// Since then, of processors, which other programs share.
    double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

  private:
    int64_t before_;
    std::clock_t start_ = std::clock();
};

}  // namespace openfab::testing
