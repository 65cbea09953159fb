// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled for AVX2. Nothing is included here whose inline functions other files could be given.
#include "base/hash_avx2.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace openfab {

uint64_t xxh3_avx2(const uint8_t* bytes, size_t count, uint64_t seed) {
    return XXH3_64bits_withSeed(bytes, count, seed);
}

}  // namespace openfab
