// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/fraction_rows.h"

#include <algorithm>
#include <vector>

namespace openfab::pipeline {

namespace {

/// Writes the fractions of one voxel; `channels` of them lie 8 apart, void first.
void put_mixture(const uint16_t* channels, int32_t materials, float* out) {
    for (int32_t m = 0; m < materials; ++m)
        out[m] = static_cast<float>(channels[8 * (m + 1)]) / 65535.0f;
}

}  // namespace

void write_fractions(const dither::RowBand& band, int32_t slab, uint8_t slices, const Vec3i& size,
                     int32_t materials, FractionSink* sink) {
    const int32_t first_x = 8 * band.first_block;
    const int32_t end_x = std::min(8 * band.end_block, size.x);
    if (first_x >= end_x) return;
    std::vector<float> row(static_cast<size_t>(end_x - first_x) * static_cast<size_t>(materials));
    for (int32_t y = 0; y < std::min(8, size.y - 8 * band.row); ++y) {
        const size_t at = static_cast<size_t>(y) * static_cast<size_t>(band.width());
        const uint8_t* mixed = band.mixed_row(y);
        for (int32_t z = 0; z < 8; ++z) {
            if ((slices >> z & 1) == 0) continue;
            std::fill(row.begin(), row.end(), 0.0f);
            float* out = row.data();
            for (int32_t x = first_x; x < end_x; ++x, out += materials) {
                if ((mixed[x] >> z & 1) != 0) {
                    const auto column = static_cast<size_t>(band.columns[at + x]);
                    put_mixture(
                        &band.fractions[column * static_cast<size_t>(8 * band.channels) + z],
                        materials, out);
                } else if (const uint8_t code = band.codes[(at + x) * 8 + z]; code != 0) {
                    out[code - 1] = 1.0f;
                }
            }
            sink->write(8 * slab + z, 8 * band.row + y, first_x, row);
        }
    }
}

void write_rates(const volume::RowRates& rates, int32_t slab, int32_t row, uint8_t slices,
                 const Vec3i& size, FractionSink* sink) {
    const size_t per_voxel = rates.per_voxel();
    const size_t per_line = static_cast<size_t>(size.x) * per_voxel;
    std::vector<float> lines(8 * per_line);
    for (int32_t y = 0; y < std::min(8, size.y - 8 * row); ++y) {
        for (int32_t x = 0; x < size.x; ++x) {
            const float* from = rates.at(x, y, 0);
            float* to = &lines[static_cast<size_t>(x) * per_voxel];
            for (size_t number = 0; number < per_voxel; ++number) {
                for (size_t z = 0; z < 8; ++z)
                    to[z * per_line + number] = from[8 * number + z];
            }
        }
        for (int32_t z = 0; z < 8; ++z) {
            if ((slices >> z & 1) == 0) continue;
            sink->write_rates(
                8 * slab + z, 8 * row + y, 0,
                std::span(lines).subspan(static_cast<size_t>(z) * per_line, per_line));
        }
    }
}

}  // namespace openfab::pipeline
