// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/sample.h"

#include <bit>
#include <cmath>

#include "compiler/interp/wrap.h"
#include "compiler/ir/ir.h"

namespace openfab::interp {

namespace {

// Copied from texture/pyramid.h; the interpreter includes no runtime code.
constexpr size_t kInfoHeader = 8;
constexpr size_t kInfoPerLevel = 4;
constexpr size_t kInfoWrapV = 5;
constexpr size_t kInfoAlpha = 6;

constexpr float kMaxSquare = 1152921504606846976.0f;  // 2^60
constexpr float kMaxTaps = 8.0f;

struct Footprint {
    float major = 0;
    float minor = 0;
    float ax = 1;  ///< unit direction of the major axis, in texels of level 0
    float ay = 0;
};

Footprint footprint_of(const SampleArgs& args, float w0, float h0) {
    std::array<float, 3> sx{};
    std::array<float, 3> sy{};
    for (size_t k = 0; k < 3; ++k) {
        sx[k] = args.du[k] * w0;
        sy[k] = args.dv[k] * h0;
    }
    const float a = (sx[0] * sx[0] + sx[1] * sx[1]) + sx[2] * sx[2];
    const float b = (sx[0] * sy[0] + sx[1] * sy[1]) + sx[2] * sy[2];
    const float c = (sy[0] * sy[0] + sy[1] * sy[1]) + sy[2] * sy[2];
    const float m = (a + c) * 0.5f;
    const float d = (a - c) * 0.5f;
    const float r = std::sqrt(d * d + b * b);
    Footprint out;
    out.major = bound(std::sqrt(m + r) * args.width, 0.0f, kMaxWidth);
    out.minor = bound(std::sqrt(bound(m - r, 0.0f, kMaxSquare)) * args.width, 0.0f, kMaxWidth);
    const float ex = d >= 0.0f ? d + r : b;
    const float ey = d >= 0.0f ? b : r - d;
    const float e = std::sqrt(ex * ex + ey * ey);
    if (e > 0.0f && e < kMaxSquare) {
        out.ax = ex / e;
        out.ay = ey / e;
    }
    return out;
}

/// One channel of one pyramid.
class Sampler {
  public:
    Sampler(const TextureView& texture, int32_t channel)
        : texture_(texture),
          channels_(texture.info[0]),
          levels_(texture.info[1]),
          wrap_u_(texture.info[2]),
          wrap_v_(texture.info[kInfoWrapV]),
          channel_(channel),
          outside_(texture.info[kInfoAlpha] != 0 && channel < channels_ - 1 ? 1.0f : 0.0f) {}

    int32_t width(int32_t level) const { return info(level, 1); }
    int32_t height(int32_t level) const { return info(level, 2); }

    float nearest(float u, float v) const {
        const float x = std::floor(wrap_coordinate(wrap_u_, u) * static_cast<float>(width(0)));
        const float y = std::floor(wrap_coordinate(wrap_v_, v) * static_cast<float>(height(0)));
        return texel(0, static_cast<int32_t>(x), static_cast<int32_t>(y));
    }

    float trilinear(float u, float v, float level) const {
        const float whole = std::floor(level);
        const auto l0 = static_cast<int32_t>(whole);
        const int32_t l1 = l0 + 1 < levels_ ? l0 + 1 : levels_ - 1;
        const float lo = bilinear(l0, u, v);
        const float hi = bilinear(l1, u, v);
        return lo + (hi - lo) * (level - whole);
    }

  private:
    int32_t info(int32_t level, size_t field) const {
        return texture_.info[kInfoHeader + static_cast<size_t>(level) * kInfoPerLevel + field];
    }

    float bilinear(int32_t level, float u, float v) const {
        const float x = wrap_coordinate(wrap_u_, u) * static_cast<float>(width(level)) - 0.5f;
        const float y = wrap_coordinate(wrap_v_, v) * static_cast<float>(height(level)) - 0.5f;
        const float fx = x - std::floor(x);
        const float fy = y - std::floor(y);
        const auto x0 = static_cast<int32_t>(std::floor(x));
        const auto y0 = static_cast<int32_t>(std::floor(y));
        const float t00 = texel(level, x0, y0);
        const float t01 = texel(level, x0, y0 + 1);
        const float t0 = t00 + (texel(level, x0 + 1, y0) - t00) * fx;
        const float t1 = t01 + (texel(level, x0 + 1, y0 + 1) - t01) * fx;
        return t0 + (t1 - t0) * fy;
    }

