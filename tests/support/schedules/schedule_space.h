// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random schedules that are legal: any of them must give the bits of the default one.

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compiler/lower/code/compile.h"
#include "compiler/lower/schedule/scheduled_kernel.h"

namespace openfab::testing {

class ScheduleSpace {
  public:
    /// Of a kernel, or of several that share a schedule, as those of segments do. What requests point
    /// to must outlive the space.
    explicit ScheduleSpace(std::vector<lower::KernelRequest> kernels);

    /// Returns a schedule that no kernel refuses: loops of the result split, reordered, fused,
    /// vectorized, unrolled, parallel, with a second version; each other Func in one of the loops
    /// around what reads it, stored and fetched in any way. Lines that only lowered code shows to be
    /// refused are left out.
    std::string sample(std::mt19937* random) const;

  private:
    lower::ScheduledKernel apply(const std::string& text, bool* legal) const;
    std::optional<int32_t> refused_line(const std::string& text) const;
    std::string pattern_of(const lower::ScheduledFunc& func) const;
    std::string add(const std::string& text, const std::string& line) const;
    std::string add_result(const std::string& text, const lower::ScheduledFunc& func,
                           std::mt19937* random) const;
    std::string add_storage(const std::string& text, const lower::ScheduledFunc& func,
                            std::mt19937* random) const;
    std::string add_placement(const std::string& text, size_t func, std::mt19937* random) const;
    std::string add_loops(const std::string& text, const std::string& func,
                          const lower::LoopNest& nest, const std::string& prefix,
                          std::mt19937* random) const;

    std::vector<lower::KernelRequest> kernels_;    ///< the first has the most Funcs
    std::vector<std::vector<std::string>> funcs_;  ///< of each, those that a schedule may name
};

}  // namespace openfab::testing
