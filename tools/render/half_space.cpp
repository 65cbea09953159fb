// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/half_space.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/render/dielectric.h"

namespace openfab::render {

namespace {

constexpr size_t kSide = 32;        ///< directions that the surface reflects wholly, and others
constexpr size_t kAll = 2 * kSide;  ///< cosines of directions, at the middles of intervals
constexpr int kRounds = 100;        ///< 0.6 of what is left stays in each

/// The body without its surface.
class HalfSpace {
  public:
    HalfSpace(double albedo, double critical)
        : unabsorbed_(std::sqrt(1 - albedo)), half_(albedo / 2) {
        for (size_t i = 0; i < kSide; ++i) {
            const double middle = (static_cast<double>(i) + 0.5) / kSide;
            // Without a surface there are none, of width 0.
            cosine[i] = std::max(critical, 1e-6) * middle;
            width[i] = critical / kSide;
            cosine[kSide + i] = critical + (1 - critical) * middle;
            width[kSide + i] = (1 - critical) / kSide;
        }
        h_.fill(1);
        for (int round = 0; round < kRounds; ++round) {
            const std::array<double, kAll> last = h_;
            for (size_t i = 0; i < kAll; ++i)
                h_[i] = 0.5 * (last[i] + 1 / (unabsorbed_ + gathered(cosine[i], last)));
        }
    }

    /// What comes back at a cosine of light that has `radiance` by cosine.
    double reflected(double at, const std::array<double, kAll>& radiance) const {
        std::array<double, kAll> by{};
        for (size_t i = 0; i < kAll; ++i)
            by[i] = h_[i] * radiance[i];
        return gathered(at, by) / (unabsorbed_ + gathered(at, h_));
    }

    std::array<double, kAll> cosine{}, width{};

  private:
    double gathered(double at, const std::array<double, kAll>& of) const {
        double sum = 0;
        for (size_t i = 0; i < kAll; ++i)
            sum += width[i] * cosine[i] / (at + cosine[i]) * of[i];
        return half_ * sum;
    }

    double unabsorbed_, half_;
    std::array<double, kAll> h_{};
};

}  // namespace

double look_of_albedo(double albedo, double refractive_index) {
    const double n2 = refractive_index * refractive_index;
    const HalfSpace body(albedo, std::sqrt(1 - 1 / n2));
    std::array<double, kAll> sent_back{}, down{}, up{};
    double beyond = 0;
    for (size_t i = 0; i < kAll; ++i)
        sent_back[i] = fresnel(body.cosine[i], refractive_index, &beyond);
    for (int round = 0; round < kRounds; ++round) {
        for (size_t i = 0; i < kAll; ++i)
            down[i] = sent_back[i] * up[i] + (1 - sent_back[i]) * n2;
        for (size_t i = 0; i < kAll; ++i)
            up[i] = body.reflected(body.cosine[i], down);
    }
    const double at_surface = fresnel(1, 1 / refractive_index, &beyond);
    return at_surface + (1 - at_surface) / n2 * body.reflected(1, down);
}

double albedo_of_look(double look, double refractive_index) {
    double low = 0;
    double high = 1;
    while (high - low > 1e-5) {
        const double middle = 0.5 * (low + high);
        (look_of_albedo(middle, refractive_index) < look ? low : high) = middle;
    }
    return look <= look_of_albedo(0, refractive_index) ? 0 : look >= 1 ? 1 : 0.5 * (low + high);
}

}  // namespace openfab::render
