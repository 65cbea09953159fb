// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// SHA-256 (FIPS 180-4), computed by OpenSSL: digests that other programs compute, too, as `sha256sum` does. A
// library of its own, openfab_digest, since few programs need it.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace openfab {

using Sha256Digest = std::array<uint8_t, 32>;

/// Digests a stream of bytes.
class Sha256 {
  public:
    /// Throws std::runtime_error where the system's OpenSSL has no SHA-256.
    Sha256();
    void add(std::span<const uint8_t> bytes);
    /// Ends the stream.
    Sha256Digest digest();

  private:
    struct Free {
        void operator()(evp_md_ctx_st* state) const;
    };
    std::unique_ptr<evp_md_ctx_st, Free> state_;
};

Sha256Digest sha256(std::span<const uint8_t> bytes);
Sha256Digest sha256(std::string_view text);

/// Formats as 64 lower-case digits.
std::string hex_text(const Sha256Digest& digest);
/// Parses them, in either case; false where the text is anything else.
bool parse_hex(std::string_view text, Sha256Digest* digest);

}  // namespace openfab
