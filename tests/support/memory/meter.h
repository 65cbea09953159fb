// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts what a piece of a test allocates. A program that links this has operators new and delete
// that keep count; what C libraries take by malloc is not in it.

#include <chrono>
#include <cstdint>

namespace openfab::testing {

class Meter {
  public:
    Meter();
    /// The most that was there at once since the meter was made, besides what was there before.
    int64_t peak_bytes() const;
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    int64_t before_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace openfab::testing
