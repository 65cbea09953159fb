// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Look-ups in pictures, a vector of places at a time. Included by look_up_avx2.cpp and
// look_up_sse41.cpp. The order of float operations is that of compiler/interp/sample.h; what
// differs is how texels are found.

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "texture/look_up.h"
#include "texture/pyramid.h"

namespace openfab::texture::OPENFAB_LOOK_UP_ISA {
namespace {

#include "texture/look_up_lanes.inl"

constexpr int32_t kMaxTaps = 8;
constexpr int32_t kMaxChannels = 4;

/// Texels along one axis of level 0.
struct Side {
    float n, inverse;
    bool exact;  ///< a power of two: products with the inverse have the bits of quotients
};

Side make_side(int32_t n) {
    const auto real = static_cast<float>(n);
    return {real, 1.0f / real, (n & (n - 1)) == 0};
}

OPENFAB_INLINE F over(F x, const Side& side) {
    return side.exact ? x * side.inverse : x / side.n;
}

struct Picture {
    const float* texels;
    const int32_t* levels;  ///< kInfoPerLevel values each
    int32_t channels, last_level, wrap, filter;
    Side width, height;
};

struct Place {
    I asked;
    F u, v, width;
    F du[3], dv[3];
};

struct Level {
    I offset, width, height;
};

/// What is read for a vector of places. Lanes that are not asked have no taps.
struct Footprint {
    F u, v;
    F taps, major, ax, ay, fraction;
    std::array<Level, 2> levels;
    I asked;
    bool inside;  ///< no tap reaches a texel that has to be wrapped; lanes not asked are at 0.5
};

OPENFAB_INLINE F log2_of(F x) {
    const I bits = as_ints(x);
    const F e = to_floats((bits >> 23) - 127);
    const F f = as_floats((bits & 0x7fffff) | 0x3f800000) - 1.0f;
    const F q = ((-0.0448739553f * f + 0.150533197f) * f + -0.269578015f) * f + 0.442418579f;
    return masked(x >= 1.0f, e + (f + (f * (1.0f - f)) * q));
}

/// The level of each lane; mostly all have one. A lane that is not asked has one that is: its own
/// might have no texels beside each other.
OPENFAB_INLINE Level level_of(const Picture& picture, I level, I asked) {
    const int32_t one = level[__builtin_ctz(signs(asked))];
    if (signs(asked & (level != one)) == 0) {
        const int32_t* const row = picture.levels + one * kInfoPerLevel;
        return {splat(row[0]), splat(row[1]), splat(row[2])};
    }
    level = asked ? level : splat(one);
    alignas(sizeof(I)) int32_t fields[3][kLanes];
    for (int32_t i = 0; i < kLanes; ++i) {
        const int32_t* const row = picture.levels + level[i] * kInfoPerLevel;
        for (int32_t k = 0; k < 3; ++k)
            fields[k][i] = row[k];
    }
    return {load<I>(fields[0]), load<I>(fields[1]), load<I>(fields[2])};
}

/// A coordinate moved into the range that its wrap reads.
OPENFAB_INLINE F placed(const Picture& picture, F u) {
    if (picture.wrap == kWrapRepeat) {
        u -= floor(u);
    } else if (picture.wrap == kWrapMirror) {
        const F half = u * 0.5f;
        u = (half - floor(half)) * 2.0f;
    }
    return bound(u, -2.0f, 3.0f);
}

/// The same of what is between 0 and 1, or moved there by `repeat`.
OPENFAB_INLINE F placed_inside(const Picture& picture, F u) {
    return picture.wrap == kWrapRepeat ? u - floor(u) : u;
}

/// Whether all taps along one axis read texels x0 and x0 + 1 of both levels with 0 <= x0 and
/// x0 + 1 < n: a texel and a quarter of the coarser level is kept from the border, the quarter for
/// rounding.
OPENFAB_INLINE I stays_inside(const Picture& picture, F u, F along, const Side& side, I coarse) {
    const F n = to_floats(coarse);
    const F middle = placed_inside(picture, u) * n;
    const F reach = absolute(along) * (n * side.inverse) + 1.25f;
    return (absolute(u) < 32.0f) & (middle > reach) & (middle + reach < n);
}

OPENFAB_INLINE void find_footprint(const Picture& picture, const Place& place, Footprint* to) {
    F sx[3], sy[3];
    for (int32_t k = 0; k < 3; ++k) {
        sx[k] = place.du[k] * picture.width.n;
        sy[k] = place.dv[k] * picture.height.n;
    }
    const F a = (sx[0] * sx[0] + sx[1] * sx[1]) + sx[2] * sx[2];
    const F b = (sx[0] * sy[0] + sx[1] * sy[1]) + sx[2] * sy[2];
    const F c = (sy[0] * sy[0] + sy[1] * sy[1]) + sy[2] * sy[2];
    const F m = (a + c) * 0.5f;
    const F d = (a - c) * 0.5f;
    const F r = sqrt(d * d + b * b);
    Footprint& out = *to;
    out.asked = place.asked;
    out.major = bound(sqrt(m + r) * place.width, 0.0f, 0x1p30f);
    const F minor = bound(sqrt(bound(m - r, 0.0f, 0x1p60f)) * place.width, 0.0f, 0x1p30f);
    const I wide_x = d >= 0.0f;
    const F ex = wide_x ? d + r : b;
    const F ey = wide_x ? b : r - d;
    const F e = sqrt(ex * ex + ey * ey);
    const I usable = (e > 0.0f) & (e < 0x1p60f);
    out.ax = usable ? ex / e : splat(1.0f);
    out.ay = masked(usable, ey / e);

    F wide = out.major;
    out.taps = splat(1.0f);
    if (picture.filter != kFilterTrilinear) {
        wide = larger(minor, out.major * 0.125f);
        out.taps = bound(ceil(out.major / larger(wide, splat(1.0f))), 1.0f, float{kMaxTaps});
    }
    out.taps = masked(place.asked, out.taps);
    const F level = bound(log2_of(wide), 0.0f, static_cast<float>(picture.last_level));
    const F whole = floor(level);
    out.fraction = level - whole;
    const I finer = to_ints(whole);
    out.levels[0] = level_of(picture, finer, place.asked);
    out.levels[1] =
        level_of(picture, bound(finer + 1, splat(0), splat(picture.last_level)), place.asked);
    const F half = out.major * 0.5f;
    const Level& coarse = out.levels[1];
    const I inside = stays_inside(picture, place.u, half * out.ax, picture.width, coarse.width) &
                     stays_inside(picture, place.v, half * out.ay, picture.height, coarse.height);
    out.inside = signs(place.asked & ~inside) == 0;
    const I kept = out.inside ? place.asked : splat(-1);
    out.u = kept ? place.u : splat(0.5f);
    out.v = kept ? place.v : splat(0.5f);
}

/// Where the taps of one trip are, and which lanes take one.
struct Tap {
    I taken;
    F u, v;
};

/// Lanes that take none stay at the middle.
OPENFAB_INLINE Tap tap_of(const Picture& picture, const Footprint& footprint, int32_t trip) {
    const F number = splat(static_cast<float>(trip));
    Tap out;
    out.taken = number < footprint.taps;
    const F t = masked(out.taken, ((number + 0.5f) / footprint.taps - 0.5f) * footprint.major);
    out.u = footprint.u + over(t * footprint.ax, picture.width);
    out.v = footprint.v + over(t * footprint.ay, picture.height);
    return out;
}

/// One axis of a tap in one level: its first texel, and the weight of the second.
struct Along {
    I texel;
    F weight;
};
OPENFAB_INLINE Along along_axis(F placed, I n) {
    const F x = placed * to_floats(n) - 0.5f;
    const F whole = floor(x);
    return {to_ints(whole), x - whole};
}

OPENFAB_INLINE F mix(F a, F b, F weight) {
    return a + (b - a) * weight;
}

// What reads two texels beside each other from each lane's place, in ways that differ by the number
// of channels.

/// Of pictures with one channel.
struct OnlyChannel {
    static constexpr size_t kCount = 1;
    static constexpr int32_t stride() { return 1; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        load_pairs(texels, at, first, second);
    }
};

/// One of several.
struct OneChannel {
    static constexpr size_t kCount = 1;
    int32_t channels, channel;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        first[0] = gather(texels + channel, at);
        second[0] = gather(texels + channel + channels, at);
    }
};

/// All of two to four. Four values are read: those behind a texel that stays inside are of this
/// level or, at its end, of the next, which has as many as can be too many.
struct AllChannels {
    static constexpr size_t kCount = kMaxChannels;
    int32_t channels;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        load_quads(texels, at, first);
        load_quads(texels + channels, at, second);
    }
};

