// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs a stage that is cut into segments (openfab_segments in abi/fablet_table.h): executes its
// steps over lists of lane groups, keeps its state, and scatters the kernels' outputs. One per
// thread; it allocates only while it grows to the largest stage so far.

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/kernel_call.h"
#include "runtime/segments/handler.h"

namespace openfab::segments {

/// Lane groups in a block of 64 columns, and the unit of an output's layout.
constexpr int32_t kBlockGroups = 64;

/// The memory of an output of the stage: the values of lane group g start at
/// data + (g / 64) * block_stride + 8 * (g % 64).
struct OutputView {
    uint32_t* data = nullptr;
    int64_t block_stride = kBlockGroups * kLanes;
};

/// Supplies the arguments of the stage's kernels other than groups and state.
class Arguments {
  public:
    virtual ~Arguments() = default;
    /// Returns the address of a scalar or of a halide_buffer_t. Per-lane buffers are flat, 8 values
    /// a group, and hold whole groups.
    virtual const void* input(const openfab_arg& arg) = 0;
    virtual OutputView output(const openfab_arg& arg) = 0;
};

/// Returns how many groups to run at once so that state stays in cache; at least one block.
int32_t group_limit(const openfab_segments& segments);

class Driver {
  public:
    /// `wanted`: a byte for each group, bit l for lane l. Outputs of groups without a wanted lane
    /// are not written; those of unwanted lanes in other groups are undefined. Stops at the first
    /// failure of a kernel or the handler, and, stopped, between two steps once `stop` is set, if it is
    /// not null: nested loops would go on for as long as the fablet says.
    abi::KernelStatus run(const openfab_segments& segments, openfab_isa isa,
                          std::span<const uint8_t> wanted, Arguments* arguments, Handler* handler,
                          const std::atomic<bool>* stop = nullptr);
    /// Returns the states as the last run left them: defined in groups with a wanted lane.
    const States& states() const { return states_; }

  private:
    struct Output {
        OutputView view;
        uint32_t* compact = nullptr;
        bool direct = false;  ///< kernels write the output itself where all groups are listed
    };
    struct Kernel {
        openfab_kernel_fn fn = nullptr;
        std::vector<void*> args;
        std::unique_ptr<abi::KernelBuffer[]> buffers;
        size_t buffer_count = 0;
        std::vector<Output> outputs;
        size_t first_output = 0;
    };

    void bind(const openfab_segments& segments, openfab_isa isa, Arguments* arguments);
    void bind_kernel(const openfab_kernel& kernel, openfab_isa isa, Arguments* arguments,
                     Kernel* out);
    abi::KernelStatus run_kernel(const openfab_kernel& kernel, Kernel* bound);
    /// Moves elements of arrays, in the groups of the current list.
    void move(const openfab_elements& elements) const;
    /// Copies the groups of `from` with an active lane.
    void narrow(const std::vector<int32_t>& from, int32_t active, std::vector<int32_t>* to) const;

    int32_t groups_ = 0;
    States states_;
    std::vector<uint32_t> memory_;   ///< the states' values
    std::vector<uint32_t> compact_;  ///< output of a kernel before it is scattered
    std::vector<Kernel> kernels_;
    std::vector<std::vector<int32_t>> lists_;  ///< groups of each open loop, outermost first
    size_t depth_ = 0;
};

}  // namespace openfab::segments
