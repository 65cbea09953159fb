// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/coarser.h"

#include <algorithm>

namespace openfab::zarr {

namespace {

constexpr int32_t kLanes = 64;

}  // namespace

void halve_rows(const std::array<const uint8_t*, 4>& rows, int32_t width, uint8_t* out) {
    const int32_t pairs = width / 2;
    // Loops over lanes of bytes, which compilers turn into vectors.
    for (int32_t from = 0; from < pairs; from += kLanes) {
        const int32_t lanes = std::min(kLanes, pairs - from);
        uint8_t code[8][kLanes] = {};
        for (size_t r = 0; r < 4; ++r) {
            const uint8_t* const row = rows[r] + 2 * static_cast<size_t>(from);
            for (int32_t i = 0; i < lanes; ++i) {
                code[2 * r][i] = row[2 * i];
                code[2 * r + 1][i] = row[2 * i + 1];
            }
        }
        uint8_t best[kLanes] = {}, most[kLanes] = {};
        for (const auto& candidate : code) {
            uint8_t count[kLanes] = {};
            for (const auto& other : code) {
                for (int32_t i = 0; i < kLanes; ++i)
                    count[i] = static_cast<uint8_t>(count[i] + (candidate[i] == other[i] ? 1 : 0));
            }
            for (int32_t i = 0; i < kLanes; ++i) {
                const bool more = count[i] > most[i];
                const bool lower = count[i] == most[i] && candidate[i] < best[i];
                best[i] = more || lower ? candidate[i] : best[i];
                most[i] = std::max(most[i], count[i]);
            }
        }
        std::copy_n(best, lanes, out + from);
    }
    if (width % 2 == 0) return;
    // The last column: each voxel counts twice, which changes no order.
    const std::array<uint8_t, 4> last{rows[0][width - 1], rows[1][width - 1], rows[2][width - 1],
                                      rows[3][width - 1]};
    uint8_t best = 255;
    std::ptrdiff_t most = 0;
    for (const uint8_t candidate : last) {
        const std::ptrdiff_t count = std::count(last.begin(), last.end(), candidate);
        if (count < most || (count == most && candidate >= best)) continue;
        best = candidate;
        most = count;
    }
    out[pairs] = best;
}

}  // namespace openfab::zarr
