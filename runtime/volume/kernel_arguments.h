// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The argument array of a fablet's kernel for one call. One object per thread, reused: a call
// allocates nothing once the arrays have grown to the longest argument list.

#include <cstdint>
#include <memory>
#include <vector>

#include "abi/kernel_call.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

/// The address of a scalar, or `buffer`, filled, for a texture: what does not change from block to
/// block. Null for all else.
const void* part_argument(const PrintPart& part, const openfab_arg& arg, abi::KernelBuffer* buffer);

class KernelArguments {
  public:
    /// Starts the list of `kernel` for n blocks or cubes of `block_size` voxels a side; `corners`:
    /// 3 part-relative indices each. Sets everything that does not belong to a voxel; the caller
    /// sets the rest, for which `is_set` is false.
    void begin(const openfab_kernel& kernel, const PrintPart& part, const int32_t* corners,
               int32_t n, int32_t block_size);
    bool is_set(int32_t i) const { return args_[static_cast<size_t>(i)] != nullptr; }

    /// A volume buffer: n blocks of 512 values, `stride` apart.
    void set_blocks(int32_t i, const void* data, int32_t stride = 512);
    /// A buffer of one value for each cube.
    void set_list(int32_t i, const void* data);

    abi::KernelStatus run(openfab_isa isa);

  private:
    const openfab_kernel* kernel_ = nullptr;
    int32_t n_ = 0;
    int32_t block_size_ = 0;
    std::vector<void*> args_;
    std::unique_ptr<abi::KernelBuffer[]> buffers_;
    size_t buffer_count_ = 0;
};

}  // namespace openfab::slab
