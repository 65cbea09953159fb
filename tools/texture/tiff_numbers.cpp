// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_numbers.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

using Kind = TiffDirectory::Kind;
using Scale = TiffImage::Scale;

template <typename T>
T load(const uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

template <typename T>
bool is_held(T value, float as) {
    // 2^63 and 2^64 are floats beyond their types.
    const double limit = std::ldexp(1.0, std::numeric_limits<T>::digits);
    return static_cast<double>(as) < limit && static_cast<T>(as) == value;
}

/// Integers of whole bytes.
template <typename T>
void integers(Scale scale, const uint8_t* in, int64_t count, int stride, float* out,
              bool* rounded) {
    constexpr bool kFraction = std::is_unsigned_v<T> && sizeof(T) <= 2;
    if (kFraction || scale == Scale::kPicture) {
        const float unit = 1.0F / static_cast<float>(std::numeric_limits<T>::max());
        for (int64_t i = 0; i < count; ++i, in += sizeof(T), out += stride)
            *out = static_cast<float>(load<T>(in)) * unit;
        return;
    }
    bool held = true;
    for (int64_t i = 0; i < count; ++i, in += sizeof(T), out += stride) {
        const T value = load<T>(in);
        *out = static_cast<float>(value);
        if constexpr (sizeof(T) > 2) held = held && is_held(value, *out);
    }
    *rounded = *rounded || !held;
}

template <typename T>
void floats(const uint8_t* in, int64_t count, int stride, float* out) {
    for (int64_t i = 0; i < count; ++i, in += sizeof(T), out += stride)
        *out = static_cast<float>(load<T>(in));
}

void halves(const uint8_t* in, int64_t count, int stride, float* out) {
    const NumberFormat format{NumberFormat::Kind::kFloat, 2, false, true};
    for (int64_t i = 0; i < count; ++i, in += 2, out += stride)
        *out = read_number(format, reinterpret_cast<const char*>(in));
}

/// Floats of 24 bits: a sign, 7 bits of exponent, 16 of fraction (TIFF Technical Note 3).
void floats24(const uint8_t* in, int64_t count, int stride, float* out) {
    for (int64_t i = 0; i < count; ++i, in += 3, out += stride) {
        const uint32_t bits = in[0] | uint32_t{in[1]} << 8 | uint32_t{in[2]} << 16;
        *out = static_cast<float>(small_float(bits, 7, 16));
    }
}

/// Unsigned integers of any other width up to 16 bits, without gaps between them.
void packed(int bits, const uint8_t* in, int64_t count, int stride, float* out) {
    const uint32_t most = (1U << bits) - 1;
    uint32_t held = 0;
    int has = 0;
    for (int64_t i = 0; i < count; ++i, out += stride) {
        while (has < bits) {
            held = held << 8 | *in++;
            has += 8;
        }
        has -= bits;
        const uint32_t value = held >> has & most;
        // As eight bits, where they hold the same fraction.
        *out = 255 % most == 0 ? static_cast<float>(value * (255 / most)) * (1.0F / 255)
                               : static_cast<float>(static_cast<double>(value) / most);
    }
}

}  // namespace

bool knows_samples(const TiffDirectory& page) {
    switch (page.kind) {
        case Kind::kUnsigned:
            return (page.bits >= 1 && page.bits <= 16) || page.bits == 32 || page.bits == 64;
        case Kind::kSigned:
            return page.bits == 8 || page.bits == 16 || page.bits == 32 || page.bits == 64;
        case Kind::kFloat:
            break;
    }
    return page.bits == 16 || page.bits == 24 || page.bits == 32 || page.bits == 64;
}

void convert_samples(const TiffDirectory& page, Scale scale, const uint8_t* in, int64_t count,
                     int stride, float* out, bool* rounded) {
    const bool is_signed = page.kind == Kind::kSigned;
    if (page.kind == Kind::kFloat) {
        switch (page.bits) {
            case 16:
                return halves(in, count, stride, out);
            case 24:
                return floats24(in, count, stride, out);
            case 32:
                return floats<float>(in, count, stride, out);
            default:
                return floats<double>(in, count, stride, out);
        }
    }
    switch (page.bits) {
        case 8:
            return is_signed ? integers<int8_t>(scale, in, count, stride, out, rounded)
                             : integers<uint8_t>(scale, in, count, stride, out, rounded);
        case 16:
            return is_signed ? integers<int16_t>(scale, in, count, stride, out, rounded)
                             : integers<uint16_t>(scale, in, count, stride, out, rounded);
        case 32:
            return is_signed ? integers<int32_t>(scale, in, count, stride, out, rounded)
                             : integers<uint32_t>(scale, in, count, stride, out, rounded);
        case 64:
            return is_signed ? integers<int64_t>(scale, in, count, stride, out, rounded)
                             : integers<uint64_t>(scale, in, count, stride, out, rounded);
        default:
            return packed(page.bits, in, count, stride, out);
    }
}

}  // namespace openfab::tools