/// What one trip reads: the first texels of the rows, lower and upper, in both levels, and the
/// weights of what is to their right and above.
struct Reading {
    alignas(sizeof(I)) int32_t at[2][2][kLanes];
    F x[2], y[2];
    I taken;
};

/// The readings of lanes that all stay inside; returns behind the last.
OPENFAB_INLINE Reading* list_readings(const Picture& picture, const Footprint& footprint,
                                      int32_t stride, Reading* to) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip, ++to) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (signs(tap.taken) == 0) break;
        to->taken = tap.taken;
        const F u = placed_inside(picture, tap.u), v = placed_inside(picture, tap.v);
        for (size_t l = 0; l < 2; ++l) {
            const Level& level = footprint.levels[l];
            const Along x = along_axis(u, level.width), y = along_axis(v, level.height);
            const I first = level.offset + (y.texel * level.width + x.texel) * stride;
            store(to->at[l][0], first);
            store(to->at[l][1], first + level.width * stride);
            to->x[l] = x.weight;
            to->y[l] = y.weight;
        }
    }
    return to;
}

template <typename Channels>
OPENFAB_INLINE void add_reading(const Picture& picture, const Reading& reading, F fraction,
                                const Channels& channels, F* sums) {
    constexpr size_t kCount = Channels::kCount;
    F of_level[2][kCount];
    for (size_t l = 0; l < 2; ++l) {
        F t[2][2][kCount];
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

/// A texel's place along one axis after the wrap, and whether it was outside before.
struct Texel {
    I index, outside;
};
OPENFAB_INLINE Texel wrapped(const Picture& picture, I x, I n) {
    const I below = x < 0, above = x >= n;
    I moved = x;
    if (picture.wrap == kWrapRepeat) {
        moved = below ? x + n : (above ? x - n : x);
    } else if (picture.wrap == kWrapMirror) {
        moved = below ? -1 - x : (above ? 2 * n - 1 - x : x);
    }
    return {bound(moved, splat(0), n - 1), below | above};
}

/// One channel of a texel.
OPENFAB_INLINE F texel_at(const Picture& picture, const Level& level, const Texel& x,
                          const Texel& y, int32_t channel) {
    alignas(sizeof(I)) int32_t at[kLanes];
    store(at, level.offset + (y.index * level.width + x.index) * picture.channels);
    const F value = gather(picture.texels + channel, at);
    return picture.wrap == kWrapBlack ? masked(~(x.outside | y.outside), value) : value;
}

/// The taps of lanes of which some read across the border.
OPENFAB_INLINE void sum_anywhere(const Picture& picture, const Footprint& footprint,
                                 uint32_t wanted, F* sums) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (signs(tap.taken) == 0) break;
        const F pu = placed(picture, tap.u), pv = placed(picture, tap.v);
        struct {
            Along x, y;
            Texel columns[2], rows[2];
        } read[2];
        for (size_t l = 0; l < 2; ++l) {
            const Level& level = footprint.levels[l];
            read[l].x = along_axis(pu, level.width);
            read[l].y = along_axis(pv, level.height);
            for (int32_t k = 0; k < 2; ++k) {
                read[l].columns[k] = wrapped(picture, read[l].x.texel + k, level.width);
                read[l].rows[k] = wrapped(picture, read[l].y.texel + k, level.height);
            }
        }
        for (uint32_t rest = wanted; rest != 0; rest &= rest - 1) {
            const int32_t channel = __builtin_ctz(rest);
            F of_level[2];
            for (size_t l = 0; l < 2; ++l) {
                F row[2];
                for (size_t k = 0; k < 2; ++k) {
                    const auto value = [&](size_t i) __attribute__((always_inline)) {
                        return texel_at(picture, footprint.levels[l], read[l].columns[i],
                                        read[l].rows[k], channel);
                    };
                    row[k] = mix(value(0), value(1), read[l].x.weight);
                }
                of_level[l] = mix(row[0], row[1], read[l].y.weight);
            }
            const F value = mix(of_level[0], of_level[1], footprint.fraction);
            sums[channel] += masked(tap.taken, value);
        }
    }
}

