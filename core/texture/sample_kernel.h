// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Samples pictures, a vector of requests at a time. sample_avx2.cpp and sample_sse41.cpp compile it
// with the flags of their instruction sets. The order of float operations is that of
// compiler/interp/sample.h; only the way in which texels are fetched differs.

#include <cstddef>
#include <cstdint>

#include "simd/vectors.h"
#include "texture/pyramid.h"
#include "texture/sample.h"
#include "texture/sample_footprint.h"
#include "texture/sample_taps.h"

namespace openfab::texture::OPENFAB_SIMD_ISA {
namespace {

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
