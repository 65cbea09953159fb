// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defines one filtered texture lookup. Generated code must give the same bits, so the order of
// every float operation is part of the definition: binary operations round to float one by one,
// left to right as bracketed below, none is fused, and only + - * / sqrt floor ceil and comparisons
// occur. Layout of the arrays: texture/pyramid.h.
//
// Throughout, bound(x, lo, hi) = x > lo ? (x < hi ? x : hi) : lo, so that a NaN becomes lo, and w0,
// h0 are the float sides of level 0.
//
// 1. Channel. Where info[6] is 1, the last channel is alpha and is no colour; colours are channels
//    before it, as they look on white, else all are. c below the number of colours reads channel c.
//    Else, if there is one colour and c < 3, it is channel 0. Else c == 3 is alpha, or the constant 1
//    for a texture without one; other c are 0. A texture without alpha, of up to 3 channels, that is
//    black outside along u or v has coverage for alpha: a channel behind its last, 1 at each texel.
//      c = ir::kOwnColor + k, k < 3, is k's colour itself, with alpha a looked up like it:
//      as on white    a > 0 ? (value - (1 - a)) / a : +0
//      coverage       a > 0 ? value / a : +0
//      no alpha       value
//
// 2. Footprint, in texels of level 0 (rule 19; du, dv are the changes of u, v per step along
//    up to three axes):
//      sx[k] = du[k] * w0                      sy[k] = dv[k] * h0
//      a = (sx[0]*sx[0] + sx[1]*sx[1]) + sx[2]*sx[2]
//      b = (sx[0]*sy[0] + sx[1]*sy[1]) + sx[2]*sy[2]
//      c = (sy[0]*sy[0] + sy[1]*sy[1]) + sy[2]*sy[2]
//      m = (a + c) * 0.5      d = (a - c) * 0.5      r = sqrt(d*d + b*b)
//      major = bound(sqrt(m + r) * width, 0, 2^30)
//      minor = bound(sqrt(bound(m - r, 0, 2^60)) * width, 0, 2^30)
//    Direction of the major axis (the better conditioned of two forms; d >= 0 is false for NaN):
//      ex = d >= 0 ? d + r : b                 ey = d >= 0 ? b : r - d
//      e = sqrt(ex*ex + ey*ey)
//      (ax, ay) = e > 0 and e < 2^60 ? (ex / e, ey / e) : (1, 0)
//
// 3. Level and taps, by filter (info[3]):
//      nearest      one point sample of level 0: step 6
//      trilinear    wide = major, n = 1
//      anisotropic  low = major * 0.125, wide = minor > low ? minor : low,
//                   n = bound(ceil(major / (wide > 1 ? wide : 1)), 1, 8)
//      level = bound(log2(wide), 0, float(levels - 1))          log2: see log2_of
//    A width of 0 thus is a bilinear lookup in level 0.
//
// 4. Taps i = 0 … n-1 along the major axis, added in this order to a sum that starts at +0, which
//    is then divided:
//      t = ((float(i) + 0.5) / n - 0.5) * major
//      u_i = u + (t * ax) / w0                 v_i = v + (t * ay) / h0
//      result = sum / n
//    Adding `i < n ? tap : +0` for i = 0 … 7 gives the same bits.
//
// 5. A tap is, with l = floor(level) and f = level - l,
//      lo = bilinear(l),  hi = bilinear(min(l + 1, levels - 1)),  tap = lo + (hi - lo) * f
//    bilinear(l, u, v) with w, h the sides of level l, for each axis (u and w shown):
//      x = wrap(u) * float(w) - 0.5,  x0 = floor(x) as int,  fx = x - floor(x),  x1 = x0 + 1
//      t0 = T(x0,y0) + (T(x1,y0) - T(x0,y0)) * fx
//      t1 = T(x0,y1) + (T(x1,y1) - T(x0,y1)) * fx
//      t0 + (t1 - t0) * fy
//    wrap(u), by wrap mode (info[2], for v info[5]):
//      clamp, black   p = u
//      repeat         p = u - floor(u)
//      mirror         h = u * 0.5, p = (h - floor(h)) * 2
//      all            bound(p, -2, 3): NaN and infinities become a fixed coordinate
//    T(x, y) of a texel index, each axis: repeat moves x < 0 by +w, x >= w by -w; mirror maps x < 0
//    to -1 - x, x >= w to 2w - 1 - x; then x is clamped to [0, w-1] in every mode, so no index
//    leaves the level. Where x or y is black and was outside before the clamp, T is 0, and 1 for a
//    colour as on white.
//
// 6. nearest: T(int(floor(wrap(u) * w0)), int(floor(wrap(v) * h0))) of level 0.

#include <array>
#include <cstdint>
#include <span>

namespace openfab::interp {

/// A pyramid's arrays; both may be empty, then every lookup gives 0.
struct TextureView {
    std::span<const float> texels;
    std::span<const int32_t> info;
};

struct SampleArgs {
    float u = 0;
    float v = 0;
    float width = 1;            ///< scales the footprint
    std::array<float, 3> du{};  ///< change of u per step along each axis
    std::array<float, 3> dv{};
};

/// Returns log2 of x for 1 <= x < inf, 0 below 1 and for NaN. For x = 2^e (1 + f) it is
///   e + (f + (f * (1 - f)) * q), with
///   q = ((q3 * f + q2) * f + q1) * f + q0.
/// q interpolates (log2(1 + f) - f) / (f (1 - f)) at the Chebyshev nodes of [0, 1]; the error is
/// below 6e-5 of a level, and powers of two are exact.
float log2_of(float x);
constexpr float kLog2Q0 = 0.442418579f;
constexpr float kLog2Q1 = -0.269578015f;
constexpr float kLog2Q2 = 0.150533197f;
constexpr float kLog2Q3 = -0.0448739553f;

/// Samples one channel; `channel` >= 0 as written in the fablet.
float sample(const TextureView& texture, int32_t channel, const SampleArgs& args);

}  // namespace openfab::interp
