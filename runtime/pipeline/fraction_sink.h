// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface to what takes fractions before the dither: mixtures as a fablet gives them, for
// programs that compute with material, such as finite elements.

#include <cstdint>
#include <span>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::pipeline {

class FractionSink {
  public:
    virtual ~FractionSink() = default;
    /// `materials`: those that have fractions, from the first; support may be one more.
    virtual Result<void> begin(const PrintInfo& info, int32_t materials) = 0;
    /// Takes voxels first_x, first_x + 1, … of row y of slice z: for each its fractions, 0 to 1, of
    /// the materials in order; what they lack to 1 is void. Called from worker threads for different
    /// voxels at once, in any order. Voxels that are never passed are void.
    virtual void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) = 0;
    /// Takes the derivatives of the fractions of the same voxels, where the print has them (PrintOptions::rates): for
    /// each voxel and column those of the materials in order. Voxels that are never passed have zeros.
    virtual void write_rates(int32_t /*z*/, int32_t /*y*/, int32_t /*first_x*/,
                             std::span<const float> /*rates*/) {}
    /// Returns the first error of write. May be called at any time, from any thread.
    virtual Result<void> status() const = 0;
    /// Called once after the last write, even if the print ended early; then `totals.complete` is
    /// false.
    virtual Result<void> finish(const PrintTotals& totals) = 0;
};

}  // namespace openfab::pipeline
