// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// CRC-32C (Castagnoli, RFC 3720), as Zarr has it behind the index of a shard and behind chunks. By a table: an index has 16 bytes for
// the 128 KiB of a chunk.

#include <array>
#include <cstdint>
#include <span>

namespace openfab {

namespace detail {

constexpr std::array<uint32_t, 256> make_crc32c_table() {
    constexpr uint32_t kPolynomial = 0x82f63b78;  // reflected
    std::array<uint32_t, 256> table{};
    for (uint32_t byte = 0; byte < table.size(); ++byte) {
        uint32_t rest = byte;
        for (int bit = 0; bit < 8; ++bit)
            rest = (rest >> 1) ^ ((rest & 1) != 0 ? kPolynomial : 0);
        table[byte] = rest;
    }
    return table;
}

inline constexpr std::array<uint32_t, 256> kCrc32cTable = make_crc32c_table();

}  // namespace detail

inline uint32_t crc32c(std::span<const uint8_t> bytes) {
    uint32_t rest = 0xffffffff;
    for (const uint8_t byte : bytes)
        rest = (rest >> 8) ^ detail::kCrc32cTable[(rest ^ byte) & 0xff];
    return ~rest;
}

}  // namespace openfab
