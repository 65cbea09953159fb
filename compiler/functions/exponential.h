// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// exp, exp2, log, log2, log10, pow, sinh, cosh, tanh and cbrt. Reductions are Cody and Waite's
// ("Software Manual for the Elementary Functions", 1980); polynomials are minimax in relative
// error, made by Remez' algorithm with coefficients rounded to float one after another. Errors are
// stated in compiler/functions/README.md and checked against MPFR.

#include <limits>

#include "base/infinity.h"
#include "compiler/functions/machine.h"

namespace openfab::functions {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// 1.5 * 2^23: adding it to |x| < 2^22 rounds x to an integer, whose two's complement is then in
/// the low bits of the sum.
inline constexpr float kRounder = 12582912.0f;
inline constexpr uint32_t kSignBit = 0x80000000u;
inline constexpr uint32_t kMagnitudeBits = 0x7fffffffu;
inline constexpr uint32_t kTopHalfBits = 0xfffff000u;  ///< a float of 12 bits: its square is exact
inline constexpr uint32_t kOne = 0x3f800000u;
inline constexpr uint32_t kRootHalf = 0x3f3504f3u;
inline constexpr uint32_t kRootThreeQuarters = 0x3f5db3d7u;
inline constexpr uint32_t kMantissaBits = 0x007fffffu;

/// p * 2^n for n in [-250, 250], rounded once.
template <typename M>
typename M::F times_power_of_two(typename M::F p, typename M::U n) {
    const typename M::U half = M::shift_down(n, 1u);
    const typename M::U rest = n - half;
    return p * M::from_bits((half + 127u) << 23u) * M::from_bits((rest + 127u) << 23u);
}

/// e^r for |r| <= ln(2) / 2 plus a margin.
template <typename M>
typename M::F exp_near_zero(typename M::F r) {
    typename M::F q = r * 0x1.6ac4a2p-10f + 0x1.123dc6p-7f;
    q = q * r + 0x1.555858p-5f;
    q = q * r + 0x1.55548cp-3f;
    q = q * r + 0x1.fffffcp-2f;
    return (r * r * q + r) + 1.0f;
}

/// e^x * 2^shift.
template <typename M>
typename M::F exp_scaled(typename M::F given, uint32_t shift) {
    using F = typename M::F;
    // Beyond these the result is 0 or infinite anyway; NaN passes through.
    F x = M::select(given > 92.0f, 92.0f, given);
    x = M::select(x < -106.0f, -106.0f, x);
    const F sum = x * 1.44269504f + kRounder;
    const F n = sum - kRounder;
    const F r = (x - n * 0.693359375f) - n * -2.12194440e-4f;
    return times_power_of_two<M>(exp_near_zero<M>(r), M::bits(sum) - (0x4b400000u - shift));
}

template <typename M>
typename M::F exp(typename M::F x) {
    return exp_scaled<M>(x, 0u);
}

template <typename M>
typename M::F exp2(typename M::F given) {
    using F = typename M::F;
    F x = M::select(given > 130.0f, 130.0f, given);
    x = M::select(x < -152.0f, -152.0f, x);
    const F sum = x + kRounder;
    const F r = (x - (sum - kRounder)) * 0.693147181f;
    return times_power_of_two<M>(exp_near_zero<M>(r), M::bits(sum) - 0x4b400000u);
}

/// x = (1 + f) 2^e with 1 + f in [sqrt(1/2), sqrt(2)), for positive finite x, denormal ones too.
template <typename M>
struct Split {
    typename M::F f;
    typename M::F e;
};

template <typename M>
Split<M> split(typename M::F x) {
    using F = typename M::F;
    using U = typename M::U;
    const typename M::B tiny = M::bits(x) < 0x00800000u;
    const U bits = M::bits(M::select(tiny, x * 0x1p23f, x)) - kRootHalf;
    const F m = M::from_bits((bits & kMantissaBits) + kRootHalf);
    const F e = M::to_float(M::as_int(M::shift_down(bits, 23u)));
    return {m - 1.0f, e - M::select(tiny, 23.0f, 0.0f)};
}

/// log(1 + f) - f + f^2 / 2.
template <typename M>
typename M::F log_tail(typename M::F f) {
    typename M::F q = f * 0x1.1457a0p-4f - 0x1.de3c12p-4f;
    q = q * f + 0x1.e6f06cp-4f;
    q = q * f - 0x1.fc220ap-4f;
    q = q * f + 0x1.233768p-3f;
    q = q * f - 0x1.555c4ep-3f;
    q = q * f + 0x1.99a4b6p-3f;
    q = q * f - 0x1.000006p-2f;
    q = q * f + 0x1.555548p-2f;
    return f * f * f * q;
}

/// Returns `inside` for positive finite x, -inf for 0, inf for inf, and NaN for negative x and NaN.
template <typename M>
typename M::F log_or_special(typename M::F x, typename M::F inside) {
    using F = typename M::F;
    const typename M::U bits = M::bits(x);
    const F top = M::select(bits == 0x7f800000u, kInfinity, kNan);
    const F special = M::select((bits & kMagnitudeBits) == 0u, -kInfinity, top);
    return M::select(bits - 1u < 0x7f7fffffu, inside, special);
}

template <typename M>
typename M::F log(typename M::F x) {
    using F = typename M::F;
    const Split<M> s = split<M>(x);
    F tail = log_tail<M>(s.f) + s.e * -2.12194440e-4f;
    tail = tail - s.f * s.f * 0.5f;
    return log_or_special<M>(x, (s.f + tail) + s.e * 0.693359375f);
}

/// log(1 + f) as a head of 12 bits and a tail.
template <typename M>
struct HeadAndRest {
    typename M::F head;
    typename M::F rest;
};

template <typename M>
HeadAndRest<M> log_in_two(typename M::F f) {
    using F = typename M::F;
    const F half = f * f * 0.5f;
    const F head = M::from_bits(M::bits(f - half) & kTopHalfBits);
    return {head, ((f - head) - half) + log_tail<M>(f)};
}

template <typename M>
typename M::F log2(typename M::F x) {
    using F = typename M::F;
    const Split<M> s = split<M>(x);
    const HeadAndRest<M> l = log_in_two<M>(s.f);
    // 1 / ln(2) in two parts.
    const F low = l.rest * 0x1.714p0f + (l.rest + l.head) * 0x1.47652cp-12f;
    const F high = l.head * 0x1.714p0f;
    const F sum = s.e + high;
    return log_or_special<M>(x, sum + (((s.e - sum) + high) + low));
}

template <typename M>
typename M::F log10(typename M::F x) {
    using F = typename M::F;
    const Split<M> s = split<M>(x);
    const HeadAndRest<M> l = log_in_two<M>(s.f);
    // log10(2) and 1 / ln(10) in two parts.
    const F low =
        (s.e * 0x1.3509f8p-18f + (l.rest + l.head) * 0x1.7b1526p-14f) + l.rest * 0x1.bcap-2f;
    const F high = s.e * 0x1.344p-2f;
    const F part = l.head * 0x1.bcap-2f;
    const F sum = high + part;
    return log_or_special<M>(x, sum + (((high - sum) + part) + low));
}

/// log2 of a positive finite number in two floats, with a relative error below about 2^-32.
template <typename M>
HeadAndRest<M> log2_in_two(typename M::F x) {
    using F = typename M::F;
    using U = typename M::U;
    const typename M::B tiny = M::bits(x) < 0x00800000u;
    const U bits = M::bits(M::select(tiny, x * 0x1p23f, x)) - kRootThreeQuarters;
    const F m = M::from_bits((bits & kMantissaBits) + kRootThreeQuarters);
    const F e = M::to_float(M::as_int(M::shift_down(bits, 23u))) - M::select(tiny, 23.0f, 0.0f);
    // m is near 1 or near 3/2: log(m / c) = 2 atanh(s), s = (m - c) / (m + c) in two parts.
    const typename M::B upper = m > 1.22474487f;
    const F c = M::select(upper, 1.5f, 1.0f);
    const F f = m - c;
    const F t = m + c;
    const F inverse = 1.0f / t;
    const F s = f * inverse;
    const F s_head = M::from_bits(M::bits(s) & kTopHalfBits);
    const F t_head = M::from_bits(M::bits(t) & kTopHalfBits);
    const F t_rest = m - (t_head - c);
    const F s_rest = ((f - s_head * t_head) - s_head * t_rest) * inverse;
    const F z = s * s;
    F q = z * 0x1.28a1b8p-3f + 0x1.999484p-3f;
    q = q * z + 0x1.555556p-2f;
    const F rest = s * z * q + s_rest;
    // 2 / ln(2) and log2(3/2) in two parts; the products and the sum of the heads are exact.
    const F high = s_head * 0x1.714p1f;
    const F low =
        (s_head * 0x1.47652cp-11f + M::select(upper, 0x1.a39fbep-20f, 0.0f)) + rest * 2.88539008f;
    const F whole = e + M::select(upper, 0x1.2b8p-1f, 0.0f);
    const F sum = whole + high;
    const F correction = ((whole - sum) + high) + low;
    const F head = sum + correction;
    return {head, (sum - head) + correction};
}

/// Follows IEEE 754 pow: pow(x, 0) = pow(1, y) = 1, a negative x needs an integer y.
template <typename M>
typename M::F pow(typename M::F x, typename M::F y) {
    using F = typename M::F;
    using U = typename M::U;
    using B = typename M::B;
    const U x_bits = M::bits(x);
    const U a_bits = x_bits & kMagnitudeBits;
    const U y_bits = M::bits(y) & kMagnitudeBits;
    const HeadAndRest<M> l = log2_in_two<M>(M::from_bits(a_bits));
    // No log2 but 0 is below 2^-24 in magnitude: with |y| >= 2^40 the result is 0, 1 or infinite.
    F exponent = M::select(y > 0x1p40f, 0x1p40f, y);
    exponent = M::select(exponent < -0x1p40f, -0x1p40f, exponent);
    const F y_head = M::from_bits(M::bits(exponent) & kTopHalfBits);
    const F l_head = M::from_bits(M::bits(l.head) & kTopHalfBits);
    const F l_rest = (l.head - l_head) + l.rest;
    const F high = y_head * l_head;
    const F low = y_head * l_rest + (exponent - y_head) * (l_head + l_rest);
    const B inside = M::abs(high) < 160.0f;
    const F bounded = M::select(inside, high, M::select(high > 1.0f, 160.0f, -160.0f));
    const F sum = bounded + kRounder;
    const F r = (bounded - (sum - kRounder)) + M::select(inside, low, 0.0f);
    F out = times_power_of_two<M>(exp_near_zero<M>(r * 0.693147181f), M::bits(sum) - 0x4b400000u);
    // 0 and infinity.
    const B grows = (M::bits(y) < kSignBit) == (a_bits > kOne);
    const B extreme = (a_bits == 0u) | (a_bits == 0x7f800000u);
    out = M::select(extreme, M::select(grows, kInfinity, 0.0f), out);
    const B negative = x_bits > 0x7fffffffu;
    const B whole = M::floor(y) == y;
    const F half = y * 0.5f;
    const B odd = whole & !(M::floor(half) == half);
    out = M::from_bits(M::bits(out) ^ M::select(negative & odd, kSignBit, 0u));
    out = M::select((negative & !whole) & !extreme, kNan, out);
    const B nan = (a_bits > 0x7f800000u) | (y_bits > 0x7f800000u);
    out = M::select(nan, kNan, out);
    return M::select((y_bits == 0u) | (x_bits == kOne), 1.0f, out);
}

template <typename M>
typename M::F with_sign_of(typename M::F magnitude, typename M::F x) {
    return M::from_bits(M::bits(magnitude) ^ (M::bits(x) & kSignBit));
}

template <typename M>
typename M::F sinh(typename M::F x) {
    using F = typename M::F;
    const F a = M::abs(x);
    const F half_exp = exp_scaled<M>(a, ~0u);
    const F z = a * a;
    F q = z * 0x1.75a6fap-19f + 0x1.a02156p-13f;
    q = q * z + 0x1.1110e2p-7f;
    q = q * z + 0x1.555556p-3f;
    const F near = a + a * z * q;
    return with_sign_of<M>(M::select(a < 1.0f, near, half_exp - 0.25f / half_exp), x);
}

template <typename M>
typename M::F cosh(typename M::F x) {
    const typename M::F half_exp = exp_scaled<M>(M::abs(x), ~0u);
    return half_exp + 0.25f / half_exp;
}

template <typename M>
typename M::F tanh(typename M::F x) {
    using F = typename M::F;
    const F a = M::abs(x);
    const F z = a * a;
    F q = z * -0x1.750cdep-8f + 0x1.51f8cep-6f;
    q = q * z - 0x1.b835a4p-5f;
    q = q * z + 0x1.1106f6p-3f;
    q = q * z - 0x1.555532p-2f;
    const F near = a + a * z * q;
    const F far = 1.0f - 2.0f / (exp<M>(a + a) + 1.0f);
    return with_sign_of<M>(M::select(a < 0.625f, near, far), x);
}

/// A Halley step from an estimate within 4 % by the exponent, then a Newton step.
template <typename M>
typename M::F cbrt(typename M::F x) {
    using F = typename M::F;
    const F given = M::abs(x);
    const typename M::B tiny = given < 0x1p-100f;
    const F a = M::select(tiny, given * 0x1p48f, given);
    const F guess = M::from_bits((M::bits(a) >> 16u) * 21845u + 0x2a51acc0u);
    const F cube = guess * guess * (guess * 0.25f);
    const F quarter = a * 0.25f;
    const F near = guess * ((cube + (quarter + quarter)) / ((cube + cube) + quarter));
    const F root = near + (a / (near * near) - near) * 0.333333333f;
    const F sized = M::select(tiny, root * 0x1p-16f, root);
    const typename M::U bits = M::bits(given);
    const typename M::B plain = bits - 1u < 0x7f7fffffu;
    return with_sign_of<M>(M::select(plain, sized, given), x);
}

}  // namespace openfab::functions
