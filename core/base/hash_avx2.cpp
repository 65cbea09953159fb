// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled for AVX2. Includes nothing with inline functions: the linker could take their AVX2
// versions for other files.
#include "base/hash_avx2.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace openfab {

uint64_t xxh3_avx2(const uint8_t* bytes, size_t count, uint64_t seed) {
    return XXH3_64bits_withSeed(bytes, count, seed);
}

}  // namespace openfab