/// The wanted channels of places, of which each reads one texel.
OPENFAB_INLINE void read_nearest(const Picture& picture, const Place& place, uint32_t wanted,
                                 F* values) {
    const Level level = level_of(picture, splat(0), place.asked);
    const auto at = [&](F u, I n) __attribute__((always_inline)) {
        return wrapped(picture, to_ints(floor(placed(picture, u) * to_floats(n))), n);
    };
    const Texel x = at(place.u, level.width), y = at(place.v, level.height);
    for (uint32_t rest = wanted; rest != 0; rest &= rest - 1) {
        const int32_t channel = __builtin_ctz(rest);
        values[channel] = texel_at(picture, level, x, y, channel);
    }
}

/// The channel that is read for the one asked; -1 where there is none.
int32_t channel_read(const Picture& picture, int32_t channel) {
    if (channel < picture.channels) return channel;
    return picture.channels == 1 && channel < 3 ? 0 : -1;
}

/// A vector of places and where its results go.
struct Lanes {
    const float* from;
    float* to;
};

/// Vectors of which first all footprints are found, then the places of all taps, then their texels:
/// together it is one long chain of operations, of which the processor sees one or two at a time,
/// but many of its parts.
constexpr size_t kBatch = 16;

class LookUp {
  public:
    LookUp(const halide_buffer_t* places, const halide_buffer_t* texels,
           const halide_buffer_t* info, int32_t fields, int32_t channels,
           const halide_buffer_t* out)
        : field_(places->dim[1].stride),
          result_(out->dim[1].stride),
          results_(out->dim[1].extent),
          has_footprint_(fields == kPlaceFieldsWithFootprint) {
        const bool empty = info->dim[0].extent == 0 || texels->dim[0].extent == 0;
        if (!empty) {
            const auto* const header = reinterpret_cast<const int32_t*>(info->host);
            const int32_t* const levels = header + kInfoHeader;
            picture_ = {reinterpret_cast<const float*>(texels->host),
                        levels,
                        header[0],
                        header[1] - 1,
                        header[2],
                        header[3],
                        make_side(levels[1]),
                        make_side(levels[2])};
        }
        for (int32_t k = 0; k < results_; ++k) {
            const int32_t asked = channels >> 8 * k & 0xff;
            const int32_t channel = empty ? -1 : channel_read(picture_, asked);
            channels_[k] = channel;
            missing_[k] = asked == 3 && !empty ? 1.0f : 0.0f;
            if (channel >= 0) wanted_ |= 1u << channel;
        }
    }

