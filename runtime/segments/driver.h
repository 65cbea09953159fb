// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs a stage that is cut in phases (openfab_phases in abi/fablet_table.h): walks its
// steps over lists of groups of 8 places, keeps its state, puts what kernels write in its place.
// One a thread; it allocates only while it grows to the largest stage that it has met.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/kernel_call.h"
#include "runtime/segments/handler.h"

namespace openfab::phases {

/// Groups in a block of 64 columns, and the unit of an output's layout.
constexpr int32_t kBlockGroups = 64;

/// Where an output of the stage goes: the values of group g start at
/// data + (g / 64) * block_stride + 8 * (g % 64).
struct OutputPlace {
    uint32_t* data = nullptr;
    int64_t block_stride = kBlockGroups * kLanes;
};

/// What the stage's kernels are passed beside groups and state.
class Arguments {
  public:
    virtual ~Arguments() = default;
    /// The address of a scalar or of a halide_buffer_t. Buffers of places are flat, 8 a group, and
    /// hold whole groups.
    virtual const void* input(const openfab_arg& arg) = 0;
    virtual OutputPlace output(const openfab_arg& arg) = 0;
};

/// The most groups to run at once so that state stays in the cache; at least one block.
int32_t group_limit(const openfab_phases& phases);

class Driver {
  public:
    /// `wanted`: a byte for each group, bit l for lane l. Outputs of groups without a wanted place
    /// are not written; those of unwanted places beside wanted ones are of no use. Ends with the
    /// first kernel or answer of the handler that fails.
    abi::KernelStatus run(const openfab_phases& phases, openfab_isa isa,
                          std::span<const uint8_t> wanted, Arguments* arguments, Handler* handler);

  private:
    struct Output {
        OutputPlace place;
        uint32_t* compact = nullptr;
        bool direct = false;  ///< may be written in its place where all groups are listed
    };
    struct Kernel {
        openfab_kernel_fn fn = nullptr;
        std::vector<void*> args;
        std::unique_ptr<abi::KernelBuffer[]> buffers;
        size_t buffer_count = 0;
        std::vector<Output> outputs;
        size_t first_output = 0;
    };

    void bind(const openfab_phases& phases, openfab_isa isa, Arguments* arguments);
    void bind_kernel(const openfab_kernel& kernel, openfab_isa isa, Arguments* arguments,
                     Kernel* out);
    abi::KernelStatus run_kernel(const openfab_kernel& kernel, Kernel* bound);
    /// Keeps of `from` the groups with a lane at work.
    void narrow(const std::vector<int32_t>& from, int32_t active, std::vector<int32_t>* to) const;

    int32_t groups_ = 0;
    States states_;
    std::vector<uint32_t> memory_;   ///< of the states
    std::vector<uint32_t> compact_;  ///< what a kernel wrote, before it is put in its place
    std::vector<Kernel> kernels_;
    std::vector<std::vector<int32_t>> lists_;  ///< of each loop that is open, outermost first
    size_t depth_ = 0;
};

}  // namespace openfab::phases
