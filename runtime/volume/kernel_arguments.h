// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The argument array of a fablet's kernel for one call. One object per thread, reused: a call
// allocates nothing once the arrays have grown to the longest argument list.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/kernel_call.h"
#include "abi/nearest_stage.h"
#include "runtime/volume/placed_part.h"

namespace openfab::volume {

/// Returns the address of an argument that is the same for all blocks: a scalar, or `buffer`,
/// filled, for a texture or a mask. Null for others.
const void* part_argument(const PlacedPart& part, const openfab_arg& arg,
                          abi::KernelBuffer* buffer);

class KernelArguments {
  public:
    /// Starts the list of `kernel` for n blocks or cubes of `block_size` voxels a side; `corners`:
    /// 3 part-relative indices each. Sets all arguments that are not per voxel; the caller sets the
    /// rest, for which `is_set` is false.
    void begin(const openfab_kernel& kernel, const PlacedPart& part, const int32_t* corners,
               int32_t n, int32_t block_size);
    bool is_set(int32_t i) const { return args_[i] != nullptr; }

    /// Sets the columns that the call lists; for kernels that take such a list.
    void set_groups(std::span<const int32_t> columns);
    /// Sets the source of what the call reads of nearest surface points.
    void set_source(int32_t i, openfab_nearest_source* source);
    /// Sets an output of 8 values for each listed column, `stride` apart.
    void set_columns(int32_t i, const void* data, int32_t stride = 8);
    /// Sets an input of `count` values.
    void set_values(int32_t i, const void* data, int32_t count);
    /// Sets the outputs of a packed kernel: `count` values of each cube, those of all cubes one after
    /// the other.
    void set_packed(int32_t i, const void* data, int32_t count);
    /// Sets the outputs of a packed slab kernel: 8 values of each listed column, `count` times one
    /// after the other.
    void set_packed_columns(int32_t i, const void* data, int32_t count);
    /// Sets a buffer of one value for each cube.
    void set_list(int32_t i, const void* data);

    abi::KernelStatus run(openfab_isa isa);

  private:
    const openfab_kernel* kernel_ = nullptr;
    int32_t n_ = 0;
    int32_t columns_ = 0;
    openfab_nearest_source* source_ = nullptr;
    int32_t block_size_ = 0;
    std::vector<void*> args_;
    std::unique_ptr<abi::KernelBuffer[]> buffers_;
    size_t buffer_count_ = 0;
};

}  // namespace openfab::volume
