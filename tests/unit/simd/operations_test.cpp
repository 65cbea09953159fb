// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Each operation of simd/, for each instruction set that this machine has, against plain C++.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "base/infinity.h"
#include "simd/isa.h"
#include "tests/unit/simd/operations.h"

namespace openfab::testing {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Fails unless both have the same bits, or are both NaN.
void expect_same(float value, float expected, const char* what, int lane) {
    if (std::isnan(value) && std::isnan(expected)) return;
    EXPECT_EQ(std::bit_cast<uint32_t>(value), std::bit_cast<uint32_t>(expected))
        << what << ", lane " << lane << ": " << value << ", expected " << expected;
}

uint32_t bit(int lane, bool value) {
    return static_cast<uint32_t>(value) << lane;
}

void check(const Operands& in, const Results& r) {
    uint32_t less = 0, less_equal = 0, equal = 0;
    const uint32_t all = (1u << r.lanes) - 1, odd = 0xaaaa & all;
    for (int l = 0; l < r.lanes; ++l) {
        const float a = in.a[l], b = in.b[l], c = in.c[l];
        expect_same(r.sum[l], a + b, "a + b", l);
        expect_same(r.difference[l], a - b, "a - b", l);
        expect_same(r.product[l], a * b, "a * b", l);
        expect_same(r.quotient[l], a / b, "a / b", l);
        expect_same(r.least[l], a < b ? a : b, "min", l);
        expect_same(r.most[l], a > b ? a : b, "max", l);
        expect_same(r.root[l], std::sqrt(a), "sqrt", l);
        expect_same(r.magnitude[l], std::fabs(a), "absolute", l);
        expect_same(r.selected[l], a < b ? a : c, "select", l);
        EXPECT_EQ(r.selected_ints[l], a < b ? in.i[l] : 7) << l;
        const float once = std::fma(a, b, c), twice = a * b + c;
        if (!std::isnan(twice)) {
            EXPECT_TRUE(r.about_sum[l] == once || r.about_sum[l] == twice) << l;
        }
        const float once_less = std::fma(a, b, -c), twice_less = a * b - c;
        if (!std::isnan(twice_less)) {
            EXPECT_TRUE(r.about_difference[l] == once_less || r.about_difference[l] == twice_less)
                << l;
        }
        less |= bit(l, a < b);
        less_equal |= bit(l, a <= b);
        equal |= bit(l, a == b);
    }
    EXPECT_EQ(r.less, less);
    EXPECT_EQ(r.less_equal, less_equal);
    EXPECT_EQ(r.equal, equal);
    EXPECT_EQ(r.both, less & odd);
    EXPECT_EQ(r.either, less | odd);
    EXPECT_EQ(r.only_second, odd & ~less);
    EXPECT_EQ(r.from_bits, odd);
    EXPECT_TRUE(r.some);
    EXPECT_FALSE(r.none);
}

void check(const Operands& in, const FixedResults& r) {
    uint32_t greater = 0;
    for (int l = 0; l < 16; ++l) {
        const int32_t s = in.s[l], t = in.t[l];
        EXPECT_EQ(r.sum[l], static_cast<int16_t>(s + t - 1)) << l;
        EXPECT_EQ(r.product[l], static_cast<int16_t>((s * t + 0x4000) >> 15)) << l;
        EXPECT_EQ(r.capped[l], std::clamp(s + t, -32768, 32767)) << l;
        EXPECT_EQ(r.magnitude[l], static_cast<int16_t>(s < 0 ? -s : s)) << l;
        EXPECT_EQ(r.selected[l], s > t ? l : t) << l;
        greater |= bit(l, s > t);
    }
    EXPECT_EQ(r.greater, greater);
}

void check(const Operands& in, const RegisterResults& r) {
    uint32_t greater = 0, equal = 0;
    for (int l = 0; l < r.lanes; ++l) {
        const float a = in.a[l], b = in.b[l];
        const int32_t i = in.i[l], j = in.j[l];
        const auto u = static_cast<uint32_t>(i), v = static_cast<uint32_t>(j);
        expect_same(r.down[l], std::floor(a), "floor", l);
        expect_same(r.up[l], std::ceil(a), "ceil", l);
        expect_same(r.of_ints[l], static_cast<float>(i), "to_floats", l);
        expect_same(r.kept[l], a > b ? a : 0.0f, "masked", l);
        expect_same(r.dropped[l], a >= b ? 0.0f : a, "andnot", l);
        if (std::fabs(a) < 0x1p31f) {
            EXPECT_EQ(r.truncated[l], static_cast<int32_t>(a)) << l;
            EXPECT_EQ(r.rounded[l], static_cast<int32_t>(std::nearbyint(a))) << l;
        }
        EXPECT_EQ(r.sum[l], static_cast<int32_t>(u + v)) << l;
        EXPECT_EQ(r.difference[l], static_cast<int32_t>(u - v)) << l;
        EXPECT_EQ(r.product[l], static_cast<int32_t>(u * v)) << l;
        EXPECT_EQ(r.least[l], std::min(i, j)) << l;
        EXPECT_EQ(r.most[l], std::max(i, j)) << l;
        EXPECT_EQ(r.shifted[l], (i >> 3) & 0xff) << l;
        EXPECT_EQ(r.hash[l], static_cast<int32_t>((u ^ (u >> 16)) * 0x7feb352du)) << l;
        EXPECT_EQ(r.words[l], in.words[l]) << l;
        EXPECT_EQ(r.bytes[l], in.bytes[l]) << l;
        EXPECT_EQ(r.mask[l], i > j ? -1 : 0) << l;
        EXPECT_EQ(r.low_bytes[l], u & 0xff) << l;
        greater |= bit(l, i > j);
        equal |= bit(l, i == j);
    }
    EXPECT_EQ(r.greater, greater);
    EXPECT_EQ(r.equal, equal);
}

template <typename R>
void check_all(const Operands& in) {
    const auto one = [&](simd::Isa isa, void (*compute)(const Operands&, R*), const char* name) {
        if (simd::best_isa(isa) != isa) return;
        SCOPED_TRACE(name);
        R results{};
        compute(in, &results);
        check(in, results);
    };
    one(simd::Isa::kSse41, sse41::compute, "SSE4.1");
    one(simd::Isa::kAvx2, avx2::compute, "AVX2");
    one(simd::Isa::kAvx2Fma, avx2_fma::compute, "AVX2 with FMA");
    one(simd::Isa::kAvx512, avx512::compute, "AVX-512");
}

TEST(SimdOperations, EqualPlainCode) {
    constexpr uint32_t kSeed = 7;
    SCOPED_TRACE(kSeed);
    std::mt19937 random(kSeed);
    const float special[] = {0.0f,     -0.0f,     1.0f,       -1.5f, 2.5f,    0x1p-149f,
                             0x1p100f, kInfinity, -kInfinity, kNaN,  0x1p23f, -0.25f};
    const auto pick = [&]() {
        const uint32_t r = random();
        if (r % 3 != 0) return special[r / 3 % std::size(special)];
        return static_cast<float>(static_cast<int32_t>(r)) * 0x1p-20f;
    };
    for (int round = 0; round < 1000 && !::testing::Test::HasFailure(); ++round) {
        Operands in{};
        for (int l = 0; l < kMaxLanes; ++l) {
            in.a[l] = pick();
            in.b[l] = pick();
            in.c[l] = pick();
            in.i[l] = static_cast<int32_t>(random());
            in.j[l] = random() % 4 == 0 ? in.i[l] : static_cast<int32_t>(random());
            in.s[l] = static_cast<int16_t>(random());
            in.t[l] = random() % 8 == 0 ? int16_t{-32768} : static_cast<int16_t>(random());
        }
        for (int l = 0; l < 8; ++l) {
            in.words[l] = static_cast<uint16_t>(random());
            in.bytes[l] = static_cast<uint8_t>(random());
        }
        check_all<Results>(in);
        check_all<FixedResults>(in);
        check_all<RegisterResults>(in);
    }
}

}  // namespace
}  // namespace openfab::testing
