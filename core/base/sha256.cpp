// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/sha256.h"

#include <openssl/evp.h>

#include <stdexcept>

namespace openfab {

namespace {

/// A system may be set up to allow other digests only.
void must(int done) {
    if (done != 1) throw std::runtime_error("OpenSSL does not compute SHA-256 here");
}

}  // namespace

void Sha256::Free::operator()(evp_md_ctx_st* state) const {
    EVP_MD_CTX_free(state);
}

Sha256::Sha256() : state_(EVP_MD_CTX_new()) {
    must(state_ != nullptr ? EVP_DigestInit_ex(state_.get(), EVP_sha256(), nullptr) : 0);
}

void Sha256::add(std::span<const uint8_t> bytes) {
    must(EVP_DigestUpdate(state_.get(), bytes.data(), bytes.size()));
}

Sha256Digest Sha256::digest() {
    Sha256Digest out{};
    must(EVP_DigestFinal_ex(state_.get(), out.data(), nullptr));
    return out;
}

Sha256Digest sha256(std::span<const uint8_t> bytes) {
    Sha256 sum;
    sum.add(bytes);
    return sum.digest();
}

Sha256Digest sha256(std::string_view text) {
    return sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string hex_text(const Sha256Digest& digest) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string text;
    for (const uint8_t byte : digest) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15];
    }
    return text;
}

bool parse_hex(std::string_view text, Sha256Digest* digest) {
    if (text.size() != 2 * digest->size()) return false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const int value = c >= '0' && c <= '9'   ? c - '0'
                          : c >= 'a' && c <= 'f' ? c - 'a' + 10
                          : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                 : -1;
        if (value < 0) return false;
        uint8_t& byte = (*digest)[i / 2];
        byte = static_cast<uint8_t>(i % 2 == 0 ? value << 4 : byte | value);
    }
    return true;
}

}  // namespace openfab