    void run(const Lanes* lanes, size_t count) const {
        if (wanted_ == 0) {
            for (size_t i = 0; i < count; ++i)
                write(lanes[i], asked_of(lanes[i]), nullptr);
        } else if (picture_.filter == kFilterNearest) {
            for (size_t i = 0; i < count; ++i)
                run_nearest(lanes[i]);
        } else {
            run_filtered(lanes, count);
        }
    }

  private:
    OPENFAB_INLINE I asked_of(const Lanes& lanes) const { return load<F>(lanes.from) > 0.0f; }

    OPENFAB_INLINE F field(const Lanes& lanes, int32_t k) const {
        return load<F>(lanes.from + k * field_);
    }

    OPENFAB_INLINE void run_nearest(const Lanes& lanes) const {
        const I asked = asked_of(lanes);
        F values[kMaxChannels];
        if (signs(asked) != 0) {
            const Place place = {asked, field(lanes, 1), field(lanes, 2), {}, {}, {}};
            read_nearest(picture_, place, wanted_, values);
        }
        write(lanes, asked, values);
    }

    OPENFAB_INLINE void run_filtered(const Lanes* lanes, size_t count) const {
        if (picture_.channels == 1) {
            run_filtered(lanes, count, OnlyChannel{}, 0);
        } else if ((wanted_ & (wanted_ - 1)) == 0) {
            const OneChannel one{picture_.channels, __builtin_ctz(wanted_)};
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
            Place place;
            place.asked = asked_of(lanes[i]);
            footprints[i].asked = place.asked;
            if (signs(place.asked) == 0) continue;
            place.u = field(lanes[i], 1);
            place.v = field(lanes[i], 2);
            place.width = field(lanes[i], 3);
            for (int32_t k = 0; k < 3; ++k) {
                place.du[k] = has_footprint_ ? field(lanes[i], 4 + k) : F{};
                place.dv[k] = has_footprint_ ? field(lanes[i], 7 + k) : F{};
            }
            find_footprint(picture_, place, &footprints[i]);
        }
        Reading* reading = readings;
        for (size_t i = 0; i < count; ++i) {
            if (signs(footprints[i].asked) != 0 && footprints[i].inside)
                reading = list_readings(picture_, footprints[i], channels.stride(), reading);
            ends[i] = reading;
        }
        reading = readings;
        for (size_t i = 0; i < count; ++i) {
            const Footprint& footprint = footprints[i];
            F values[kMaxChannels] = {};
            if (signs(footprint.asked) != 0) {
                if (!footprint.inside) sum_anywhere(picture_, footprint, wanted_, values);
                for (; reading != ends[i]; ++reading)
                    add_reading(picture_, *reading, footprint.fraction, channels, values + first);
                for (uint32_t rest = wanted_; rest != 0; rest &= rest - 1)
                    values[__builtin_ctz(rest)] /= footprint.taps;
            }
            write(lanes[i], footprint.asked, values);
        }
    }

