// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "runtime/dither/band.h"

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

}  // namespace openfab::dither
