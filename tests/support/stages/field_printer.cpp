// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/stages/field_printer.h"

#include <gtest/gtest.h>

#include <numeric>

#include "runtime/dither/band.h"

namespace openfab::testing {

namespace {

using reference::FractionField;
using reference::is_mixed;

uint8_t pure_code(const uint16_t* f, int32_t channels) {
    for (int32_t m = 0; m < channels; ++m) {
        if (f[m] > 0) return static_cast<uint8_t>(m);
    }
    return 0;
}

// One block of the field as the slab kernel would leave it.
struct Block {
    uint8_t owned[64] = {};
    uint8_t codes[512] = {};
    std::vector<uint16_t> fractions;
};

Block make_block(const FractionField& field, int32_t bx, int32_t by, int32_t bz) {
    Block block;
    block.fractions.assign(static_cast<size_t>(512) * field.channels, 0);
    for (int32_t y = 0; y < 8; ++y) {
        for (int32_t x = 0; x < 8; ++x) {
            for (int32_t z = 0; z < 8; ++z) {
                const Vec3i at{8 * bx + x, 8 * by + y, 8 * bz + z};
                if (at.x >= field.size.x || at.y >= field.size.y || at.z >= field.size.z) continue;
                const uint16_t* f = field.at(at.x, at.y, at.z);
                const int32_t voxel = y * 8 + x;
                block.owned[voxel] = static_cast<uint8_t>(block.owned[voxel] | 1 << z);
                block.codes[voxel * 8 + z] =
                    is_mixed(f, field.channels) ? OPENFAB_CODE_MIXED : pure_code(f, field.channels);
                for (int32_t m = 0; m < field.channels; ++m) {
                    block.fractions[static_cast<size_t>((voxel * field.channels + m) * 8 + z)] =
                        f[m];
                }
            }
        }
    }
    return block;
}

}  // namespace

std::vector<uint8_t> print_field(const FractionField& field, uint64_t seed, openfab_isa isa,
                                 dither::DitherRule rule) {
    EXPECT_EQ(dither::fraction_channels(field.channels - 1), field.channels);
    const int32_t bits = abi::voxel_bits(field.channels - 1);
    const Vec3i blocks{(field.size.x + 7) / 8, (field.size.y + 7) / 8, (field.size.z + 7) / 8};
    std::vector<uint8_t> codes(static_cast<size_t>(field.size.x) * field.size.y * field.size.z);
    dither::SlabDither dither(field.channels, isa, rule, seed, field.size);
    dither::SlabPlanes planes;
    dither::RowBand bands[2];
    std::vector<int32_t> all(64);
    std::iota(all.begin(), all.end(), 0);
    for (int32_t bz = 0; bz < blocks.z; ++bz) {
        EXPECT_TRUE(planes.reset(field.size.x, field.size.y, bits));
        dither.begin(field.origin.z / 8 + bz, 255, &planes);
        dither::RowBand* released = nullptr;
        for (int32_t by = 0; by < blocks.y; ++by) {
            dither::RowBand& band = bands[by % 2];
            band.reset(by, blocks.x, field.channels, 0, blocks.x);
            for (int32_t bx = 0; bx < blocks.x; ++bx) {
                const Block block = make_block(field, bx, by, bz);
                const int32_t first = band.add_columns(64);
                std::copy(block.fractions.begin(), block.fractions.end(), band.fractions_at(first));
                band.merge(bx, block.owned, {all, block.codes, first});
            }
            EXPECT_TRUE(dither.add(&band, &released).ok());
        }
        EXPECT_TRUE(dither.end(&released).ok());
        for (int32_t z = 0; z < 8 && 8 * bz + z < field.size.z; ++z) {
            for (int32_t y = 0; y < field.size.y; ++y) {
                const uint8_t* row =
                    planes.data.get() + z * planes.plane_bytes + y * planes.row_bytes;
                for (int32_t x = 0; x < field.size.x; ++x) {
                    codes[(static_cast<size_t>(8 * bz + z) * field.size.y + y) * field.size.x + x] =
                        bits == 8 ? row[x] : static_cast<uint8_t>(row[x / 2] >> (x % 2 * 4) & 15);
                }
            }
        }
    }
    return codes;
}

std::vector<openfab_isa> runnable_isas() {
    std::vector<openfab_isa> isas{OPENFAB_ISA_SSE41};
    if (abi::best_isa() >= OPENFAB_ISA_AVX2) isas.push_back(OPENFAB_ISA_AVX2);
    return isas;
}

}  // namespace openfab::testing
