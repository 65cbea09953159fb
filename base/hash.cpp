// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/hash_avx2.h"

namespace openfab {

uint64_t xxh3(std::span<const uint8_t> bytes, uint64_t seed) {
    static const bool wide = __builtin_cpu_supports("avx2") != 0;
    return wide ? xxh3_avx2(bytes.data(), bytes.size(), seed)
                : XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace openfab
