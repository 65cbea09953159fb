// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace openfab {

/// XXH3-64 (xxhash.com), the same on every machine, by the widest vectors that this one has.
uint64_t xxh3(std::span<const uint8_t> bytes, uint64_t seed);

}  // namespace openfab
