// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slices as lanes: vectors of the compiler, the same operations in the same order for every
// instruction set. A group's 8 slices are one vector of 8 lanes or two of 4, whichever the machine
// has: compilers take wider vectors apart lane by lane. Everything is inlined into functions that
// name their instruction set.

#include <cstdint>
#include <cstring>

#define OPENFAB_INLINE inline __attribute__((always_inline))

namespace openfab::slab {

/// Slices of a group; values in memory stand [material][slice].
constexpr int32_t kSlices = 8;

/// Written out: GCC 12 converts no vectors whose length is a template's parameter. Ints are also
/// masks, 0 or -1.
template <int N>
struct LaneTypes;
template <>
struct LaneTypes<4> {
    using Floats = float __attribute__((vector_size(16)));
    using Ints = int32_t __attribute__((vector_size(16)));
    using Unsigned = uint32_t __attribute__((vector_size(16)));
    using Shorts = uint16_t __attribute__((vector_size(8)));
    using Bytes = uint8_t __attribute__((vector_size(4)));
    OPENFAB_INLINE static Ints widen(const Shorts& v) { return __builtin_convertvector(v, Ints); }
    OPENFAB_INLINE static Ints widen(const Bytes& v) { return __builtin_convertvector(v, Ints); }
    OPENFAB_INLINE static Bytes narrow(const Ints& v) { return __builtin_convertvector(v, Bytes); }
    OPENFAB_INLINE static Floats to_floats(const Ints& v) {
        return __builtin_convertvector(v, Floats);
    }
};
template <>
struct LaneTypes<8> {
    using Floats = float __attribute__((vector_size(32)));
    using Ints = int32_t __attribute__((vector_size(32)));
    using Unsigned = uint32_t __attribute__((vector_size(32)));
    using Shorts = uint16_t __attribute__((vector_size(16)));
    using Bytes = uint8_t __attribute__((vector_size(8)));
    OPENFAB_INLINE static Ints widen(const Shorts& v) { return __builtin_convertvector(v, Ints); }
    OPENFAB_INLINE static Ints widen(const Bytes& v) { return __builtin_convertvector(v, Ints); }
    OPENFAB_INLINE static Bytes narrow(const Ints& v) { return __builtin_convertvector(v, Bytes); }
    OPENFAB_INLINE static Floats to_floats(const Ints& v) {
        return __builtin_convertvector(v, Floats);
    }
};

template <int N>
struct Lanes {
    static constexpr int32_t kCount = N;
    using Types = LaneTypes<N>;
    using Floats = typename Types::Floats;
    using Ints = typename Types::Ints;
    using Unsigned = typename Types::Unsigned;

    /// With the operators that abi/voxel_hash.h takes.
    struct Hashes {
        Unsigned v;

        OPENFAB_INLINE explicit Hashes(uint32_t all) : v(Unsigned{} + all) {}
        OPENFAB_INLINE explicit Hashes(const Unsigned& lanes) : v(lanes) {}
        OPENFAB_INLINE Hashes operator*(const Hashes& o) const { return Hashes(v * o.v); }
        OPENFAB_INLINE Hashes operator^(const Hashes& o) const { return Hashes(v ^ o.v); }
        OPENFAB_INLINE Hashes operator>>(const Hashes& o) const { return Hashes(v >> o.v); }
        OPENFAB_INLINE Ints ints() const { return Ints(v); }
    };

    OPENFAB_INLINE static Floats all(float value) { return Floats{} + value; }
    OPENFAB_INLINE static Ints all(int32_t value) { return Ints{} + value; }

    /// Memory need not be aligned.
    OPENFAB_INLINE static Floats load(const float* p) {
        Floats v;
        std::memcpy(&v, p, sizeof v);
        return v;
    }
    OPENFAB_INLINE static Ints load(const uint16_t* p) {
        typename Types::Shorts v;
        std::memcpy(&v, p, sizeof v);
        return Types::widen(v);
    }
    OPENFAB_INLINE static Ints load(const uint8_t* p) {
        typename Types::Bytes v;
        std::memcpy(&v, p, sizeof v);
        return Types::widen(v);
    }
    OPENFAB_INLINE static void store(float* p, const Floats& v) { std::memcpy(p, &v, sizeof v); }
    OPENFAB_INLINE static void store(uint8_t* p, const Ints& v) {
        const typename Types::Bytes bytes = Types::narrow(v);
        std::memcpy(p, &bytes, sizeof bytes);
    }
    OPENFAB_INLINE static Floats to_floats(const Ints& v) { return Types::to_floats(v); }

    /// 0, 1, 2, …
    OPENFAB_INLINE static Ints count() {
        Ints v{};
        for (int32_t l = 0; l < N; ++l)
            v[l] = l;
        return v;
    }
    /// A mask from the bits of the lanes from `first` on.
    OPENFAB_INLINE static Ints from_bits(int32_t bits, int32_t first) {
        Ints bit{};
        for (int32_t l = 0; l < N; ++l)
            bit[l] = 1 << l;
        return (all(bits >> first) & bit) != 0;
    }
    /// `value` in the lanes of the mask, 0 elsewhere.
    OPENFAB_INLINE static Floats masked(const Ints& mask, float value) {
        return mask ? all(value) : Floats{};
    }
};

}  // namespace openfab::slab
