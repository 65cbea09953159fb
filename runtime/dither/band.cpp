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

namespace {

// 0x00 or 0xff in byte z for each bit z.
uint64_t spread(uint8_t bits) {
    const uint64_t each = (bits * 0x0101010101010101u) & 0x8040201008040201u;
    return ((each + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u) * 255u;
}

// Bit z where byte z is OPENFAB_CODE_MIXED, whose bits are all set.
uint8_t mixed_bits(uint64_t codes) {
    constexpr uint64_t kLow = 0x7f7f7f7f7f7f7f7fu;
    const uint64_t other = ~codes;
    const uint64_t mixed = ~(((other & kLow) + kLow) | other | kLow);  // bit 7 of such bytes
    return static_cast<uint8_t>(((mixed >> 7) * 0x0102040810204080u) >> 56);
}

uint64_t load8(const uint8_t* p) {
    uint64_t v;
    std::memcpy(&v, p, 8);
    return v;
}

}  // namespace

void RowBand::reset(int32_t row_index, int32_t block_columns, int32_t channel_count, int32_t first,
                    int32_t end) {
    channels = channel_count;
    if (blocks != block_columns) {
        blocks = block_columns;
        codes.assign(static_cast<size_t>(width()) * 64, 0);
        mixed.assign(static_cast<size_t>(mixed_stride()) * 8, 0);
        mixed_blocks.assign(static_cast<size_t>(blocks), 0);
        columns.resize(static_cast<size_t>(width()) * 8);
    } else if (first_block < end_block) {
        for (int32_t y = 0; y < 8; ++y) {
            std::memset(codes_at(8 * first_block, y), 0,
                        static_cast<size_t>(end_block - first_block) * 64);
            std::memset(mixed_row(y) + 8 * first_block, 0,
                        static_cast<size_t>(end_block - first_block) * 8);
        }
        std::fill(mixed_blocks.begin() + first_block, mixed_blocks.begin() + end_block, 0);
    }
    row = row_index;
    first_block = first;
    end_block = end;
    any_mixed = false;
    fractions.clear();
}

void RowBand::fill(int32_t block, const uint8_t* owned, uint8_t code) {
    const uint64_t all = code * 0x0101010101010101u;
    for (int32_t y = 0; y < 8; ++y) {
        uint8_t* out = codes_at(8 * block, y);
        if (load8(owned + y * 8) == ~uint64_t{0}) {
            std::memset(out, code, 64);
            continue;
        }
        for (int32_t x = 0; x < 8; ++x, out += 8) {
            const uint8_t bits = owned[y * 8 + x];
            if (bits == 0) continue;
            const uint64_t mask = spread(bits);
            const uint64_t value = (load8(out) & ~mask) | (all & mask);
            std::memcpy(out, &value, 8);
        }
    }
}

void RowBand::fill_column(int32_t block, int32_t column, uint8_t voxels, uint8_t code) {
    uint8_t* out = codes_at(8 * block + column % 8, column / 8);
    const uint64_t mask = spread(voxels), all = code * 0x0101010101010101u;
    const uint64_t value = (load8(out) & ~mask) | (all & mask);
    std::memcpy(out, &value, 8);
}

int32_t RowBand::add_columns(size_t count) {
    const size_t column_values = static_cast<size_t>(8 * channels);
    const size_t before = fractions.size();
    fractions.resize(before + count * column_values);
    return static_cast<int32_t>(before / column_values);
}

void RowBand::merge(int32_t block, const uint8_t* owned, const EvaluatedColumns& evaluated) {
    const uint8_t* from = evaluated.codes;
    int32_t number = evaluated.fractions;
    bool has_mixed = false;
    for (const int32_t listed : evaluated.columns) {
        const int32_t column = listed & 63, x = 8 * block + column % 8, y = column / 8;
        const uint8_t bits = owned[column];
        const uint64_t given = load8(from);
        uint8_t* out = codes_at(x, y);
        if (bits == 255) {
            std::memcpy(out, &given, 8);
        } else {
            const uint64_t mask = spread(bits);
            const uint64_t value = (load8(out) & ~mask) | (given & mask);
            std::memcpy(out, &value, 8);
        }
        const auto voxels = static_cast<uint8_t>(mixed_bits(given) & bits);
        if (voxels != 0) {
            has_mixed = true;
            uint8_t& marks = mixed_row(y)[x];
            int32_t& at = columns[static_cast<size_t>(y * width() + x)];
            // Another part may have voxels of this column, and its fractions.
            at = marks == 0 ? number : blend_columns(at, number, voxels);
            marks = static_cast<uint8_t>(marks | voxels);
        }
        if (evaluated.alike) continue;
        from += 8;
        ++number;
    }
    if (!has_mixed) return;
    any_mixed = true;
    mixed_blocks[block] = 1;
}

// Adds a column with the fractions of `other` in some voxels and those of `column` in the rest.
int32_t RowBand::blend_columns(int32_t column, int32_t other, uint8_t voxels) {
    const int32_t added = add_columns(1);
    const uint16_t *rest = fractions_at(column), *mine = fractions_at(other);
    uint16_t* to = fractions_at(added);
    for (int32_t i = 0; i < 8 * channels; ++i)
        to[i] = (voxels >> i % 8 & 1) != 0 ? mine[i] : rest[i];
    return added;
}

size_t RowBand::bytes() const {
    return codes.capacity() + mixed.capacity() + mixed_blocks.capacity() + columns.capacity() * 4 +
           fractions.capacity() * 2;
}

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
