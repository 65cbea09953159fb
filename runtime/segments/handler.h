// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Provides a segmented stage with what is outside its kernels: nearest-surface queries, and a sink
// for printf. Called once per step with the step's groups, never per voxel.

#include <cstdint>
#include <span>

#include "abi/fablet_table.h"
#include "abi/kernel_status.h"

namespace openfab::segments {

constexpr int32_t kLanes = 8;

/// The state of a batch: for each state number an array of 32-bit values, 8 for each lane group.
class States {
  public:
    States() = default;
    States(uint32_t* values, size_t stride) : values_(values), stride_(stride) {}
    /// Returns the values of one state; those of group g start at 8 * g.
    uint32_t* operator[](int32_t state) const {
        return values_ + static_cast<size_t>(state) * stride_;
    }

  private:
    uint32_t* values_ = nullptr;
    size_t stride_ = 0;
};

class Handler {
  public:
    virtual ~Handler() = default;
    /// Reads guard and point of the 8 lanes of each listed group and writes every output of each: 0
    /// where the guard is 0, without a query. A failure ends the print.
    virtual abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                                    const States& states) = 0;
    /// Logs a printf for the lanes of the listed groups, in this order, whose guard is not 0.
    virtual void printf(const openfab_printf& call, std::span<const int32_t> groups,
                        const States& states) = 0;
};

}  // namespace openfab::segments
