// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/png_color.h"

#include <string_view>

namespace openfab::tools {
namespace {

/// Behind the signature.
constexpr int64_t kFirst = 8;
/// Of length and type, and of the checksum behind the data.
constexpr int64_t kHead = 8, kTail = 4;
/// Chunks before the pixels; files that have more say nothing of their colours.
constexpr int kMostChunks = 65536;
/// The longest of the chunks that are read.
constexpr size_t kLongest = 32;

uint32_t number_at(const uint8_t* bytes) {
    return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 | bytes[3];
}

void take(std::string_view type, const uint8_t* data, size_t length, PngColor* color) {
    constexpr double kUnit = 1e-5;
    if (type == "cICP" && length == 4) {
        color->code_points = {data[0], data[1], data[2], data[3]};
    } else if (type == "sRGB" && length == 1) {
        color->is_srgb = true;
    } else if (type == "gAMA" && length == 4) {
        const uint32_t value = number_at(data);
        // Beyond these it is a mistake (libpng's own limits).
        if (value >= 16 && value <= 625'000'000) color->gamma = value * kUnit;
    } else if (type == "cHRM" && length == kLongest) {
        // White comes first.
        Chromaticities c{};
        for (size_t k = 0; k < c.size(); ++k)
            c[(k + 6) % 8] = number_at(data + 4 * k) * kUnit;
        color->corners = c;
    }
}

/// Primaries of H.273; nothing for others than are in use.
std::optional<Chromaticities> primaries_of(uint8_t code) {
    constexpr double kD65x = 0.3127, kD65y = 0.3290;
    switch (code) {
        case 1:
            return kSrgbChromaticities;
        case 5:
            return Chromaticities{0.64, 0.33, 0.29, 0.60, 0.15, 0.06, kD65x, kD65y};
        case 6:
        case 7:
            return Chromaticities{0.630, 0.340, 0.310, 0.595, 0.155, 0.070, kD65x, kD65y};
        case 9:
            return Chromaticities{0.708, 0.292, 0.170, 0.797, 0.131, 0.046, kD65x, kD65y};
        case 11:
            return Chromaticities{0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.314, 0.351};
        case 12:
            return Chromaticities{0.680, 0.320, 0.265, 0.690, 0.150, 0.060, kD65x, kD65y};
        default:
            return std::nullopt;
    }
}

}  // namespace

PngColor read_png_color(const InputFile& file) {
    PngColor color;
    int64_t at = kFirst;
    for (int k = 0; k < kMostChunks; ++k) {
        std::array<uint8_t, kHead + kLongest> chunk{};
        const Result<size_t> got = file.read(at, chunk.data(), chunk.size());
        if (!got || *got < kHead) return color;
        const int64_t length = number_at(chunk.data());
        const std::string_view type(reinterpret_cast<const char*>(chunk.data()) + 4, 4);
        if (type == "IDAT" || type == "IEND") return color;
        if (length > file.bytes() - at - kHead - kTail) return color;
        if (type == "iCCP") {
            color.profile_at = at + kHead;
            color.profile_bytes = length;
        }
        take(type, chunk.data() + kHead, static_cast<size_t>(length), &color);
        at += kHead + length + kTail;
    }
    return {};
}

std::optional<RgbSpace> space_of(const std::array<uint8_t, 4>& code_points) {
    constexpr double kTelevision = 2.2, kOldTelevision = 2.8;
    const std::optional<Chromaticities> primaries = primaries_of(code_points[0]);
    const bool full_range_rgb = code_points[2] == 0 && code_points[3] == 1;
    if (!primaries || !full_range_rgb) return std::nullopt;
    switch (code_points[1]) {
        case 1:
        case 6:
        case 14:
        case 15:
            return RgbSpace::make(*primaries, Curve::kRec709);
        case 4:
            return RgbSpace::make(*primaries, Curve::kPower, kTelevision);
        case 5:
            return RgbSpace::make(*primaries, Curve::kPower, kOldTelevision);
        case 8:
            return RgbSpace::make(*primaries, Curve::kLinear);
        case 13:
            return RgbSpace::make(*primaries, Curve::kSrgb);
        default:
            return std::nullopt;  // among them the brightness of screens, PQ and HLG
    }
}

}  // namespace openfab::tools
