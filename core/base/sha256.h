// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// SHA-256 (FIPS 180-4): digests that other programs compute, too, as `sha256sum` does.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace openfab {

using Sha256Digest = std::array<uint8_t, 32>;

/// Digests a stream of bytes.
class Sha256 {
  public:
    void add(std::span<const uint8_t> bytes);
    /// Ends the stream.
    Sha256Digest digest();

  private:
    std::array<uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                   0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::array<uint8_t, 64> block_{};
    uint64_t bytes_ = 0;
};

Sha256Digest sha256(std::span<const uint8_t> bytes);
Sha256Digest sha256(std::string_view text);

/// Formats as 64 lower-case digits.
std::string hex_text(const Sha256Digest& digest);
/// Parses them, in either case; false where the text is anything else.
bool parse_hex(std::string_view text, Sha256Digest* digest);

/// What the processor's own instructions compute must equal what plain code does: for tests.
namespace sha256_detail {
void add_blocks_plain(uint32_t* state, const uint8_t* blocks, size_t count);
/// Returns false where the processor has no such instructions.
bool add_blocks_fast(uint32_t* state, const uint8_t* blocks, size_t count);
}  // namespace sha256_detail

}  // namespace openfab
