// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/stages.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"

namespace openfab::abi {

namespace {

constexpr halide_type_t kFloat{halide_type_float, 32, 1};
constexpr halide_type_t kInt32{halide_type_int, 32, 1};
constexpr halide_type_t kUint16{halide_type_uint, 16, 1};
constexpr halide_type_t kUint64{halide_type_uint, 64, 1};
constexpr halide_type_t kUint8{halide_type_uint, 8, 1};

KernelStatus run(const openfab_kernel_fn* by_isa, openfab_isa isa, void** args) {
    const openfab_kernel_fn fn = function_for(by_isa, isa);
    OPENFAB_CHECK(fn != nullptr);
    return KernelStatus::of_code(fn(args));
}

}  // namespace

Channels::Channels(std::span<const int32_t> slot_material)
    : count_(static_cast<int32_t>(slot_material.size()) + 1) {
    std::vector<int32_t> order(slot_material.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int32_t slot) { return slot_material[slot]; });
    table_ = {0, 0, 0};
    for (const int32_t slot : order) {
        const int32_t material = slot_material[slot];
        int32_t& before = table_.back();
        const bool joins = before == material;
        if (joins) before = -1;
        table_.insert(table_.end(), {slot, joins ? 1 : 0, material});
    }
}

KernelStatus normalise(openfab_isa isa, std::span<const int32_t> groups, const Channels& channels,
                       const float* weights, int64_t slot_stride, uint16_t* fractions,
                       uint8_t* codes, uint16_t* unusable) {
    const auto m = static_cast<int32_t>(groups.size());
    const int32_t slots = channels.count() - 1;
    KernelBuffer buffers[6];
    buffers[0].set_dense(kInt32, groups.data(), {m});
    buffers[1].set_dense(kInt32, channels.table(), {OPENFAB_CHANNEL_ROWS, channels.count()});
    buffers[2].set_dim(0, 8, 1);
    buffers[2].set_dim(1, static_cast<int32_t>(slot_stride / 8), 8);
    buffers[2].set_dim(2, slots, static_cast<int32_t>(slot_stride));
    buffers[2].set(kFloat, weights, 3);
    buffers[3].set_dense(kUint16, fractions, {8, channels.count(), m});
    buffers[4].set_dense(kUint8, codes, {8, m});
    buffers[5].set_dense(kUint16, unusable, {8, m});
    void* args[6];
    for (size_t i = 0; i < 6; ++i)
        args[i] = buffers[i].raw();
    return run(openfab_stage_table.normalise, isa, args);
}

KernelStatus pack(openfab_isa isa, int32_t bits, const uint8_t* codes, int64_t code_stride,
                  int32_t bytes, int32_t rows, uint8_t* planes, int64_t row_stride,
                  int64_t plane_stride) {
    OPENFAB_CHECK(bits == 4 || bits == 8);
    KernelBuffer in, out;
    in.set_dim(0, 8 / bits * bytes, 1);
    in.set_dim(1, rows, static_cast<int32_t>(code_stride / 8));
    in.set(kUint64, codes, 2);
    out.set_dim(0, bytes, 1);
    out.set_dim(1, rows, static_cast<int32_t>(row_stride));
    out.set_dim(2, 8, static_cast<int32_t>(plane_stride));
    out.set(kUint8, planes, 3);
    void* args[2] = {in.raw(), out.raw()};
    return run(bits == 4 ? openfab_stage_table.pack4 : openfab_stage_table.pack8, isa, args);
}

}  // namespace openfab::abi
