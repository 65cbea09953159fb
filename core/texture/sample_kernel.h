// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Samples pictures, a vector of requests at a time. sample_avx2.cpp and sample_sse41.cpp compile it
// with the flags of their instruction sets. The order of float operations is that of
// compiler/interp/sample.h; only the way in which texels are fetched differs.

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/shuffles.h"
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

/// The channels that are read for a requested one, -1 for none.
struct ChannelRead {
    int32_t channel = -1;
    int32_t alpha = -1;  ///< by which the colour itself is found
};

ChannelRead channel_read(const Picture& picture, int32_t requested) {
    const int32_t colors = picture.channels - (picture.alpha ? 1 : 0);
    const bool own = requested >= kOwnColor && requested < kOwnColor + 3;
    const int32_t channel = own ? requested - kOwnColor : requested;
    int32_t alpha = -1;
    if (picture.alpha) {
        alpha = colors;
    } else if (colors <= 3 && (picture.wrap.u == kWrapBlack || picture.wrap.v == kWrapBlack)) {
        alpha = picture.channels;
    }
    if (channel < colors) return {channel, own ? alpha : -1};
    if (colors == 1 && channel < 3) return {0, own ? alpha : -1};
    return {channel == 3 ? alpha : -1, -1};
}

/// A vector of requests and the address of its results.
struct Lanes {
    const float* from;
    float* to;
};

/// Vectors in a batch: first all footprints are found, then the addresses of all taps, then their
/// texels. A sample is one long dependency chain, of which the processor overlaps one or two as a
/// whole, but many in parts.
constexpr size_t kBatch = 16;

class Sampler {
  public:
    Sampler(const halide_buffer_t* requests, const halide_buffer_t* texels,
            const halide_buffer_t* info, int32_t fields, int32_t channels,
            const halide_buffer_t* out)
        : field_(requests->dim[1].stride),
          result_(out->dim[1].stride),
          results_(out->dim[1].extent),
          has_footprint_(fields == kSampleFieldsWithFootprint) {
        const bool empty = info->dim[0].extent == 0 || texels->dim[0].extent == 0;
        if (!empty) {
            const auto* const header = reinterpret_cast<const int32_t*>(info->host);
            const int32_t* const levels = header + kInfoHeader;
            picture_ = {reinterpret_cast<const float*>(texels->host),
                        levels,
                        header[0],
                        header[1] - 1,
                        header[3],
                        {header[2], header[kInfoWrapV]},
                        header[kInfoAlpha] != 0,
                        make_side(levels[1]),
                        make_side(levels[2])};
        }
        for (int32_t k = 0; k < results_; ++k) {
            const int32_t requested = channels >> 8 * k & 0xff;
            reads_[k] = empty ? ChannelRead{} : channel_read(picture_, requested);
            missing_[k] = requested == 3 && !empty ? 1.0f : 0.0f;
            for (const int32_t channel : {reads_[k].channel, reads_[k].alpha}) {
                if (channel >= 0) wanted_ |= 1u << channel;
            }
        }
        stored_ = wanted_ & ((1u << picture_.channels) - 1);
    }

    void run(const Lanes* lanes, size_t count) const {
        if (wanted_ == 0) {
            for (size_t i = 0; i < count; ++i)
                write(lanes[i], active_of(lanes[i]), nullptr);
        } else if (picture_.filter == kFilterNearest) {
            for (size_t i = 0; i < count; ++i)
                run_nearest(lanes[i]);
        } else {
            run_filtered(lanes, count);
        }
    }

  private:
    OPENFAB_INLINE Mask active_of(const Lanes& lanes) const {
        return Floats::load_unaligned(lanes.from) > 0.0f;
    }

    OPENFAB_INLINE Floats field(const Lanes& lanes, int32_t k) const {
        return Floats::load_unaligned(lanes.from + k * field_);
    }

    OPENFAB_INLINE void run_nearest(const Lanes& lanes) const {
        const Mask active = active_of(lanes);
        Floats values[kMaxChannels];
        if (any(active)) {
            const SampleRequest request = {active, field(lanes, 1), field(lanes, 2), {}, {}, {}};
            read_nearest(picture_, request, wanted_, values);
        }
        write(lanes, active, values);
    }

    OPENFAB_INLINE void run_filtered(const Lanes* lanes, size_t count) const {
        if (picture_.channels == 1) {
            run_filtered(lanes, count, OnlyChannel{}, 0);
        } else if ((stored_ & (stored_ - 1)) == 0) {
            const OneChannel one{picture_.channels, stored_ == 0 ? 0 : __builtin_ctz(stored_)};
            run_filtered(lanes, count, one, one.channel);
        } else {
            run_filtered(lanes, count, AllChannels{picture_.channels}, 0);
        }
    }

