// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// sin, cos, tan and their inverses. Errors are stated in compiler/functions/README.md and checked
// against MPFR; polynomials as in exponential.h.

#include "compiler/functions/exponential.h"

namespace openfab::functions {

/// An angle as r + quadrant * pi/2, |r| <= pi/4 plus a margin.
template <typename M>
struct Angle {
    typename M::F r;
    typename M::U quadrant;  ///< its low two bits count
};

/// For a >= 0. Up to 2^15 the first parts of pi/2, of 9 bits each, times the quadrant are exact,
/// and so is each difference as far as it cancels; the rounding errors of the third and fourth are
/// added back. Larger angles are first reduced modulo 2^15, which is exact, too, but gives the
/// result of another angle. Infinity and NaN give NaN.
template <typename M>
Angle<M> reduce(typename M::F a) {
    using F = typename M::F;
    const F x = a - M::trunc(a * 0x1p-15f) * 0x1p15f;
    const F sum = x * 0.636619772f + kRounder;
    const F n = sum - kRounder;
    const F second = (x - n * 0x1.92p0f) - n * 0x1.fbp-12f;
    const F part = n * 0x1.51p-22f;
    const F third = second - part;
    const F next_part = n * 0x1.0bp-34f;
    const F fourth = third - next_part;
    const F lost = ((second - third) - part) + ((third - fourth) - next_part);
    return {fourth + (lost - n * 0x1.184698p-44f), M::bits(sum)};
}

template <typename M>
struct SinAndCos {
    typename M::F sin;
    typename M::F cos;
};

template <typename M>
SinAndCos<M> sin_cos_near_zero(typename M::F r) {
    using F = typename M::F;
    const F z = r * r;
    F s = z * -0x1.9955aep-13f + 0x1.11077cp-7f;
    s = s * z - 0x1.555546p-3f;
    F c = z * 0x1.99e0f2p-16f - 0x1.6c0c1ap-10f;
    c = c * z + 0x1.55554ap-5f;
    return {r * z * s + r, (z * z * c - z * 0.5f) + 1.0f};
}

template <typename M>
typename M::F sin(typename M::F x) {
    const Angle<M> angle = reduce<M>(M::abs(x));
    const SinAndCos<M> near = sin_cos_near_zero<M>(angle.r);
    const typename M::F out = M::select((angle.quadrant & 1u) == 1u, near.cos, near.sin);
    const typename M::U sign = ((angle.quadrant & 2u) << 30u) ^ (M::bits(x) & kSignBit);
    return M::from_bits(M::bits(out) ^ sign);
}

template <typename M>
typename M::F cos(typename M::F x) {
    const Angle<M> angle = reduce<M>(M::abs(x));
    const SinAndCos<M> near = sin_cos_near_zero<M>(angle.r);
    const typename M::F out = M::select((angle.quadrant & 1u) == 1u, near.sin, near.cos);
    const typename M::U sign = ((angle.quadrant + 1u) & 2u) << 30u;
    return M::from_bits(M::bits(out) ^ sign);
}

template <typename M>
typename M::F tan(typename M::F x) {
    using F = typename M::F;
    const Angle<M> angle = reduce<M>(M::abs(x));
    const SinAndCos<M> near = sin_cos_near_zero<M>(angle.r);
    const typename M::B odd = (angle.quadrant & 1u) == 1u;
    const F out = M::select(odd, near.cos, near.sin) / M::select(odd, near.sin, near.cos);
    const typename M::U sign = ((angle.quadrant & 1u) << 31u) ^ (M::bits(x) & kSignBit);
    return M::from_bits(M::bits(out) ^ sign);
}

/// asin(t) - t for |t| <= 1/2, z = t^2.
template <typename M>
typename M::F asin_tail(typename M::F t, typename M::F z) {
    typename M::F q = z * 0x1.349988p-5f + 0x1.d5917ep-7f;
    q = q * z + 0x1.04ccd2p-5f;
    q = q * z + 0x1.6ca7dep-5f;
    q = q * z + 0x1.3338aap-4f;
    q = q * z + 0x1.55554cp-3f;
    return t * z * q;
}

inline constexpr float kHalfPiHigh = 0x1.921fb6p0f;
inline constexpr float kHalfPiLow = -0x1.777a5cp-25f;

template <typename M>
typename M::F asin(typename M::F x) {
    using F = typename M::F;
    const F a = M::abs(x);
    const typename M::B far = a > 0.5f;
    const F z = M::select(far, (1.0f - a) * 0.5f, a * a);
    const F t = M::select(far, M::sqrt(z), a);
    const F tail = asin_tail<M>(t, z);
    const F high = kHalfPiHigh - (t + t);
    const F low = ((kHalfPiHigh - high) - (t + t)) + (kHalfPiLow - (tail + tail));
    return with_sign_of<M>(M::select(far, high + low, t + tail), x);
}

template <typename M>
typename M::F acos(typename M::F x) {
    using F = typename M::F;
    const F a = M::abs(x);
    const typename M::B far = a > 0.5f;
    const F z = M::select(far, (1.0f - a) * 0.5f, a * a);
    const F t = M::select(far, M::sqrt(z), a);
    const F tail = asin_tail<M>(t, z);
    // pi/2 - asin(x) in the middle, 2 asin(t) near 1, pi minus that near -1.
    const F middle = kHalfPiHigh - (x - (kHalfPiLow - with_sign_of<M>(tail, x)));
    const F above = (t + t) + (tail + tail);
    const F below = 2.0f * kHalfPiHigh - ((above - 2.0f * kHalfPiLow));
    const F outside = M::select(M::bits(x) > kMagnitudeBits, below, above);
    return M::select(far, outside, middle);
}

/// Angle of the point (b, a) for a, b >= 0, mirrored where `left`.
template <typename M>
typename M::F angle_of(typename M::F a, typename M::F b, typename M::B left) {
    using F = typename M::F;
    using B = typename M::B;
    const B steep = a > b;
    const F larger = M::select(steep, a, b);
    const F less = M::select(steep, b, a);
    const F size = M::select(larger > 0x1p125f, 0.25f, 1.0f);
    const F num = less * size;
    const F den = larger * size;
    // From about pi/8 on, the angle is pi/4 plus a remainder.
    const B middle = num > den * 0.414213562f;
    const F q = M::select(middle, num - den, num) / M::select(middle, num + den, den);
    // 0 / 0 and inf / inf.
    const typename M::U den_bits = M::bits(den);
    const F t = M::select(den_bits == 0u, 0.0f, M::select(M::bits(num) == 0x7f800000u, 0.0f, q));
    const F z = t * t;
    F p = z * -0x1.f2ebe2p-5f + 0x1.b2264ep-4f;
    p = p * z - 0x1.23b9ccp-3f;
    p = p * z + 0x1.9991e4p-3f;
    p = p * z - 0x1.55554ap-2f;
    const F tail = t * z * p;
    // eighths * pi/4 +- atan(t).
    const B both_infinite = M::bits(num) == 0x7f800000u;
    F eighths = M::select(middle | both_infinite, 1.0f, 0.0f);
    eighths = M::select(steep, 2.0f - eighths, eighths);
    eighths = M::select(left, 4.0f - eighths, eighths);
    const typename M::U flip = M::select(steep, kSignBit, 0u) ^ M::select(left, kSignBit, 0u);
    const F turned = M::from_bits(M::bits(t) ^ flip);
    const F turned_tail = M::from_bits(M::bits(tail) ^ flip);
    const F high = eighths * (0.5f * kHalfPiHigh);
    const F sum = high + turned;
    // high is 0 or at least pi/4 > |turned|.
    return sum + (((high - sum) + turned) + (eighths * (0.5f * kHalfPiLow) + turned_tail));
}

template <typename M>
typename M::F atan(typename M::F x) {
    using F = typename M::F;
    const F a = M::abs(x);
    const F angle = angle_of<M>(a, M::constant(x, 1.0f), M::constant(x, false));
    return M::select(M::is_nan(x), kNan, with_sign_of<M>(angle, x));
}

template <typename M>
typename M::F atan2(typename M::F y, typename M::F x) {
    using F = typename M::F;
    const typename M::B left = M::bits(x) > kMagnitudeBits;
    const F out = with_sign_of<M>(angle_of<M>(M::abs(y), M::abs(x), left), y);
    return M::select(M::is_nan(y), kNan, M::select(M::is_nan(x), kNan, out));
}

}  // namespace openfab::functions
