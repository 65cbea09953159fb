// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/stages.h"

#include <array>

#include "runtime/abi/voxel_hash.h"
#include "runtime/slab/plain_dither.h"

namespace openfab::slab {

namespace {

constexpr halide_type_t kFloat{halide_type_float, 32, 1};
constexpr halide_type_t kInt32{halide_type_int, 32, 1};
constexpr halide_type_t kUint16{halide_type_uint, 16, 1};
constexpr halide_type_t kUint8{halide_type_uint, 8, 1};

openfab_kernel_fn pick(const openfab_kernel_fn* by_isa, openfab_isa isa) {
    return by_isa[isa] != nullptr ? by_isa[isa] : by_isa[OPENFAB_ISA_SSE41];
}

}  // namespace

const openfab_stage_set* find_stage_set(int32_t materials) {
    for (int32_t i = 0; i < openfab_stage_table.set_count; ++i) {
        if (openfab_stage_table.sets[i].materials >= materials) return &openfab_stage_table.sets[i];
    }
    return nullptr;
}

StageCalls::StageCalls(const openfab_stage_set& set, openfab_isa isa, DitherRule rule,
                       uint64_t seed)
    : set_(set),
      isa_(isa),
      rule_(rule),
      seed_(abi::fold_seed(seed)),
      error_buffers_(static_cast<size_t>(set.materials) + 2) {}

int StageCalls::normalise(const float* weights, int32_t slots, const int32_t* slot_material,
                          const uint8_t* owned, int32_t n, uint16_t* fractions, uint8_t* codes,
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
    return pick(set_.normalise, isa_)(args);
}

int StageCalls::dither(const DitherRow& row, float* errors, int32_t width) {
    if (rule_ == DitherRule::kBlueNoise || rule_ == DitherRule::kMajority) {
        pick_row(rule_, row, channels(), seed_);
        return 0;
    }
    const openfab_kernel_fn kernel =
        pick(rule_ == DitherRule::kFloydSteinberg ? set_.floyd_steinberg : set_.decorrelated, isa_);
    if (kernel != nullptr) return diffuse(kernel, row, errors, width);
    diffuse_row(rule_, row, channels(), seed_, errors, width);
    return 0;
}

int StageCalls::diffuse(openfab_kernel_fn kernel, const DitherRow& row, float* errors,
                        int32_t width) {
    const int32_t voxels = 8 * row.blocks;
    abi::KernelBuffer fractions, tiles, above, here, below;
    fractions.set_dense(kUint16, row.fractions, {8, channels(), 8, 8, row.tile_count});
    tiles.set_dense(kInt32, row.tiles, {row.blocks});
    // The kernel's x is the voxel in the grid: each buffer begins one voxel before the run.
    for (auto [buffer, data] :
         {std::pair{&above, row.above}, {&here, row.here}, {&below, row.below}}) {
        buffer->set_dim(0, voxels + 2, 1, row.first_x - 1);
        buffer->set(kUint8, data - 1, 1);
    }

    int32_t parity = row.y & 1;
    const int32_t voxel_stride = 8 * channels();
    const int32_t row_stride = (width + 2 * kRowMargin) * voxel_stride;
    float* first = errors + static_cast<int64_t>(row.first_x + kRowMargin - 1) * voxel_stride;
    std::array<void*, 10 + OPENFAB_MAX_MATERIALS_4BIT + 2> args{};
    for (int32_t m = 0; m <= channels(); ++m) {
        abi::KernelBuffer& buffer = error_buffers_[static_cast<size_t>(m)];
        const bool is_codes = m == channels();
        buffer.set_dim(0, 8, 1);
        buffer.set_dim(1, voxels + 2, is_codes ? 8 : voxel_stride, row.first_x - 1);
        // The kernel touches codes at p = parity only, so one row stands for both.
        buffer.set_dim(2, 2, is_codes ? 0 : row_stride);
        if (is_codes) {
            buffer.set(kUint8, row.codes - 8, 3);
        } else {
            buffer.set(kFloat, first + 8 * m, 3);
        }
        args[10 + static_cast<size_t>(m)] = buffer.raw();
    }
    int32_t first_x = row.first_x, y = row.y, z = row.z;
    uint32_t seed = seed_;
    args[0] = fractions.raw();
    args[1] = tiles.raw();
    args[2] = above.raw();
    args[3] = here.raw();
    args[4] = below.raw();
    args[5] = &first_x;
    args[6] = &y;
    args[7] = &z;
    args[8] = &seed;
    args[9] = &parity;
    return kernel(args.data());
}

int StageCalls::pack(int32_t bits, const uint8_t* codes, int64_t code_stride, int32_t bytes,
                     int32_t rows, uint8_t* planes, int64_t row_stride, int64_t plane_stride) {
    abi::KernelBuffer in, out;
    in.set_dim(0, 8, 1);
    in.set_dim(1, 8 / bits * bytes, 8);
    in.set_dim(2, rows, static_cast<int32_t>(code_stride));
    in.set(kUint8, codes, 3);
    out.set_dim(0, bytes, 1);
    out.set_dim(1, rows, static_cast<int32_t>(row_stride));
    out.set_dim(2, 8, static_cast<int32_t>(plane_stride));
    out.set(kUint8, planes, 3);
    void* args[2] = {in.raw(), out.raw()};
    return pick(bits == 4 ? openfab_stage_table.pack4 : openfab_stage_table.pack8, isa_)(args);
}

}  // namespace openfab::slab
