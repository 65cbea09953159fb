// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/stages.h"

#include "base/check.h"

namespace openfab::abi {

namespace {

constexpr halide_type_t kFloat{halide_type_float, 32, 1};
constexpr halide_type_t kInt32{halide_type_int, 32, 1};
constexpr halide_type_t kUint16{halide_type_uint, 16, 1};
constexpr halide_type_t kUint64{halide_type_uint, 64, 1};
constexpr halide_type_t kUint8{halide_type_uint, 8, 1};

abi::KernelStatus run(const openfab_kernel_fn* by_isa, openfab_isa isa, void** args) {
    const openfab_kernel_fn fn = abi::function_for(by_isa, isa);
    OPENFAB_CHECK(fn != nullptr);
    return abi::KernelStatus::of_code(fn(args));
}

}  // namespace

const openfab_stage_set* find_stage_set(int32_t materials) {
    for (int32_t i = 0; i < openfab_stage_table.set_count; ++i) {
        if (openfab_stage_table.sets[i].materials >= materials) return &openfab_stage_table.sets[i];
    }
    return nullptr;
}

abi::KernelStatus StageCalls::normalise(const float* weights, int32_t slots,
                                        const int32_t* slot_material, const uint8_t* owned,
                                        int32_t n, uint16_t* fractions, uint8_t* codes,
                                        int32_t* unusable) {
    abi::KernelBuffer buffers[6];
    buffers[0].set_dense(kFloat, weights, {8, 8, 8, slots, n});
    buffers[1].set_dense(kInt32, slot_material, {slots});
    buffers[2].set_dense(kUint8, owned, {8, 8, n});
    buffers[3].set_dense(kUint16, fractions, {8, channels(), 8, 8, n});
    buffers[4].set_dense(kUint8, codes, {8, 8, 8, n});
    buffers[5].set_dense(kInt32, unusable, {8, n});
    void* args[6];
    for (size_t i = 0; i < 6; ++i)
        args[i] = buffers[i].raw();
    return run(set_.normalise, isa_, args);
}

abi::KernelStatus StageCalls::pack(int32_t bits, const uint8_t* codes, int64_t code_stride,
                                   int32_t bytes, int32_t rows, uint8_t* planes, int64_t row_stride,
                                   int64_t plane_stride) {
    OPENFAB_CHECK(bits == 4 || bits == 8);
    abi::KernelBuffer in, out;
    in.set_dim(0, 8 / bits * bytes, 1);
    in.set_dim(1, rows, static_cast<int32_t>(code_stride / 8));
    in.set(kUint64, codes, 2);
    out.set_dim(0, bytes, 1);
    out.set_dim(1, rows, static_cast<int32_t>(row_stride));
    out.set_dim(2, 8, static_cast<int32_t>(plane_stride));
    out.set(kUint8, planes, 3);
    void* args[2] = {in.raw(), out.raw()};
    const openfab_kernel_fn* pack =
        bits == 4 ? openfab_stage_table.pack4 : openfab_stage_table.pack8;
    return abi::KernelStatus::of_code(function_for(pack, isa_)(args));
}

}  // namespace openfab::abi
