// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The taps of a footprint, and how their texels are fetched. Part of sample_kernel.h.

#include <cstddef>
#include <cstdint>

#include "simd/shuffles.h"
#include "simd/vectors.h"
#include "texture/sample_footprint.h"

namespace openfab::texture::OPENFAB_SIMD_ISA {
namespace {

/// The taps of one iteration, and the active lanes.
struct Tap {
    Mask taken;
    Floats u, v;
};

/// Computes the tap of an iteration; inactive lanes stay at the centre.
OPENFAB_INLINE Tap tap_of(const Picture& picture, const Footprint& footprint, int32_t trip) {
    const Floats number = static_cast<float>(trip);
    Tap out;
    out.taken = number < footprint.taps;
    const Floats t = masked(out.taken, ((number + 0.5f) / footprint.taps - 0.5f) * footprint.major);
    out.u = footprint.u + over(t * footprint.ax, picture.width);
    out.v = footprint.v + over(t * footprint.ay, picture.height);
    return out;
}

/// One axis of a tap in one level: its first texel, and the weight of the second.
struct Along {
    Ints texel;
    Floats weight;
};
OPENFAB_INLINE Along along_axis(Floats coordinate, Ints n) {
    const Floats x = coordinate * to_floats(n) - 0.5f;
    const Floats whole = floor(x);
    return {to_ints(whole), x - whole};
}

OPENFAB_INLINE Floats mix(Floats a, Floats b, Floats weight) {
    return a + (b - a) * weight;
}

// Loaders of two neighbouring texels for each lane, by the number of channels.

/// Loads from pictures with one channel.
struct OnlyChannel {
    static constexpr size_t kCount = 1;
    static constexpr int32_t stride() { return 1; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, Floats* first,
                             Floats* second) const {
        simd::load_pairs(texels, at, first, second);
    }
};

/// Loads one of several channels.
struct OneChannel {
    static constexpr size_t kCount = 1;
    int32_t channels, channel;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, Floats* first,
                             Floats* second) const {
        first[0] = simd::gather(texels + channel, at);
        second[0] = simd::gather(texels + channel + channels, at);
    }
};

/// Loads all of two to four channels. Always reads four values: those after an inside texel belong
/// to this level or, at its end, to the next, which is large enough.
struct AllChannels {
    static constexpr size_t kCount = kMaxChannels;
    int32_t channels;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, Floats* first,
                             Floats* second) const {
        simd::load_quads(texels, at, first);
        simd::load_quads(texels + channels, at, second);
    }
};

/// The reads of one iteration: the first texels of the rows, lower and upper, in both levels, and
/// the weights of their neighbours to the right and above.
struct Reading {
    alignas(sizeof(Ints)) int32_t at[2][2][kLanes];
    Floats x[2], y[2];
    Mask taken;
};

/// Lists the reads of lanes that all stay inside; returns one past the last.
OPENFAB_INLINE Reading* list_readings(const Picture& picture, const Footprint& footprint,
                                      int32_t stride, Reading* to) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip, ++to) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (!any(tap.taken)) break;
        to->taken = tap.taken;
        const Floats u = wrap_inside(picture.wrap.u, tap.u), v = wrap_inside(picture.wrap.v, tap.v);
        for (size_t l = 0; l < 2; ++l) {
            const Level& level = footprint.levels[l];
            const Along x = along_axis(u, level.width), y = along_axis(v, level.height);
            const Ints first = level.offset + (y.texel * level.width + x.texel) * stride;
            store(to->at[l][0], first);
            store(to->at[l][1], first + level.width * stride);
            to->x[l] = x.weight;
            to->y[l] = y.weight;
        }
    }
    return to;
}

template <typename Channels>
OPENFAB_INLINE void add_reading(const Picture& picture, const Reading& reading, Floats fraction,
                                const Channels& channels, Floats* sums) {
    constexpr size_t kCount = Channels::kCount;
    Floats of_level[2][kCount];
    for (size_t l = 0; l < 2; ++l) {
        Floats t[2][2][kCount];
        for (size_t row = 0; row < 2; ++row)
            channels.load(picture.texels, reading.at[l][row], t[row][0], t[row][1]);
        for (size_t c = 0; c < kCount; ++c) {
            of_level[l][c] = mix(mix(t[0][0][c], t[0][1][c], reading.x[l]),
                                 mix(t[1][0][c], t[1][1][c], reading.x[l]), reading.y[l]);
        }
    }
    for (size_t c = 0; c < kCount; ++c)
        sums[c] += masked(reading.taken, mix(of_level[0][c], of_level[1][c], fraction));
}

