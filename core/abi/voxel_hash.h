// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The hash of a voxel's index, hash(x, y, z, seed) of the dither rule. One template serves the
// generated code (U is a Halide Expr of type uint32) and plain C++ (U is uint32_t), so both give
// the same bits. x, y, z are voxel indices of the grid; the mixer is lowbias32 (C. Wellons,
// "Prospecting for Hash Functions", 2018), whose 32-bit avalanche bias is the lowest known for two
// multiplications.

#include <cstdint>

namespace openfab::abi {

template <typename U>
U mix32(U h) {
    h = h ^ (h >> U(16u));
    h = h * U(0x7feb352du);
    h = h ^ (h >> U(15u));
    h = h * U(0x846ca68bu);
    return h ^ (h >> U(16u));
}

/// Folds the 64-bit seed to the 32 bits that `voxel_hash` takes.
inline uint32_t fold_seed(uint64_t seed) {
    return mix32(mix32(static_cast<uint32_t>(seed)) ^ static_cast<uint32_t>(seed >> 32));
}

/// Returns the part of `voxel_hash` that is the same for a whole column along z.
template <typename U>
U column_hash(U x, U y, U folded_seed) {
    return mix32(mix32(folded_seed + x * U(0x9e3779b1u)) ^ y);
}

/// Returns the hash. z is mixed in last: x and y are the same in all lanes of a vector of slices,
/// so their part stays scalar.
template <typename U>
U voxel_hash(U x, U y, U z, U folded_seed) {
    return mix32(column_hash(x, y, folded_seed) ^ z);
}

/// Maps the hash to [0, 65535), to be compared with sums of 16-bit fractions: the first material
/// whose sum is greater is the one that the inverse cumulative distribution gives.
template <typename U>
U fraction_threshold(U hash) {
    return ((hash >> U(16u)) * U(65535u)) >> U(16u);
}

}  // namespace openfab::abi
