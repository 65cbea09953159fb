// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the kernels of a test are called with.

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "abi/kernel_call.h"
#include "compiler/lower/code/jit.h"
#include "runtime/segments/driver.h"
#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

constexpr int32_t kVoxels = 512;

/// True for kinds of one value for all elements.
bool is_scalar(int32_t kind);

/// Returns all values of the object, by number; what no test gives is a NaN.
const std::vector<uint32_t>& object_values(const StageInputs& inputs,
                                           std::deque<std::vector<uint32_t>>* kept);

/// The address of a scalar, or of a buffer that is added to `buffers`, of `count` values where it
/// has one per element.
const void* input_argument(const openfab_arg& arg, const StageInputs& inputs,
                           const std::vector<int32_t>& columns, size_t count,
                           std::deque<abi::KernelBuffer>* buffers,
                           std::deque<std::vector<uint32_t>>* kept);

/// Compiles them; fails the test and returns null where that is not possible.
std::unique_ptr<lower::LoadedProgram> load_stages(const passes::KernelStages& stages,
                                                  const lower::ProgramOptions& options);

/// Flat buffers of the batch, in whole groups, and the answers to queries.
class SegmentHost : public segments::Arguments, public segments::Handler {
  public:
    /// `outputs`: of `stage`, by number, for those that are no states.
    SegmentHost(const StageInputs& inputs, size_t elements,
                const std::vector<ir::Output>& stage_outputs = {}, StageResults* outputs = nullptr)
        : inputs_(inputs),
          elements_((elements + 7) / 8 * 8),
          stage_outputs_(stage_outputs),
          outputs_(outputs) {}

    const void* input(const openfab_arg& arg) override;
    segments::OutputView output(const openfab_arg& arg) override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;
    void printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                const segments::States& /*states*/) override {}

  private:
    const StageInputs& inputs_;
    const size_t elements_;
    const std::vector<ir::Output> stage_outputs_;
    StageResults* outputs_;
    std::deque<abi::KernelBuffer> buffers_;
    std::deque<std::vector<uint32_t>> padded_;
};

}  // namespace openfab::testing
