// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/coarser.h"

#include <algorithm>
#include <cstring>

namespace openfab::zarr {

namespace {

/// Of each lane its own voxel. A comparison gives 255 or 0.
typedef uint8_t Bytes __attribute__((vector_size(16)));
constexpr int32_t kLanes = 16;
using Eight = std::array<Bytes, 8>;

/// Takes two voxels of each row for each lane; lanes behind those that are there get zeros.
Eight load(const std::array<const uint8_t*, 4>& rows, int32_t from, int32_t lanes) {
    Eight codes;
    for (size_t r = 0; r < rows.size(); ++r) {
        Bytes low{}, high{};
        const uint8_t* const row = rows[r] + 2 * static_cast<size_t>(from);
        if (lanes == kLanes) {
            std::memcpy(&low, row, sizeof low);
            std::memcpy(&high, row + sizeof low, sizeof high);
        } else {
            uint8_t padded[2 * sizeof low] = {};
            std::copy_n(row, 2 * lanes, padded);
            std::memcpy(&low, padded, sizeof low);
            std::memcpy(&high, padded + sizeof low, sizeof high);
        }
        codes[2 * r] = __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22,
                                               24, 26, 28, 30);
        codes[2 * r + 1] = __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21,
                                                   23, 25, 27, 29, 31);
    }
    return codes;
}

bool is_zero(const Bytes& bytes) {
    std::array<uint64_t, 2> halves{};
    std::memcpy(halves.data(), &bytes, sizeof bytes);
    return (halves[0] | halves[1]) == 0;
}

Bytes most_frequent(const Eight& codes) {
    Bytes differ{};
    for (size_t i = 1; i < codes.size(); ++i)
        differ |= codes[i] ^ codes[0];
    if (is_zero(differ)) return codes[0];
    Eight count{};
    for (size_t i = 0; i < codes.size(); ++i) {
        for (size_t j = i + 1; j < codes.size(); ++j) {
            const auto equal = reinterpret_cast<Bytes>(codes[i] == codes[j]);
            count[i] -= equal;
            count[j] -= equal;
        }
    }
    Bytes best = codes[0], most = count[0];
    for (size_t i = 1; i < codes.size(); ++i) {
        const auto better =
            reinterpret_cast<Bytes>((count[i] > most) | ((count[i] == most) & (codes[i] < best)));
        best = (codes[i] & better) | (best & ~better);
        most = (count[i] & better) | (most & ~better);
    }
    return best;
}

}  // namespace

void halve_rows(const std::array<const uint8_t*, 4>& rows, int32_t width, uint8_t* out) {
    const int32_t pairs = width / 2;
    for (int32_t from = 0; from < pairs; from += kLanes) {
        const int32_t lanes = std::min(kLanes, pairs - from);
        const Bytes best = most_frequent(load(rows, from, lanes));
        std::memcpy(out + from, &best, static_cast<size_t>(lanes));
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
