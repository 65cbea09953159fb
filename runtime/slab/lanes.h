// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// 8 slices as 8 lanes: vectors of the compiler, the same operations in the same order for every
// instruction set. Everything is inlined into functions that name their instruction set.

#include <cstdint>
#include <cstring>

#define OPENFAB_INLINE inline __attribute__((always_inline))

namespace openfab::slab {

constexpr int32_t kLanes = 8;

using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));  ///< also masks, 0 or -1
using Shorts = uint16_t __attribute__((vector_size(16)));
using Bytes = uint8_t __attribute__((vector_size(8)));

/// Unsigned lanes with the operators that abi/voxel_hash.h takes.
struct Hashes {
    using Vector = uint32_t __attribute__((vector_size(32)));
    Vector v;

    OPENFAB_INLINE explicit Hashes(uint32_t all) : v(Vector{} + all) {}
    OPENFAB_INLINE explicit Hashes(const Vector& lanes) : v(lanes) {}
    OPENFAB_INLINE Hashes operator*(const Hashes& o) const { return Hashes(v * o.v); }
    OPENFAB_INLINE Hashes operator^(const Hashes& o) const { return Hashes(v ^ o.v); }
    OPENFAB_INLINE Hashes operator>>(const Hashes& o) const { return Hashes(v >> o.v); }
    OPENFAB_INLINE Ints ints() const { return Ints(v); }
};

/// Memory need not be aligned.
OPENFAB_INLINE Floats load(const float* p) {
    Floats v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
OPENFAB_INLINE void store(float* p, const Floats& v) {
    std::memcpy(p, &v, sizeof v);
}
OPENFAB_INLINE Ints load(const uint16_t* p) {
    Shorts v;
    std::memcpy(&v, p, sizeof v);
    return __builtin_convertvector(v, Ints);
}
OPENFAB_INLINE Floats to_floats(const Ints& v) {
    return __builtin_convertvector(v, Floats);
}
/// A mask from a bit for each lane.
OPENFAB_INLINE Ints lanes_of(uint8_t bits) {
    constexpr Ints kBit{1, 2, 4, 8, 16, 32, 64, 128};
    return ((Ints{} + bits) & kBit) != 0;
}
/// `value` in the lanes of the mask, 0 elsewhere.
OPENFAB_INLINE Floats masked(const Ints& mask, float value) {
    return mask ? Floats{} + value : Floats{};
}

}  // namespace openfab::slab
