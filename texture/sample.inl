// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Samples of pictures, a vector of requests at a time. Included by look_up_avx2.cpp and
// look_up_sse41.cpp. The order of float operations is that of compiler/interp/sample.h; only the
// way in which texels are fetched differs.

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "texture/pyramid.h"
#include "texture/sample.h"

namespace openfab::texture::OPENFAB_SAMPLE_ISA {
namespace {

#include "texture/sample_lanes.inl"

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

struct SampleRequest {
    I active;
    F u, v, width;
    F du[3], dv[3];
};

struct Level {
    I offset, width, height;
};

/// The footprints of a vector of requests. Inactive lanes have no taps.
struct Footprint {
    F u, v;
    F taps, major, ax, ay, fraction;
    std::array<Level, 2> levels;
    I active;
    bool inside;  ///< no tap reads a texel that has to be wrapped; inactive lanes are at 0.5
};

OPENFAB_INLINE F log2_of(F x) {
    const I bits = as_ints(x);
    const F e = to_floats((bits >> 23) - 127);
    const F f = as_floats((bits & 0x7fffff) | 0x3f800000) - 1.0f;
    const F q = ((-0.0448739553f * f + 0.150533197f) * f + -0.269578015f) * f + 0.442418579f;
    return masked(x >= 1.0f, e + (f + (f * (1.0f - f)) * q));
}

/// Returns the level of each lane; mostly all are the same. An inactive lane gets that of an active
/// one: its own might have no two texels in a row.
OPENFAB_INLINE Level level_of(const Picture& picture, I level, I active) {
    const int32_t one = level[__builtin_ctz(signs(active))];
    if (signs(active & (level != one)) == 0) {
        const int32_t* const row = picture.levels + one * kInfoPerLevel;
        return {splat(row[0]), splat(row[1]), splat(row[2])};
    }
    level = active ? level : splat(one);
    alignas(sizeof(I)) int32_t fields[3][kLanes];
    for (int32_t i = 0; i < kLanes; ++i) {
        const int32_t* const row = picture.levels + level[i] * kInfoPerLevel;
        for (int32_t k = 0; k < 3; ++k)
            fields[k][i] = row[k];
    }
    return {load<I>(fields[0]), load<I>(fields[1]), load<I>(fields[2])};
}

/// Moves a coordinate into the range that its wrap mode reads.
OPENFAB_INLINE F wrap_coordinate(const Picture& picture, F u) {
    if (picture.wrap == kWrapRepeat) {
        u -= floor(u);
    } else if (picture.wrap == kWrapMirror) {
        const F half = u * 0.5f;
        u = (half - floor(half)) * 2.0f;
    }
    return bound(u, -2.0f, 3.0f);
}

/// Same for coordinates between 0 and 1, or moved there by `repeat`.
OPENFAB_INLINE F wrap_inside(const Picture& picture, F u) {
    return picture.wrap == kWrapRepeat ? u - floor(u) : u;
}

/// Returns whether all taps along one axis read texels x0 and x0 + 1 of both levels with 0 <= x0
/// and x0 + 1 < n: a margin of a texel of the coarser level, and a quarter for rounding.
OPENFAB_INLINE I stays_inside(const Picture& picture, F u, F along, const Side& side, I coarse) {
    const F n = to_floats(coarse);
    const F center = wrap_inside(picture, u) * n;
    const F reach = absolute(along) * (n * side.inverse) + 1.25f;
    return (absolute(u) < 32.0f) & (center > reach) & (center + reach < n);
}

OPENFAB_INLINE void find_footprint(const Picture& picture, const SampleRequest& request,
                                   Footprint* to) {
    F sx[3], sy[3];
    for (int32_t k = 0; k < 3; ++k) {
        sx[k] = request.du[k] * picture.width.n;
        sy[k] = request.dv[k] * picture.height.n;
    }
    const F a = (sx[0] * sx[0] + sx[1] * sx[1]) + sx[2] * sx[2];
    const F b = (sx[0] * sy[0] + sx[1] * sy[1]) + sx[2] * sy[2];
    const F c = (sy[0] * sy[0] + sy[1] * sy[1]) + sy[2] * sy[2];
    const F m = (a + c) * 0.5f;
    const F d = (a - c) * 0.5f;
    const F r = sqrt(d * d + b * b);
    Footprint& out = *to;
    out.active = request.active;
    out.major = bound(sqrt(m + r) * request.width, 0.0f, 0x1p30f);
    const F minor = bound(sqrt(bound(m - r, 0.0f, 0x1p60f)) * request.width, 0.0f, 0x1p30f);
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
    out.taps = masked(request.active, out.taps);
    const F level = bound(log2_of(wide), 0.0f, static_cast<float>(picture.last_level));
    const F whole = floor(level);
    out.fraction = level - whole;
    const I fine = to_ints(whole);
    out.levels[0] = level_of(picture, fine, request.active);
    out.levels[1] =
        level_of(picture, bound(fine + 1, splat(0), splat(picture.last_level)), request.active);
    const F half = out.major * 0.5f;
    const Level& coarse = out.levels[1];
    const I inside = stays_inside(picture, request.u, half * out.ax, picture.width, coarse.width) &
                     stays_inside(picture, request.v, half * out.ay, picture.height, coarse.height);
    out.inside = signs(request.active & ~inside) == 0;
    const I kept = out.inside ? request.active : splat(-1);
    out.u = kept ? request.u : splat(0.5f);
    out.v = kept ? request.v : splat(0.5f);
}

/// The taps of one trip, and the lanes that take one.
struct Tap {
    I taken;
    F u, v;
};

/// Computes the tap of a trip; lanes that take none stay at the centre.
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
OPENFAB_INLINE Along along_axis(F coordinate, I n) {
    const F x = coordinate * to_floats(n) - 0.5f;
    const F whole = floor(x);
    return {to_ints(whole), x - whole};
}

OPENFAB_INLINE F mix(F a, F b, F weight) {
    return a + (b - a) * weight;
}

// Loaders of two neighbouring texels for each lane, by the number of channels.

/// Loads from pictures with one channel.
struct OnlyChannel {
    static constexpr size_t kCount = 1;
    static constexpr int32_t stride() { return 1; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        load_pairs(texels, at, first, second);
    }
};

/// Loads one of several channels.
struct OneChannel {
    static constexpr size_t kCount = 1;
    int32_t channels, channel;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        first[0] = gather(texels + channel, at);
        second[0] = gather(texels + channel + channels, at);
    }
};

/// Loads all of two to four channels. Four values are read: those behind a texel that stays inside
/// belong to this level or, at its end, to the next, which has enough of them.
struct AllChannels {
    static constexpr size_t kCount = kMaxChannels;
    int32_t channels;
    int32_t stride() const { return channels; }
    OPENFAB_INLINE void load(const float* texels, const int32_t* at, F* first, F* second) const {
        load_quads(texels, at, first);
        load_quads(texels + channels, at, second);
    }
};

/// The reads of one trip: the first texels of the rows, lower and upper, in both levels, and the
/// weights of their neighbours to the right and above.
struct Reading {
    alignas(sizeof(I)) int32_t at[2][2][kLanes];
    F x[2], y[2];
    I taken;
};

/// Lists the readings of lanes that all stay inside; returns one past the last.
OPENFAB_INLINE Reading* list_readings(const Picture& picture, const Footprint& footprint,
                                      int32_t stride, Reading* to) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip, ++to) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (signs(tap.taken) == 0) break;
        to->taken = tap.taken;
        const F u = wrap_inside(picture, tap.u), v = wrap_inside(picture, tap.v);
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

