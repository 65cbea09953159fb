// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The hash of a print: the sum, modulo 2^64, of a hash of each slice's packed rows that is salted
// with the slice's z. So it does not depend on the output format, and the hashes of disjoint ranges
// of slices add up to that of the whole.

#include <cstddef>
#include <cstdint>

#include "base/hash.h"

namespace openfab::pipeline {

/// Hashes one slice. `data`: `height` packed rows of `row_bytes`, without gaps, lowest y first, as
/// in SliceView.
inline uint64_t slice_hash(int32_t z, const uint8_t* data, size_t row_bytes, int32_t height) {
    return xxh3({data, row_bytes * static_cast<size_t>(height)}, static_cast<uint64_t>(z));
}

}  // namespace openfab::pipeline
