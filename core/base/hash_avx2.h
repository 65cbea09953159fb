// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace openfab {

/// Same as xxh3; requires AVX2.
uint64_t xxh3_avx2(const uint8_t* bytes, size_t count, uint64_t seed);

}  // namespace openfab