/// A texel's index along one axis after the wrap, and whether it was outside before.
struct Texel {
    I index, outside;
};
OPENFAB_INLINE Texel wrap_texel(const Picture& picture, I x, I n) {
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

/// Sums the taps of lanes of which some read across the border.
OPENFAB_INLINE void sum_wrapped(const Picture& picture, const Footprint& footprint, uint32_t wanted,
                                F* sums) {
    for (int32_t trip = 0; trip < kMaxTaps; ++trip) {
        const Tap tap = tap_of(picture, footprint, trip);
        if (signs(tap.taken) == 0) break;
        const F pu = wrap_coordinate(picture, tap.u), pv = wrap_coordinate(picture, tap.v);
        struct {
            Along x, y;
            Texel columns[2], rows[2];
        } read[2];
        for (size_t l = 0; l < 2; ++l) {
            const Level& level = footprint.levels[l];
            read[l].x = along_axis(pu, level.width);
            read[l].y = along_axis(pv, level.height);
            for (int32_t k = 0; k < 2; ++k) {
                read[l].columns[k] = wrap_texel(picture, read[l].x.texel + k, level.width);
                read[l].rows[k] = wrap_texel(picture, read[l].y.texel + k, level.height);
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

/// Reads the wanted channels by nearest-texel filtering.
OPENFAB_INLINE void read_nearest(const Picture& picture, const SampleRequest& request,
                                 uint32_t wanted, F* values) {
    const Level level = level_of(picture, splat(0), request.active);
    const auto at = [&](F u, I n) __attribute__((always_inline)) {
        return wrap_texel(picture, to_ints(floor(wrap_coordinate(picture, u) * to_floats(n))), n);
    };
    const Texel x = at(request.u, level.width), y = at(request.v, level.height);
    for (uint32_t rest = wanted; rest != 0; rest &= rest - 1) {
        const int32_t channel = __builtin_ctz(rest);
        values[channel] = texel_at(picture, level, x, y, channel);
    }
}

/// Returns the channel that is read for the requested one; -1 where there is none.
int32_t channel_read(const Picture& picture, int32_t channel) {
    if (channel < picture.channels) return channel;
    return picture.channels == 1 && channel < 3 ? 0 : -1;
}

/// A vector of requests and the address of its results.
struct Lanes {
    const float* from;
    float* to;
};

/// Vectors in a batch: first all footprints are found, then the addresses of all taps, then their
/// texels. A sample is one long chain of operations, of which the processor overlaps one or two at
/// a time, but many of its parts.
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
                        header[2],
                        header[3],
                        make_side(levels[1]),
                        make_side(levels[2])};
        }
        for (int32_t k = 0; k < results_; ++k) {
            const int32_t requested = channels >> 8 * k & 0xff;
            const int32_t channel = empty ? -1 : channel_read(picture_, requested);
            channels_[k] = channel;
            missing_[k] = requested == 3 && !empty ? 1.0f : 0.0f;
            if (channel >= 0) wanted_ |= 1u << channel;
        }
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
    OPENFAB_INLINE I active_of(const Lanes& lanes) const { return load<F>(lanes.from) > 0.0f; }

    OPENFAB_INLINE F field(const Lanes& lanes, int32_t k) const {
        return load<F>(lanes.from + k * field_);
    }

    OPENFAB_INLINE void run_nearest(const Lanes& lanes) const {
        const I active = active_of(lanes);
        F values[kMaxChannels];
        if (signs(active) != 0) {
            const SampleRequest request = {active, field(lanes, 1), field(lanes, 2), {}, {}, {}};
            read_nearest(picture_, request, wanted_, values);
        }
        write(lanes, active, values);
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
            SampleRequest request;
            request.active = active_of(lanes[i]);
            footprints[i].active = request.active;
            if (signs(request.active) == 0) continue;
            request.u = field(lanes[i], 1);
            request.v = field(lanes[i], 2);
            request.width = field(lanes[i], 3);
            for (int32_t k = 0; k < 3; ++k) {
                request.du[k] = has_footprint_ ? field(lanes[i], 4 + k) : F{};
                request.dv[k] = has_footprint_ ? field(lanes[i], 7 + k) : F{};
            }
            find_footprint(picture_, request, &footprints[i]);
        }
        Reading* reading = readings;
        for (size_t i = 0; i < count; ++i) {
            if (signs(footprints[i].active) != 0 && footprints[i].inside)
                reading = list_readings(picture_, footprints[i], channels.stride(), reading);
            ends[i] = reading;
        }
        reading = readings;
        for (size_t i = 0; i < count; ++i) {
            const Footprint& footprint = footprints[i];
            F values[kMaxChannels] = {};
            if (signs(footprint.active) != 0) {
                if (!footprint.inside) sum_wrapped(picture_, footprint, wanted_, values);
                for (; reading != ends[i]; ++reading)
                    add_reading(picture_, *reading, footprint.fraction, channels, values + first);
                for (uint32_t rest = wanted_; rest != 0; rest &= rest - 1)
                    values[__builtin_ctz(rest)] /= footprint.taps;
            }
            write(lanes[i], footprint.active, values);
        }
    }

    OPENFAB_INLINE void write(const Lanes& lanes, I active, const F* values) const {
        const bool any = signs(active) != 0;
        for (int32_t k = 0; k < results_; ++k) {
            F value{};
            if (any) value = channels_[k] < 0 ? splat(missing_[k]) : values[channels_[k]];
            store(lanes.to + k * result_, masked(active, value));
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
}  // namespace openfab::texture::OPENFAB_SAMPLE_ISA
