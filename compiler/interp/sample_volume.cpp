// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/sample_volume.h"

#include <bit>
#include <cmath>

#include "compiler/interp/wrap.h"

namespace openfab::interp {

namespace {

// Copied from texture/pyramid.h; the interpreter includes no runtime code.
constexpr size_t kVolumeInfoHeader = 14;
constexpr size_t kVolumeInfoPerLevel = 5;
constexpr int32_t kFilterFinest = 3;

/// One channel of one volume.
class VolumeSampler {
  public:
    VolumeSampler(const TextureView& texture, int32_t channel)
        : texture_(texture), channel_(channel) {}

    float side(size_t axis) const { return static_cast<float>(info(0, 1 + axis)); }
    float origin(size_t axis) const { return std::bit_cast<float>(texture_.info[8 + axis]); }
    float extent(size_t axis) const { return std::bit_cast<float>(texture_.info[11 + axis]); }

    float nearest(const std::array<float, 3>& c) const {
        std::array<int32_t, 3> at{};
        for (size_t k = 0; k < 3; ++k)
            at[k] = static_cast<int32_t>(std::floor(wrap_coordinate(wrap(), c[k]) * side(k)));
        return texel(0, at);
    }

    float linear(int32_t level, const std::array<float, 3>& c) const {
        std::array<int32_t, 3> first{};
        std::array<float, 3> f{};
        for (size_t k = 0; k < 3; ++k) {
            const float x =
                wrap_coordinate(wrap(), c[k]) * static_cast<float>(info(level, 1 + k)) - 0.5f;
            f[k] = x - std::floor(x);
            first[k] = static_cast<int32_t>(std::floor(x));
        }
        std::array<float, 2> b{};
        for (int32_t z = 0; z < 2; ++z) {
            std::array<float, 2> a{};
            for (int32_t y = 0; y < 2; ++y) {
                const float t0 = texel(level, {first[0], first[1] + y, first[2] + z});
                const float t1 = texel(level, {first[0] + 1, first[1] + y, first[2] + z});
                a[y] = t0 + (t1 - t0) * f[0];
            }
            b[z] = a[0] + (a[1] - a[0]) * f[1];
        }
        return b[0] + (b[1] - b[0]) * f[2];
    }

  private:
    int32_t wrap() const { return texture_.info[2]; }
    int32_t info(int32_t level, size_t field) const {
        return texture_
            .info[kVolumeInfoHeader + static_cast<size_t>(level) * kVolumeInfoPerLevel + field];
    }

    float texel(int32_t level, const std::array<int32_t, 3>& at) const {
        int64_t index = 0;
        for (size_t k = 3; k-- > 0;) {
            const int32_t n = info(level, 1 + k);
            if (wrap() == kWrapBlack && (at[k] < 0 || at[k] >= n)) return 0.0f;
            index = index * n + wrap_texel(wrap(), at[k], n);
        }
        index = info(level, 0) + index * texture_.info[0] + channel_;
        return texture_.texels[index];
    }

    const TextureView& texture_;
    int32_t channel_;
};

float width_of(const VolumeSampler& sampler, const VolumeSampleArgs& args) {
    float widest = 0.0f;
    for (size_t j = 0; j < 3; ++j) {
        std::array<float, 3> t{};
        for (size_t k = 0; k < 3; ++k)
            t[k] = (args.dp[k][j] / sampler.extent(k)) * sampler.side(k);
        const float q = (t[0] * t[0] + t[1] * t[1]) + t[2] * t[2];
        widest = j == 0 || !(widest > q) ? q : widest;
    }
    return bound(std::sqrt(widest) * args.width, 0.0f, kMaxWidth);
}

}  // namespace

float sample_volume(const TextureView& texture, int32_t channel, const VolumeSampleArgs& args) {
    if (texture.info.empty() || texture.texels.empty() || texture.info[4] == 0) return 0.0f;
    const int32_t channels = texture.info[0];
    if (channel >= channels) {
        if (channels != 1 || channel >= 3) return channel == 3 ? 1.0f : 0.0f;
        channel = 0;
    }
    const VolumeSampler sampler(texture, channel);
    std::array<float, 3> c{};
    for (size_t k = 0; k < 3; ++k)
        c[k] = (args.p[k] - sampler.origin(k)) / sampler.extent(k);
    const int32_t filter = texture.info[3];
    if (filter == kFilterNearest) return sampler.nearest(c);

    const int32_t levels = texture.info[1];
    const float top = filter == kFilterFinest ? 0.0f : static_cast<float>(levels - 1);
    const float level = bound(log2_of(width_of(sampler, args)), 0.0f, top);
    const float whole = std::floor(level);
    const auto l0 = static_cast<int32_t>(whole);
    const int32_t l1 = l0 + 1 < levels ? l0 + 1 : levels - 1;
    const float lo = sampler.linear(l0, c);
    const float hi = sampler.linear(l1, c);
    return lo + (hi - lo) * (level - whole);
}

}  // namespace openfab::interp
