// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random schedules of a kernel that are legal: any of them must give the bits of the default one.

#include <functional>
#include <random>
#include <string>

#include "compiler/lower/kernel.h"
#include "compiler/lower/scheduled_kernel.h"

namespace openfab::testing {

class ScheduleSpace {
  public:
    /// `make` makes the kernel anew, without a schedule.
    explicit ScheduleSpace(std::function<lower::Kernel()> make) : make_(std::move(make)) {}

    /// Returns a schedule that apply_schedule accepts: loops of the result split, reordered, fused,
    /// vectorized, unrolled, parallel, with a second version; each other Func in one of the loops
    /// around what reads it, stored and fetched in any way.
    std::string sample(std::mt19937* random) const;

  private:
    lower::ScheduledKernel apply(const std::string& text, bool* legal) const;
    std::string add(const std::string& text, const std::string& line) const;
    std::string add_result(const std::string& text, const lower::ScheduledFunc& func,
                           std::mt19937* random) const;
    std::string add_storage(const std::string& text, const lower::ScheduledFunc& func,
                            std::mt19937* random) const;
    std::string add_placement(const std::string& text, size_t func, std::mt19937* random) const;
    std::string add_loops(const std::string& text, const std::string& func,
                          const lower::LoopNest& nest, const std::string& prefix,
                          std::mt19937* random) const;

    std::function<lower::Kernel()> make_;
};

}  // namespace openfab::testing
