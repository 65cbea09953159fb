// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How many voxels masks of bits hold.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace openfab {

/// Counts the bits of bytes that `mask` has, too. Eight bytes at a time and by additions: std::popcount is a call of a
/// library, by a table, where the instruction for it may not be taken for granted.
inline int64_t count_bits(std::span<const uint8_t> bytes, uint8_t mask = 255) {
    constexpr uint64_t kEach = 0x0101010101010101u;
    int64_t count = 0;
    for (size_t i = 0; i < bytes.size(); i += 8) {
        uint64_t word = 0;
        if (bytes.size() - i >= 8)
            std::memcpy(&word, &bytes[i], 8);
        else
            std::memcpy(&word, &bytes[i], bytes.size() - i);
        word &= mask * kEach;
        if (word == 0) continue;
        word -= word >> 1 & 0x55 * kEach;
        word = (word & 0x33 * kEach) + (word >> 2 & 0x33 * kEach);
        word = (word + (word >> 4)) & 0x0f * kEach;
        count += static_cast<int64_t>(word * kEach >> 56);
    }
    return count;
}

}  // namespace openfab
