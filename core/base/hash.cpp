// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/hash_avx2.h"
#include "simd/isa.h"

namespace openfab {

uint64_t xxh3(std::span<const uint8_t> bytes, uint64_t seed) {
    if constexpr (simd::kWiderSets) {
        if (simd::best_isa() >= simd::Isa::kAvx2)
            return xxh3_avx2(bytes.data(), bytes.size(), seed);
    }
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

struct Hasher::State {
    XXH3_state_t xxh3;
};

void Hasher::Delete::operator()(State* state) const {
    delete state;
}

Hasher::Hasher() : state_(new State) {
    XXH3_64bits_reset(&state_->xxh3);
}

void Hasher::add_bytes(const void* data, size_t bytes) {
    XXH3_64bits_update(&state_->xxh3, data, bytes);
}

uint64_t Hasher::value() const {
    return XXH3_64bits_digest(&state_->xxh3);
}

}  // namespace openfab
