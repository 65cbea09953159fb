// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One filtered lookup in a volume (ImageTexture3D), defined as compiler/interp/sample.h defines
// one in a picture: generated code gives the same bits, the order of every float operation counts.
// Layout of the arrays: texture/pyramid.h. bound, wrap, T's wrapping of each axis, log2_of
// and the channel that is read are those of sample.h; w0, h0, d0 are the float sides of level 0,
// o[k] and s[k] the volume's origin and extent along axis k.
//
// 1. Coordinates: c[k] = (p[k] - o[k]) / s[k], 0 to 1 across the volume.
//
// 2. Width, in texels of level 0; dp[k][j] is the change of p[k] per step along axis j:
//      t[k][j] = (dp[k][j] / s[k]) * n0[k]                 n0 = (w0, h0, d0)
//      q[j] = (t[0][j]*t[0][j] + t[1][j]*t[1][j]) + t[2][j]*t[2][j]
//      q = greater(greater(q[0], q[1]), q[2])              greater(a, b) = a > b ? a : b
//      wide = bound(sqrt(q) * width, 0, 2^30)
//    The longest side of the footprint: it prevents aliasing, and does not blur a cube however it
//    is rotated.
//
// 3. Filter: nearest reads T(int(floor(wrap(c[k]) * n0[k]))) of level 0. Others:
//      level = bound(log2_of(wide), 0, float(levels - 1)), 0 under kFilterFinest
//      f = level - floor(level), l = int(floor(level))
//      lo = linear(l), hi = linear(min(l + 1, levels - 1)), result = lo + (hi - lo) * f
//    linear(l): for each axis, n the side of level l, as in sample.h
//      x = wrap(c) * float(n) - 0.5, x0 = int(floor(x)), x1 = x0 + 1, fx = x - floor(x)
//    and then along x, y, z:
//      a(y, z) = T(x0, y, z) + (T(x1, y, z) - T(x0, y, z)) * fx
//      b(z) = a(y0, z) + (a(y1, z) - a(y0, z)) * fy
//      b(z0) + (b(z1) - b(z0)) * fz

#include <array>
#include <cstdint>

#include "compiler/interp/sample.h"

namespace openfab::interp {

struct VolumeSampleArgs {
    std::array<float, 3> p{};
    float width = 1;                           ///< scales the footprint
    std::array<std::array<float, 3>, 3> dp{};  ///< [k][j]: change of p[k] per step along axis j
};

/// Samples one channel; `channel` >= 0 as written in the fablet. Returns 0 if the texture is not a
/// volume.
float sample_volume(const TextureView& texture, int32_t channel, const VolumeSampleArgs& args);

}  // namespace openfab::interp
