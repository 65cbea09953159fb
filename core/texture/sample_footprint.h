// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The footprints of requests for samples: how many taps, along which line of the picture, between which
// two levels. Part of sample_kernel.h.

#include <array>
#include <cstdint>

#include "simd/vectors.h"
#include "texture/pyramid.h"
#include "texture/sample.h"

namespace openfab::texture::OPENFAB_SIMD_ISA {
namespace {

using simd::Floats;
using simd::Ints;
using simd::kLanes;
using simd::Mask;

constexpr int32_t kMaxTaps = 8;
constexpr int32_t kMaxChannels = 4;

/// Clamps: x > lo ? (x < hi ? x : hi) : lo, for lo <= hi.
OPENFAB_INLINE Floats bound(Floats x, float lo, float hi) {
    return min(max(x, lo), hi);
}

/// Texels along one axis of level 0.
struct Side {
    float n, inverse;
    bool exact;  ///< a power of two: products with the inverse have the bits of quotients
};

Side make_side(int32_t n) {
    const auto real = static_cast<float>(n);
    return {real, 1.0f / real, (n & (n - 1)) == 0};
}

OPENFAB_INLINE Floats over(Floats x, const Side& side) {
    return side.exact ? x * side.inverse : x / side.n;
}

struct Picture {
    const float* texels;
    const int32_t* levels;  ///< kInfoPerLevel values each
    int32_t channels, last_level, filter;
    WrapModes wrap{0};
    bool alpha;
    Side width, height;
};

struct SampleRequest {
    Mask active;
    Floats u, v, width;
    Floats du[3], dv[3];
};

struct Level {
    Ints offset, width, height;
};

/// The footprints of a vector of requests. Inactive lanes have no taps.
struct Footprint {
    Floats u, v;
    Floats taps, major, ax, ay, fraction;
    std::array<Level, 2> levels;
    Mask active;
    bool inside;  ///< no tap reads a texel that has to be wrapped; inactive lanes are at 0.5
};

OPENFAB_INLINE Floats log2_of(Floats x) {
    const Ints pattern = as_ints(x);
    const Floats e = to_floats((pattern >> 23) - 127);
    const Floats f = as_floats((pattern & 0x7fffff) | 0x3f800000) - 1.0f;
    const Floats q = ((-0.0448739553f * f + 0.150533197f) * f + -0.269578015f) * f + 0.442418579f;
    return masked(x >= 1.0f, e + (f + (f * (1.0f - f)) * q));
}

/// Returns the level of each lane, mostly uniform. An inactive lane gets the level of an active
/// one: its own might not have two texels in a row.
OPENFAB_INLINE Level level_of(const Picture& picture, Ints level, Mask active) {
    const int32_t one = level.lane(__builtin_ctz(bits(active)));
    if (!any(andnot(level == one, active))) {
        const int32_t* const row = picture.levels + one * kInfoPerLevel;
        return {row[0], row[1], row[2]};
    }
    level = select(active, level, one);
    alignas(sizeof(Ints)) int32_t fields[3][kLanes];
    for (int32_t i = 0; i < kLanes; ++i) {
        const int32_t* const row = picture.levels + level.lane(i) * kInfoPerLevel;
        for (int32_t k = 0; k < 3; ++k)
            fields[k][i] = row[k];
    }
    return {Ints::load(fields[0]), Ints::load(fields[1]), Ints::load(fields[2])};
}

/// Moves a coordinate into the range that its wrap mode reads.
OPENFAB_INLINE Floats wrap_coordinate(int32_t wrap, Floats u) {
    if (wrap == kWrapRepeat) {
        u -= floor(u);
    } else if (wrap == kWrapMirror) {
        const Floats half = u * 0.5f;
        u = (half - floor(half)) * 2.0f;
    }
    return bound(u, -2.0f, 3.0f);
}

/// Same for coordinates between 0 and 1, or moved there by `repeat`.
OPENFAB_INLINE Floats wrap_inside(int32_t wrap, Floats u) {
    return wrap == kWrapRepeat ? u - floor(u) : u;
}

/// Returns whether all taps along one axis read texels x0 and x0 + 1 of both levels with 0 <= x0
/// and x0 + 1 < n: a margin of a texel of the coarser level, and a quarter for rounding.
OPENFAB_INLINE Mask stays_inside(int32_t wrap, Floats u, Floats along, const Side& side,
                                 Ints coarse) {
    const Floats n = to_floats(coarse);
    const Floats center = wrap_inside(wrap, u) * n;
    const Floats reach = absolute(along) * (n * side.inverse) + 1.25f;
    return (absolute(u) < 32.0f) & (center > reach) & (center + reach < n);
}

OPENFAB_INLINE void find_footprint(const Picture& picture, const SampleRequest& request,
                                   Footprint* to) {
    Floats sx[3], sy[3];
    for (int32_t k = 0; k < 3; ++k) {
        sx[k] = request.du[k] * picture.width.n;
        sy[k] = request.dv[k] * picture.height.n;
    }
    const Floats a = (sx[0] * sx[0] + sx[1] * sx[1]) + sx[2] * sx[2];
    const Floats b = (sx[0] * sy[0] + sx[1] * sy[1]) + sx[2] * sy[2];
    const Floats c = (sy[0] * sy[0] + sy[1] * sy[1]) + sy[2] * sy[2];
    const Floats m = (a + c) * 0.5f;
    const Floats d = (a - c) * 0.5f;
    const Floats r = sqrt(d * d + b * b);
    Footprint& out = *to;
    out.active = request.active;
    out.major = bound(sqrt(m + r) * request.width, 0.0f, 0x1p30f);
    const Floats minor = bound(sqrt(bound(m - r, 0.0f, 0x1p60f)) * request.width, 0.0f, 0x1p30f);
    const Mask wide_x = d >= 0.0f;
    const Floats ex = select(wide_x, d + r, b);
    const Floats ey = select(wide_x, b, r - d);
    const Floats e = sqrt(ex * ex + ey * ey);
    const Mask usable = (e > 0.0f) & (e < 0x1p60f);
    out.ax = select(usable, ex / e, 1.0f);
    out.ay = masked(usable, ey / e);

    Floats wide = out.major;
    out.taps = 1.0f;
    if (picture.filter != kFilterTrilinear) {
        wide = max(minor, out.major * 0.125f);
        out.taps = bound(ceil(out.major / max(wide, 1.0f)), 1.0f, float{kMaxTaps});
    }
    out.taps = masked(request.active, out.taps);
    const Floats level = bound(log2_of(wide), 0.0f, static_cast<float>(picture.last_level));
    const Floats whole = floor(level);
    out.fraction = level - whole;
    const Ints fine = to_ints(whole);
    out.levels[0] = level_of(picture, fine, request.active);
    out.levels[1] = level_of(picture, min(max(fine + 1, 0), picture.last_level), request.active);
    const Floats half = out.major * 0.5f;
    const Level& coarse = out.levels[1];
    const Mask inside =
        stays_inside(picture.wrap.u, request.u, half * out.ax, picture.width, coarse.width) &
        stays_inside(picture.wrap.v, request.v, half * out.ay, picture.height, coarse.height);
    out.inside = !any(andnot(inside, request.active));
    const Mask kept = out.inside ? request.active : Mask::all();
    out.u = select(kept, request.u, 0.5f);
    out.v = select(kept, request.v, 0.5f);
}

}  // namespace
}  // namespace openfab::texture::OPENFAB_SIMD_ISA
