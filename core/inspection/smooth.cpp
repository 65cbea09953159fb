// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "inspection/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace openfab::inspection {

namespace {

constexpr int32_t kMargin = 2;

/// The weighted sum of five rows.
void add_rows(const uint16_t* const* rows, int32_t count, uint16_t* out) {
    for (int32_t i = 0; i < count; ++i) {
        out[i] = static_cast<uint16_t>(rows[0][i] + rows[4][i] + 4 * (rows[1][i] + rows[3][i]) +
                                       6 * rows[2][i]);
    }
}

}  // namespace

Box<uint8_t> smooth(const Bits& bits, int outside) {
    const Vec3i& size = bits.size;
    Box<uint8_t> out(size);
    const auto width = static_cast<size_t>(size.x);
    tbb::parallel_for(0, size.z, [&](int32_t z) {
        // Sums over z, then y, then x, at most 16^3.
        const auto beyond = static_cast<uint16_t>(outside);
        std::vector<uint16_t> along_z(width * static_cast<size_t>(size.y));
        for (int32_t y = 0; y < size.y; ++y) {
            uint16_t* to = along_z.data() + static_cast<size_t>(y) * width;
            constexpr int kWeights[] = {1, 4, 6, 4, 1};
            for (int32_t d = -kMargin; d <= kMargin; ++d) {
                const auto weight = static_cast<uint16_t>(kWeights[d + kMargin]);
                const bool inside = z + d >= 0 && z + d < size.z;
                const uint8_t* from = inside ? &bits.values[bits.at(0, y, z + d)] : nullptr;
                for (size_t x = 0; x < width; ++x)
                    to[x] = static_cast<uint16_t>(to[x] + weight * (inside ? from[x] : beyond));
            }
        }
        const std::vector<uint16_t> outer(width, static_cast<uint16_t>(16 * beyond));
        std::vector<uint16_t> row(width + 2 * kMargin);
        for (int32_t y = 0; y < size.y; ++y) {
            const uint16_t* rows[5];
            for (int32_t d = -kMargin; d <= kMargin; ++d) {
                const bool inside = y + d >= 0 && y + d < size.y;
                rows[d + kMargin] =
                    inside ? along_z.data() + static_cast<size_t>(y + d) * width : outer.data();
            }
            std::fill(row.begin(), row.end(), static_cast<uint16_t>(256 * beyond));
            add_rows(rows, size.x, row.data() + kMargin);
            uint8_t* to = &out.values[out.at(0, y, z)];
            for (size_t x = 0; x < width; ++x) {
                const uint32_t sum =
                    row[x] + row[x + 4] + 4u * (row[x + 1] + row[x + 3]) + 6u * row[x + 2];
                to[x] = static_cast<uint8_t>((sum * 255 + 2048) >> 12);
            }
        }
    });
    return out;
}

}  // namespace openfab::inspection
