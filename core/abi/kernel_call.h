// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls generated kernels through Halide's argv convention. A KernelCall is made once per thread
// and kernel; it holds the argument array, so that a call in the per-block path allocates nothing.

#include <HalideRuntime.h>

#include <cstdint>
#include <span>
#include <vector>

#include "abi/fablet_table.h"
#include "abi/kernel_status.h"
#include "base/check.h"

namespace openfab::abi {

/// Returns the best instruction set that this machine has and `limit` allows (OPENFAB_ISA_AVX512
/// allows everything).
openfab_isa best_isa(openfab_isa limit = OPENFAB_ISA_AVX512);

/// Returns the instruction sets that kernels can be compiled for on machines of this one's kind, in
/// order.
std::span<const openfab_isa> isas();

/// Returns the instruction set's name in options and file names, "avx2", and in sentences, "AVX2".
const char* isa_name(openfab_isa isa);
const char* isa_title(openfab_isa isa);

inline halide_type_t halide_type(openfab_scalar_type type) {
    switch (type) {
        case OPENFAB_FLOAT:
            return {halide_type_float, 32, 1};
        case OPENFAB_UINT:
            return {halide_type_uint, 32, 1};
        case OPENFAB_INT:
        case OPENFAB_BOOL:
            break;
    }
    return {halide_type_int, 32, 1};
}

/// Returns the type of an argument's elements.
inline halide_type_t halide_type(const openfab_arg& arg) {
    if (arg.kind == OPENFAB_ARG_CODE || arg.kind == OPENFAB_ARG_DEMAND ||
        arg.kind == OPENFAB_ARG_CHOICE)
        return {halide_type_uint, 8, 1};
    if (arg.kind == OPENFAB_ARG_FRACTION || arg.kind == OPENFAB_ARG_UNUSABLE ||
        arg.kind == OPENFAB_ARG_BLUE_NOISE)
        return {halide_type_uint, 16, 1};
    return halide_type(arg.scalar);
}

/// A halide_buffer_t that carries its own dimensions; it does not own the data. Not copyable:
/// `raw.dim` points inside.
class KernelBuffer {
  public:
    KernelBuffer() = default;
    KernelBuffer(const KernelBuffer&) = delete;
    KernelBuffer& operator=(const KernelBuffer&) = delete;

    /// Sets a dense shape (extents[0], …), innermost first.
    void set_dense(halide_type_t type, const void* data, std::initializer_list<int32_t> extents) {
        int32_t stride = 1;
        int d = 0;
        for (int32_t extent : extents) {
            set_dim(d++, extent, stride);
            stride *= extent;
        }
        set(type, data, d);
    }
    void set_dim(int d, int32_t extent, int32_t stride, int32_t min = 0) {
        OPENFAB_DCHECK(d >= 0 && d < kMaxDimensions);
        dims_[d] = halide_dimension_t(min, extent, stride);
    }
    void set(halide_type_t type, const void* data, int dimensions) {
        raw_ = {};
        raw_.host = const_cast<uint8_t*>(static_cast<const uint8_t*>(data));
        raw_.type = type;
        raw_.dimensions = dimensions;
        raw_.dim = dims_;
    }
    /// Sets the shape (z 8, m) of `columns` columns of 8 voxels, `stride` elements apart.
    void set_columns(halide_type_t type, const void* data, int32_t columns, int32_t stride = 8) {
        set_dim(0, 8, 1);
        set_dim(1, columns, stride);
        set(type, data, 2);
    }
    halide_buffer_t* raw() { return &raw_; }

  private:
    static constexpr int kMaxDimensions = 6;
    halide_buffer_t raw_{};
    halide_dimension_t dims_[kMaxDimensions]{};
};

/// Returns the function for an instruction set; where there is none, that for the next one below.
inline openfab_kernel_fn function_for(const openfab_kernel_fn* by_isa, openfab_isa isa) {
    int k = isa;
    while (k > 0 && by_isa[k] == nullptr)
        --k;
    return by_isa[k];
}

/// Returns whether a kernel was compiled for any instruction set.
inline bool is_compiled(const openfab_kernel& kernel) {
    return function_for(kernel.fn, OPENFAB_ISA_AVX512) != nullptr;
}

/// The argument array of one kernel.
class KernelCall {
  public:
    KernelCall(const openfab_kernel& kernel, openfab_isa isa)
        : fn_(function_for(kernel.fn, isa)), args_(static_cast<size_t>(kernel.arg_count)) {}

    /// Sets an argument: a halide_buffer_t* or the address of a 32-bit scalar, which must outlive
    /// the calls.
    void set(int32_t index, const void* pointer) {
        OPENFAB_CHECK_LT(static_cast<size_t>(index), args_.size());
        args_[index] = const_cast<void*>(pointer);
    }
    bool exists() const { return fn_ != nullptr; }
    KernelStatus run() {
        OPENFAB_CHECK(exists());
        return KernelStatus::of_code(fn_(args_.data()));
    }

  private:
    openfab_kernel_fn fn_;
    std::vector<void*> args_;
};

}  // namespace openfab::abi
