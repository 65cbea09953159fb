// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/band.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "abi/voxel_hash.h"
#include "base/check.h"
#include "base/stage_timer.h"
#include "runtime/dither/support_fill.h"

namespace openfab::dither {

bool SlabPlanes::reset(int32_t grid_width, int32_t grid_height, int32_t voxel_bits) {
    OPENFAB_CHECK(voxel_bits == 4 || voxel_bits == 8);
    const int64_t before = plane_bytes;
    bits = voxel_bits;
    width = grid_width;
    height = grid_height;
    row_bytes = (int64_t{grid_width} * bits + 7) / 8;
    plane_bytes = row_bytes * grid_height;
    const auto bytes = static_cast<size_t>(plane_bytes) * 8;
    if (data == nullptr || plane_bytes != before) {
        data.reset(static_cast<uint8_t*>(std::calloc(bytes, 1)));
        return data != nullptr;
    }
    tbb::this_task_arena::isolate([&] {
        constexpr size_t kPiece = size_t{4} << 20;
        tbb::parallel_for(tbb::blocked_range<size_t>(0, bytes, kPiece), [&](const auto& piece) {
            std::memset(data.get() + piece.begin(), 0, piece.size());
        });
    });
    return true;
}

SlabDither::SlabDither(int32_t channels, openfab_isa isa, DitherRule rule, uint64_t seed,
                       const Vec3i& size, const SupportFill* support)
    : support_(support) {
    setup_ = {rule, isa, abi::fold_seed(seed), channels, (size.x + 7) / 8 * 8};
    OPENFAB_CHECK_LE(setup_.channels, OPENFAB_MAX_MATERIALS + 1);
    // Never cleared again: errors of voxels that are not mixed are masked out, but must be finite.
    errors_.assign(error_count(setup_), 0.0f);
    nothing_mixed_.assign(static_cast<size_t>(setup_.width + 2 * kRowMargin), 0);
}

void SlabDither::begin(int32_t slab, uint8_t slices, SlabPlanes* planes) {
    OPENFAB_CHECK(held_ == nullptr);  // the previous slab has ended
    OPENFAB_CHECK_NE(slices, 0);
    z_ = 8 * slab;
    slices_ = slices;
    planes_ = planes;
}

abi::KernelStatus SlabDither::add(RowBand* band, RowBand** released) {
    OPENFAB_CHECK(planes_ != nullptr);
    if (held_ != nullptr) OPENFAB_CHECK_LT(held_->row, band->row);
    const uint8_t* nothing = nothing_mixed_.data() + kRowMargin;
    const bool adjacent = held_ != nullptr && held_->row + 1 == band->row;
    abi::KernelStatus status;
    if (held_ != nullptr) status = finish_held(adjacent ? band->mixed_row(0) : nothing);
    if (status.ok() && band->any_mixed)
        dither_rows(band, 0, 7, adjacent ? held_->mixed_row(7) : nothing, band->mixed_row(7));
    *released = held_;
    held_ = band;
    return status;
}

abi::KernelStatus SlabDither::end(RowBand** released) {
    const abi::KernelStatus status =
        held_ != nullptr ? finish_held(nothing_mixed_.data() + kRowMargin) : abi::KernelStatus();
    *released = held_;
    held_ = nullptr;
    return status;
}

abi::KernelStatus SlabDither::finish_held(const uint8_t* below) {
    if (held_->any_mixed) dither_rows(held_, 7, 1, held_->mixed_row(6), below);
    if (support_ != nullptr && support_->on()) {
        const StageTimer timer(Stage::kSupport, &seconds_support);
        add_support(*support_, z_, planes_->height, held_);
        if (supported) supported(held_);
    }
    const StageTimer timer(Stage::kPack, &seconds_pack);
    // Bytes of a row; a block takes as many bytes as a voxel has bits.
    const int32_t bits = planes_->bits;
    const int32_t first = bits * held_->first_block;
    const int32_t end =
        static_cast<int32_t>(std::min<int64_t>(bits * held_->end_block, planes_->row_bytes));
    return pack_held(first, end);
}

/// Copies bytes [first, end) of each row.
abi::KernelStatus SlabDither::pack_held(int32_t first, int32_t end) {
    const int32_t bits = planes_->bits, y = 8 * held_->row;
    const int32_t rows = std::min(8, planes_->height - y);
    if (end <= first || rows <= 0) return {};
    uint8_t* to = planes_->data.get() + y * planes_->row_bytes + first;
    if (!std::has_single_bit(slices_)) {
        return abi::pack(setup_.isa, bits, held_->codes_at(8 * held_->first_block, 0),
                         8 * held_->width(), end - first, rows, to, planes_->row_bytes,
                         planes_->plane_bytes);
    }
    const int32_t z = std::countr_zero(slices_);
    to += z * planes_->plane_bytes;
    for (int32_t row = 0; row < rows; ++row, to += planes_->row_bytes) {
        const uint8_t* from = held_->codes_at(8 * held_->first_block, row) + z;
        for (int32_t b = 0; b < end - first; ++b) {
            to[b] = bits == 8 ? from[8 * b]
                              : static_cast<uint8_t>(from[16 * b] | from[16 * b + 8] << 4);
        }
    }
    return {};
}

// `above` is the row before the first, `below` the one after the last.
void SlabDither::dither_rows(RowBand* band, int32_t first, int32_t count, const uint8_t* above,
                             const uint8_t* below) {
    const StageTimer timer(Stage::kDither, &seconds_dither);
    for (int32_t b = band->first_block; b < band->end_block; ++b) {
        if (band->mixed_blocks[b] == 0) continue;
        int32_t end = b + 1;
        while (end < band->end_block && band->mixed_blocks[end] != 0)
            ++end;
        std::array<DitherRow, 8> rows;
        for (int32_t i = 0; i < count; ++i) {
            const int32_t y = first + i;
            DitherRow& row = rows[i];
            row.fractions = band->fractions.data();
            row.blocks = end - b;
            row.first_x = 8 * b;
            row.columns = &band->columns[static_cast<size_t>(y * band->width() + row.first_x)];
            row.above = (i == 0 ? above : band->mixed_row(y - 1)) + row.first_x;
            row.here = band->mixed_row(y) + row.first_x;
            row.below = (i + 1 == count ? below : band->mixed_row(y + 1)) + row.first_x;
            row.y = 8 * band->row + y;
            row.z = z_;
            row.codes = band->codes_at(row.first_x, y);
        }
        dither::dither_rows(setup_, rows.data(), count, errors_.data());
        b = end;
    }
}

}  // namespace openfab::dither