    OPENFAB_INLINE void write(const Lanes& lanes, I asked, const F* values) const {
        const bool any = signs(asked) != 0;
        for (int32_t k = 0; k < results_; ++k) {
            F value{};
            if (any) value = channels_[k] < 0 ? splat(missing_[k]) : values[channels_[k]];
            store(lanes.to + k * result_, masked(asked, value));
        }
    }

    Picture picture_{};
    int32_t field_, result_;  ///< strides
    int32_t results_;
    bool has_footprint_;
    uint32_t wanted_ = 0;  ///< channels of the picture, by bits
    int32_t channels_[kMaxChannels] = {};
    float missing_[kMaxChannels] = {};
};

int look_up(halide_buffer_t* places, const halide_buffer_t* texels, const halide_buffer_t* info,
            int32_t fields, int32_t channels, const halide_buffer_t* out) {
    const bool shape_only = places->is_bounds_query();
    if (shape_only) {
        for (int32_t d = 0; d < out->dimensions; ++d) {
            places->dim[d].min = out->dim[d].min;
            places->dim[d].extent = out->dim[d].extent;
        }
        places->dim[1].min = 0;
        places->dim[1].extent = fields;
    }
    if (shape_only || out->is_bounds_query()) return 0;

    const LookUp look_up(places, texels, info, fields, channels, out);
    const auto dimension = [](const halide_buffer_t* buffer, int32_t d) {
        return d < buffer->dimensions ? buffer->dim[d] : halide_dimension_t(0, 1, 0);
    };
    const halide_dimension_t x = dimension(out, 2), y = dimension(out, 3), n = dimension(out, 4);
    // `places` may hold more than is asked for.
    const auto place_at = [&](int32_t d, int32_t k) {
        const halide_dimension_t along = dimension(places, d);
        return static_cast<ptrdiff_t>(dimension(out, d).min - along.min + k) * along.stride;
    };
    const auto* const first = reinterpret_cast<const float*>(places->host) + place_at(0, 0);
    Lanes batch[kBatch];
    size_t count = 0;
    for (int32_t c = 0; c < n.extent; ++c) {
        for (int32_t b = 0; b < y.extent; ++b) {
            for (int32_t a = 0; a < x.extent; ++a) {
                const float* const from = first + place_at(2, a) + place_at(3, b) + place_at(4, c);
                float* const to =
                    reinterpret_cast<float*>(out->host) + static_cast<ptrdiff_t>(a) * x.stride +
                    static_cast<ptrdiff_t>(b) * y.stride + static_cast<ptrdiff_t>(c) * n.stride;
                for (int32_t lane = 0; lane < out->dim[0].extent; lane += kLanes) {
                    batch[count++] = {from + lane, to + lane};
                    if (count < kBatch) continue;
                    look_up.run(batch, count);
                    count = 0;
                }
            }
        }
    }
    look_up.run(batch, count);
    return 0;
}

}  // namespace
}  // namespace openfab::texture::OPENFAB_LOOK_UP_ISA