    /// `first`: of the picture's channels, what `channels` reads first.
    template <typename Channels>
    OPENFAB_INLINE void run_filtered(const Lanes* lanes, size_t count, const Channels& channels,
                                     int32_t first) const {
        Footprint footprints[kBatch];
        Reading readings[kBatch * kMaxTaps];
        Reading* ends[kBatch];
        for (size_t i = 0; i < count; ++i) {
            SampleRequest request;
            request.active = active_of(lanes[i]);
            footprints[i].active = request.active;
            if (!any(request.active)) continue;
            request.u = field(lanes[i], 1);
            request.v = field(lanes[i], 2);
            request.width = field(lanes[i], 3);
            for (int32_t k = 0; k < 3; ++k) {
                request.du[k] = has_footprint_ ? field(lanes[i], 4 + k) : Floats(0.0f);
                request.dv[k] = has_footprint_ ? field(lanes[i], 7 + k) : Floats(0.0f);
            }
            find_footprint(picture_, request, &footprints[i]);
        }
        Reading* reading = readings;
        for (size_t i = 0; i < count; ++i) {
            if (any(footprints[i].active) && footprints[i].inside)
                reading = list_readings(picture_, footprints[i], channels.stride(), reading);
            ends[i] = reading;
        }
        reading = readings;
        for (size_t i = 0; i < count; ++i) {
            const Footprint& footprint = footprints[i];
            Floats values[kMaxChannels] = {};
            if (any(footprint.active)) {
                if (!footprint.inside) sum_wrapped(picture_, footprint, wanted_, values);
                for (; reading != ends[i]; ++reading)
                    add_reading(picture_, *reading, footprint.fraction, channels, values + first);
                if (footprint.inside && wanted_ != stored_)
                    values[picture_.channels] = footprint.taps;
                for (uint32_t rest = wanted_; rest != 0; rest &= rest - 1)
                    values[__builtin_ctz(rest)] = values[__builtin_ctz(rest)] / footprint.taps;
            }
            write(lanes[i], footprint.active, values);
        }
    }

    OPENFAB_INLINE void write(const Lanes& lanes, Mask active, const Floats* values) const {
        const bool some = any(active);
        for (int32_t k = 0; k < results_; ++k) {
            Floats value{};
            if (some) value = result(reads_[k], missing_[k], values);
            store_unaligned(lanes.to + k * result_, masked(active, value));
        }
    }

    OPENFAB_INLINE Floats result(const ChannelRead& read, float missing,
                                 const Floats* values) const {
        if (read.channel < 0) return missing;
        const Floats value = values[read.channel];
        if (read.alpha < 0) return value;
        const Floats alpha = values[read.alpha];
        const Floats of_it = picture_.alpha ? value - (1.0f - alpha) : value;
        return masked(alpha > 0.0f, of_it / alpha);
    }

    Picture picture_{};
    int32_t field_, result_;  ///< strides
    int32_t results_;
    bool has_footprint_;
    uint32_t wanted_ =
        0;  ///< channels of the picture, by bits, and behind them whether it is there
    uint32_t stored_ = 0;  ///< of these the picture's
    ChannelRead reads_[kMaxChannels];
    float missing_[kMaxChannels] = {};
};

int sample(halide_buffer_t* requests, const halide_buffer_t* texels, const halide_buffer_t* info,
           int32_t fields, int32_t channels, const halide_buffer_t* out) {
    const bool shape_only = requests->is_bounds_query();
    if (shape_only) {
        for (int32_t d = 0; d < out->dimensions; ++d) {
            requests->dim[d].min = out->dim[d].min;
            requests->dim[d].extent = out->dim[d].extent;
        }
        requests->dim[1].min = 0;
        requests->dim[1].extent = fields;
    }
    if (shape_only || out->is_bounds_query()) return 0;

    const Sampler sampler(requests, texels, info, fields, channels, out);
    const auto dimension = [](const halide_buffer_t* buffer, int32_t d) {
        return d < buffer->dimensions ? buffer->dim[d] : halide_dimension_t(0, 1, 0);
    };
    const halide_dimension_t x = dimension(out, 2), y = dimension(out, 3), n = dimension(out, 4);
    // `requests` may be larger than the region that is computed.
    const auto request_at = [&](int32_t d, int32_t k) {
        const halide_dimension_t along = dimension(requests, d);
        return static_cast<ptrdiff_t>(dimension(out, d).min - along.min + k) * along.stride;
    };
    const auto* const first = reinterpret_cast<const float*>(requests->host) + request_at(0, 0);
    Lanes batch[kBatch];
    size_t count = 0;
    for (int32_t c = 0; c < n.extent; ++c) {
        for (int32_t b = 0; b < y.extent; ++b) {
            for (int32_t a = 0; a < x.extent; ++a) {
                const float* const from =
                    first + request_at(2, a) + request_at(3, b) + request_at(4, c);
                float* const to =
                    reinterpret_cast<float*>(out->host) + static_cast<ptrdiff_t>(a) * x.stride +
                    static_cast<ptrdiff_t>(b) * y.stride + static_cast<ptrdiff_t>(c) * n.stride;
                for (int32_t lane = 0; lane < out->dim[0].extent; lane += kLanes) {
                    batch[count++] = {from + lane, to + lane};
                    if (count < kBatch) continue;
                    sampler.run(batch, count);
                    count = 0;
                }
            }
        }
    }
    sampler.run(batch, count);
    return 0;
}

}  // namespace
}  // namespace openfab::texture::OPENFAB_SIMD_ISA