    float texel(int32_t level, int32_t x, int32_t y) const {
        const int32_t w = width(level);
        const int32_t h = height(level);
        if (wrap_u_ == kWrapBlack && (x < 0 || x >= w)) return outside_;
        if (wrap_v_ == kWrapBlack && (y < 0 || y >= h)) return outside_;
        if (channel_ == channels_) return 1.0f;
        const int64_t row =
            static_cast<int64_t>(wrap_texel(wrap_v_, y, h)) * w + wrap_texel(wrap_u_, x, w);
        return texture_.texels[static_cast<size_t>(info(level, 0) + row * channels_ + channel_)];
    }

    const TextureView& texture_;
    int32_t channels_;
    int32_t levels_;
    int32_t wrap_u_, wrap_v_;
    int32_t channel_;  ///< channels_ for coverage
    float outside_;    ///< the value of a texel that is not there
};

/// Looks up one of the pyramid's own channels, or coverage.
float stored(const TextureView& texture, int32_t channel, const SampleArgs& args) {
    const Sampler sampler(texture, channel);
    const int32_t filter = texture.info[3];
    if (filter == kFilterNearest) return sampler.nearest(args.u, args.v);

    const auto w0 = static_cast<float>(sampler.width(0));
    const auto h0 = static_cast<float>(sampler.height(0));
    const Footprint print = footprint_of(args, w0, h0);
    float wide = print.major;
    float taps = 1.0f;
    if (filter != kFilterTrilinear) {
        const float low = print.major * 0.125f;
        wide = print.minor > low ? print.minor : low;
        taps = bound(std::ceil(print.major / (wide > 1.0f ? wide : 1.0f)), 1.0f, kMaxTaps);
    }
    const float level = bound(log2_of(wide), 0.0f, static_cast<float>(texture.info[1] - 1));
    float sum = 0.0f;
    for (float i = 0.0f; i < taps; i += 1.0f) {
        const float t = ((i + 0.5f) / taps - 0.5f) * print.major;
        const float u = args.u + (t * print.ax) / w0;
        const float v = args.v + (t * print.ay) / h0;
        sum = sum + sampler.trilinear(u, v, level);
    }
    return sum / taps;
}

}  // namespace

float log2_of(float x) {
    if (!(x >= 1.0f)) return 0.0f;
    const auto bits = std::bit_cast<uint32_t>(x);
    const auto e = static_cast<float>(static_cast<int32_t>(bits >> 23) - 127);
    const float f = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u) - 1.0f;
    const float q = ((kLog2Q3 * f + kLog2Q2) * f + kLog2Q1) * f + kLog2Q0;
    return e + (f + (f * (1.0f - f)) * q);
}

float sample(const TextureView& texture, int32_t channel, const SampleArgs& args) {
    if (texture.info.empty() || texture.texels.empty()) return 0.0f;
    const bool has_alpha = texture.info[kInfoAlpha] != 0;
    const int32_t colors = texture.info[0] - (has_alpha ? 1 : 0);
    const bool black = texture.info[2] == kWrapBlack || texture.info[kInfoWrapV] == kWrapBlack;
    const bool covers = !has_alpha && colors <= 3 && black;
    const bool own = channel >= ir::kOwnColor && channel < ir::kOwnColor + 3;
    if (own) channel -= ir::kOwnColor;
    if (channel >= colors) {
        if (channel == 3) return has_alpha || covers ? stored(texture, colors, args) : 1.0f;
        if (colors != 1 || channel > 3) return 0.0f;
        channel = 0;
    }
    const float value = stored(texture, channel, args);
    if (!own || !(has_alpha || covers)) return value;
    const float alpha = stored(texture, colors, args);
    if (!(alpha > 0.0f)) return 0.0f;
    return (has_alpha ? value - (1.0f - alpha) : value) / alpha;
}

}  // namespace openfab::interp