/// A texel's index along one axis after the wrap, and whether nothing is there: it was outside, in a
/// mode in which that counts.
struct Texel {
    Ints index;
    Mask outside;
};
OPENFAB_INLINE Texel wrap_texel(int32_t wrap, Ints x, Ints n) {
    const Ints last = n - 1;
    const Mask below = x<0, above = x> last;
    Ints moved = x;
    if (wrap == kWrapRepeat) {
        moved = select(below, x + n, select(above, x - n, x));
    } else if (wrap == kWrapMirror) {
        moved = select(below, -1 - x, select(above, 2 * n - 1 - x, x));
    }
    return {min(max(moved, 0), last), wrap == kWrapBlack ? below | above : Mask::from_bits(0)};
}

/// One channel of a texel; of that behind the last, whether the picture is there.
OPENFAB_INLINE Floats texel_at(const Picture& picture, const Level& level, const Texel& x,
                               const Texel& y, int32_t channel) {
    const Mask outside = x.outside | y.outside;
    if (channel == picture.channels) return andnot(outside, Floats(1.0f));
    alignas(sizeof(Ints)) int32_t at[kLanes];
    store(at, level.offset + (y.index * level.width + x.index) * picture.channels);
    const Floats value = simd::gather(picture.texels + channel, at);
    // Nothing looks white: colours of a picture with alpha are as on white.
    const bool white = picture.alpha && channel < picture.channels - 1;
    return white ? select(outside, 1.0f, value) : andnot(outside, value);
}

/// Sums the taps of lanes some of which read across the border.
OPENFAB_INLINE void sum_wrapped(const Picture& picture, const Footprint& footprint, uint32_t wanted,
                                Floats* sums) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (!any(tap.taken)) break;
        const Floats pu = wrap_coordinate(picture.wrap.u, tap.u);
        const Floats pv = wrap_coordinate(picture.wrap.v, tap.v);
        struct {
            Along x, y;
            Texel columns[2], rows[2];
        } read[2];
        for (size_t l = 0; l < 2; ++l) {
            const Level& level = footprint.levels[l];
            read[l].x = along_axis(pu, level.width);
            read[l].y = along_axis(pv, level.height);
            for (int32_t k = 0; k < 2; ++k) {
                read[l].columns[k] = wrap_texel(picture.wrap.u, read[l].x.texel + k, level.width);
                read[l].rows[k] = wrap_texel(picture.wrap.v, read[l].y.texel + k, level.height);
            }
        }
        for (uint32_t rest = wanted; rest != 0; rest &= rest - 1) {
            const int32_t channel = __builtin_ctz(rest);
            Floats of_level[2];
            for (size_t l = 0; l < 2; ++l) {
                Floats row[2];
                for (size_t k = 0; k < 2; ++k) {
                    const auto value = [&](size_t i) OPENFAB_INLINE_LAMBDA {
                        return texel_at(picture, footprint.levels[l], read[l].columns[i],
                                        read[l].rows[k], channel);
                    };
                    row[k] = mix(value(0), value(1), read[l].x.weight);
                }
                of_level[l] = mix(row[0], row[1], read[l].y.weight);
            }
            const Floats value = mix(of_level[0], of_level[1], footprint.fraction);
            sums[channel] += masked(tap.taken, value);
        }
    }
}

/// Reads the wanted channels by nearest-texel filtering.
OPENFAB_INLINE void read_nearest(const Picture& picture, const SampleRequest& request,
                                 uint32_t wanted, Floats* values) {
    const Level level = level_of(picture, 0, request.active);
    const auto at = [](int32_t wrap, Floats u, Ints n) OPENFAB_INLINE_LAMBDA {
        return wrap_texel(wrap, to_ints(floor(wrap_coordinate(wrap, u) * to_floats(n))), n);
    };
    const Texel x = at(picture.wrap.u, request.u, level.width);
    const Texel y = at(picture.wrap.v, request.v, level.height);
    for (uint32_t rest = wanted; rest != 0; rest &= rest - 1) {
        const int32_t channel = __builtin_ctz(rest);
        values[channel] = texel_at(picture, level, x, y, channel);
    }
}

}  // namespace
}  // namespace openfab::texture::OPENFAB_SIMD_ISA
