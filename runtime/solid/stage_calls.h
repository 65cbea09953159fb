// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls kernels of a stage that makes geometry (openfab_shape in abi/fablet_table.h) on lists, piece by piece. One a thread.

#include <cstdint>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "abi/kernel_call.h"
#include "runtime/segments/driver.h"
#include "runtime/surface/kernel_args.h"

namespace openfab::solid {

/// Returns `n` rounded up to whole groups of lanes.
constexpr size_t whole_lanes(size_t n) {
    constexpr auto kLanes = static_cast<size_t>(segments::kLanes);
    return (n + kLanes - 1) / kLanes * kLanes;
}

class StageCalls : segments::Arguments, protected segments::Handler {
  public:
    /// Returns how many components the stage's outputs have together.
    size_t components() const { return components_; }
    /// Returns the place of an output's first component among them.
    size_t first_component(int32_t output) const {
        return first_component_[static_cast<size_t>(output)];
    }

  protected:
    /// `shape` and `fixed`, the arguments that are the same in all calls, must outlive it. `most`: items of one call, whole
    /// groups of lanes, whose buffers stay in the second-level cache.
    StageCalls(const openfab_shape& shape, const surface::StaticArgs& fixed, openfab_isa isa,
               size_t most);
    ~StageCalls() override = default;

    /// Runs a kernel, or its segments if it has some, on `n` items. Where there are segments, lists have room for whole
    /// groups of lanes.
    abi::KernelStatus run(const openfab_kernel& kernel, const openfab_segments& segments, size_t n);
    /// Returns a list from the current piece on: an argument that is not among the fixed ones.
    virtual void* data(const openfab_arg& arg) = 0;
    virtual void begin_piece() {}
    /// A stage that asks nothing has none.
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;

    const openfab_shape& shape_;
    size_t first_ = 0;     ///< of the piece of the list
    size_t in_piece_ = 0;  ///< how many items it has

  private:
    abi::KernelStatus run_kernel(const openfab_kernel& kernel);
    const void* input(const openfab_arg& arg) override;
    segments::OutputView output(const openfab_arg& arg) override;
    void printf(const openfab_printf& call, std::span<const int32_t> groups,
                const segments::States& states) override;

    const surface::StaticArgs& fixed_;
    openfab_isa isa_;
    size_t most_;
    std::vector<size_t> first_component_;
    size_t components_ = 0;
    segments::Driver driver_;
    std::vector<uint8_t> wanted_;
    std::vector<std::unique_ptr<abi::KernelBuffer>> buffers_;
    size_t buffers_used_ = 0;
    std::vector<uint32_t> packed_;
    int32_t count_ = 0;  ///< of the piece; to whole groups where there are segments
};

}  // namespace openfab::solid
