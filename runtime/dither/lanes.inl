// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Slices as lanes: vectors of the compiler, the same operations in the same order for every
// instruction set. A slab's 8 slices are one vector of 8 lanes or two of 4, whichever the machine
// has: compilers take wider vectors apart lane by lane. Between integers of different widths they
// go lane by lane, too; those are intrinsics. Everything is inlined.
//
// Included once for each instruction set, with
//   OPENFAB_LANES_ISA     namespace
//   OPENFAB_LANES_TARGET  what target attributes call it
//   OPENFAB_LANES_AVX2    1 or 0

#define OPENFAB_INLINE_ANYWHERE inline __attribute__((always_inline))
#define OPENFAB_INLINE inline __attribute__((always_inline, target(OPENFAB_LANES_TARGET)))
/// Attribute of lambdas, between their parameters and their bodies.
#define OPENFAB_INLINE_LAMBDA __attribute__((always_inline, target(OPENFAB_LANES_TARGET)))

namespace openfab::dither::OPENFAB_LANES_ISA {
namespace {

struct Lanes {
#if OPENFAB_LANES_AVX2
    static constexpr int32_t kCount = 8;
#else
    static constexpr int32_t kCount = 4;
#endif
    /// Ints are also masks, 0 or -1.
    using Floats = float __attribute__((vector_size(4 * kCount)));
    using Ints = int32_t __attribute__((vector_size(4 * kCount)));
    using Unsigned = uint32_t __attribute__((vector_size(4 * kCount)));

    /// With the operators that abi/voxel_hash.h takes, whose functions are of no instruction set.
    struct Hashes {
        Unsigned v;

        OPENFAB_INLINE_ANYWHERE explicit Hashes(uint32_t all) : v(Unsigned{} + all) {}
        OPENFAB_INLINE_ANYWHERE explicit Hashes(const Unsigned& lanes) : v(lanes) {}
        OPENFAB_INLINE_ANYWHERE Hashes operator*(const Hashes& o) const { return Hashes(v * o.v); }
        OPENFAB_INLINE_ANYWHERE Hashes operator^(const Hashes& o) const { return Hashes(v ^ o.v); }
        OPENFAB_INLINE_ANYWHERE Hashes operator>>(const Hashes& o) const {
            return Hashes(v >> o.v);
        }
        OPENFAB_INLINE Ints ints() const { return Ints(v); }
    };

    OPENFAB_INLINE static Floats all(float value) {
        return Floats{} + value;
    }

    /// Memory need not be aligned.
    OPENFAB_INLINE static Floats load(const float* p) {
        Floats v;
        std::memcpy(&v, p, sizeof v);
        return v;
    }
    OPENFAB_INLINE static void store(float* p, const Floats& v) {
        std::memcpy(p, &v, sizeof v);
    }
    OPENFAB_INLINE static Floats to_floats(const Ints& v) {
        return __builtin_convertvector(v, Floats);
    }

#if OPENFAB_LANES_AVX2
    OPENFAB_INLINE static Ints all(int32_t value) {
        return Ints(_mm256_set1_epi32(value));
    }
    OPENFAB_INLINE static Ints load(const uint16_t* p) {
        return Ints(_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
    }
    OPENFAB_INLINE static Ints load(const uint8_t* p) {
        return Ints(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
    }
    /// The low byte of each lane.
    OPENFAB_INLINE static void store(uint8_t* p, const Ints& v) {
        const __m256i low = _mm256_set1_epi32(0x0c080400);
        const __m256i packed = _mm256_shuffle_epi8(__m256i(v), low);
        const __m128i bytes =
            _mm_unpacklo_epi32(_mm256_castsi256_si128(packed), _mm256_extracti128_si256(packed, 1));
        _mm_storel_epi64(reinterpret_cast<__m128i*>(p), bytes);
    }
    /// 0, 1, 2, …
    OPENFAB_INLINE static Ints count() {
        return Ints{0, 1, 2, 3, 4, 5, 6, 7};
    }
    /// A mask from the bits of the lanes from `first` on.
    OPENFAB_INLINE static Ints from_bits(int32_t bits, int32_t first) {
        return (all(bits >> first) & Ints{1, 2, 4, 8, 16, 32, 64, 128}) != 0;
    }
#else
    OPENFAB_INLINE static Ints all(int32_t value) {
        return Ints(_mm_set1_epi32(value));
    }
    OPENFAB_INLINE static Ints load(const uint16_t* p) {
        return Ints(_mm_cvtepu16_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
    }
    OPENFAB_INLINE static Ints load(const uint8_t* p) {
        int32_t bytes;
        std::memcpy(&bytes, p, sizeof bytes);
        return Ints(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes)));
    }
    OPENFAB_INLINE static void store(uint8_t* p, const Ints& v) {
        const __m128i low = _mm_set1_epi32(0x0c080400);
        const int32_t bytes = _mm_cvtsi128_si32(_mm_shuffle_epi8(__m128i(v), low));
        std::memcpy(p, &bytes, sizeof bytes);
    }
    OPENFAB_INLINE static Ints count() {
        return Ints{0, 1, 2, 3};
    }
    OPENFAB_INLINE static Ints from_bits(int32_t bits, int32_t first) {
        return (all(bits >> first) & Ints{1, 2, 4, 8}) != 0;
    }
#endif

    /// `value` in the lanes of the mask, 0 elsewhere.
    OPENFAB_INLINE static Floats masked(const Ints& mask, float value) {
        return mask ? all(value) : Floats{};
    }
};

}  // namespace
}  // namespace openfab::dither::OPENFAB_LANES_ISA
