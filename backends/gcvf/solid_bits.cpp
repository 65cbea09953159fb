// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/solid_bits.h"

#include <cstring>
#include <vector>

#include "backends/common/tee_sink.h"

namespace openfab::gcvf {

void put_solid_bits(const pipeline::SliceView& slice, int32_t bits, std::span<uint8_t> out) {
    const size_t row_bytes = solid_row_bytes(slice.width);
    std::vector<uint8_t> codes(row_bytes * 8);
    for (int32_t y = 0; y < slice.height; ++y) {
        backends::unpack_row(slice, y, bits, codes.data());
        for (size_t i = 0; i < row_bytes; ++i) {
            uint64_t eight = 0;
            std::memcpy(&eight, codes.data() + 8 * i, sizeof eight);
            eight |= eight >> 4;
            eight |= eight >> 2;
            eight |= eight >> 1;
            // The product's highest byte collects bit 0 of each byte, the first one in its bit 0.
            eight = (eight & 0x0101010101010101) * 0x0102040810204080;
            out[row_bytes * static_cast<size_t>(y) + i] = static_cast<uint8_t>(eight >> 56);
        }
    }
}

}  // namespace openfab::gcvf
