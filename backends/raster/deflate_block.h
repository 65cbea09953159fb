// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One deflate block with codes of its own (RFC 1951, "dynamic Huffman"), from symbols that someone
// else has chosen.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace openfab::raster {

/// Bits, lowest first, onto the end of a vector.
class BitWriter {
  public:
    explicit BitWriter(std::vector<uint8_t>* out) : out_(out) {}
    /// `count` <= 56.
    void put(uint64_t bits, int count) {
        buffer_ |= bits << used_;
        used_ += count;
        while (used_ >= 8) {
            out_->push_back(static_cast<uint8_t>(buffer_));
            buffer_ >>= 8;
            used_ -= 8;
        }
    }
    /// Fills the last byte with zeros.
    void align() {
        if (used_ > 0) put(0, 8 - used_);
    }

  private:
    std::vector<uint8_t>* out_;
    uint64_t buffer_ = 0;
    int used_ = 0;
};

/// A prefix code: of symbol s, `length[s]` bits (0: does not occur), to be written lowest bit first
/// from `bits[s]`.
struct PrefixCode {
    std::vector<uint8_t> length;
    std::vector<uint16_t> bits;
};

/// The code for symbols with these frequencies, no longer than `max_length` bits. At least one
/// symbol gets a code.
PrefixCode make_prefix_code(std::span<const uint32_t> frequencies, int max_length);

constexpr int kLiteralSymbols = 286;
constexpr int kDistanceSymbols = 30;
constexpr int kEndOfBlock = 256;

/// A length (3 … 258) or distance (1 … 32768) as deflate writes it.
struct Coded {
    uint16_t symbol = 0;
    uint8_t extra_count = 0;
    uint16_t extra = 0;
};
Coded code_length(int32_t length);
Coded code_distance(int32_t distance);

/// The head of a block with these two codes.
void write_block_head(BitWriter* out, bool last, const PrefixCode& literals,
                      const PrefixCode& distances);

}  // namespace openfab::raster
