// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a curve, a uniform of type Spline or ColorRamp, is kept among an object's uniform values: as floats, one cubic a
// stretch between keys, so that a lookup is the same for every interpolation. The runtime fills the table from the keys
// in the world; generated code picks the stretch and evaluates.
//
//     first, last                      x is clamped to these
//     low, high                        for each channel: no value is beyond
//     for each of kCurveKeys keys:
//         x                            where its stretch begins; kNoKey behind the last
//         c0, c1, c2, c3               for each channel: ((c3 d + c2) d + c1) d + c0, d from x on
//
// A program of derivatives has, beside a curve `share`, for a key that is asked for a uniform `share[3]`: for each
// channel a table that holds how that of the curve changes with the key's value in this channel.

#include <cstdint>

namespace openfab::abi {

constexpr int32_t kCurveKeys = 16;
/// Beyond any x that is clamped.
constexpr float kNoKey = 3e38F;

constexpr int32_t curve_header(int32_t channels) {
    return 2 + 2 * channels;
}
constexpr int32_t curve_stride(int32_t channels) {
    return 1 + 4 * channels;
}
/// Where the coefficients of a channel's stretch begin.
constexpr int32_t curve_coefficients(int32_t channels, int32_t key, int32_t channel) {
    return curve_header(channels) + key * curve_stride(channels) + 1 + 4 * channel;
}
/// The number of floats of a table.
constexpr int32_t curve_size(int32_t channels) {
    return curve_header(channels) + kCurveKeys * curve_stride(channels);
}
/// The channels of a table of that many floats.
constexpr int32_t curve_channels(int32_t size) {
    return size == curve_size(1) ? 1 : 3;
}

}  // namespace openfab::abi
