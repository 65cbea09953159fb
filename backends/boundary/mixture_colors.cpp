// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/mixture_colors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/color.h"

namespace openfab::boundary {

namespace {

constexpr double kLeastLight = 0.063095734448;  // 10^-1.2

Rgba packed(uint32_t r, uint32_t g, uint32_t b, uint32_t a) {
    return r << 24 | g << 16 | b << 8 | a;
}

}  // namespace

MixtureColors::MixtureColors(const std::vector<pipeline::SliceMaterial>& materials) {
    for (const pipeline::SliceMaterial& material : materials) {
        const std::array<uint8_t, 4>& p = material.preview;
        pure_.push_back(packed(p[0], p[1], p[2], p[3]));
        Powers& powers = powers_.emplace_back();
        powers.alpha = p[3] / 255.0;
        for (size_t c = 0; c < 3; ++c) {
            double light = std::max(srgb_to_linear(p[c] / 255.0), kLeastLight);
            for (double& power : powers.of[c])
                power = light = std::sqrt(light);
        }
    }
}

Rgba MixtureColors::of(std::span<const float> fractions) const {
    double sum = 0;
    for (const float fraction : fractions)
        sum += double{fraction};
    if (!(sum > 0)) return 0;
    std::array<double, 3> light{1, 1, 1};
    double alpha = 0;
    for (size_t m = 0; m < fractions.size(); ++m) {
        if (!(fractions[m] > 0)) continue;
        const double share = double{fractions[m]} / sum;
        const auto bits = static_cast<uint32_t>(share * (1 << kBits) + 0.5);
        if (bits >= 1U << kBits) return pure_[m];
        alpha += share * powers_[m].alpha;
        for (size_t c = 0; c < 3; ++c) {
            for (size_t bit = 0; bit < kBits; ++bit) {
                if ((bits >> (kBits - 1 - bit) & 1) != 0) light[c] *= powers_[m].of[c][bit];
            }
        }
    }
    return packed(linear_to_srgb8(light[0]), linear_to_srgb8(light[1]), linear_to_srgb8(light[2]),
                  static_cast<uint32_t>(std::min(alpha, 1.0) * 255 + 0.5));
}

}  // namespace openfab::boundary
