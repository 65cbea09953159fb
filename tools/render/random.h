// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random numbers of a path, a pure function of seed, pixel and sample: a picture does not depend on
// which thread traces which pixel. Everything is + - * / and square roots, without libm, so that it
// does not depend on the machine either.

#include <bit>
#include <cmath>
#include <cstdint>

#include "base/vec.h"

namespace openfab::render {

/// Returns the natural logarithm of a positive normal number; relative error below 1e-12.
inline double natural_log(double x) {
    constexpr double kLog2 = 0.69314718055994530942;
    constexpr double kSqrt2 = 1.41421356237309504880;
    const auto bits = std::bit_cast<uint64_t>(x);
    auto exponent = static_cast<int64_t>(bits >> 52) - 1023;
    auto m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
    if (m > kSqrt2) {
        m *= 0.5;
        ++exponent;
    }
    // log m = 2 artanh s, |s| < 0.172
    const double s = (m - 1) / (m + 1);
    const double z = s * s;
    const double series =
        1 + z * (1.0 / 3 + z * (1.0 / 5 + z * (1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 + z / 13)))));
    return static_cast<double>(exponent) * kLog2 + 2 * s * series;
}

class Random {
  public:
    /// The stream of one sample of one pixel.
    Random(uint64_t seed, uint64_t pixel, uint64_t sample)
        : state_(mix(mix(mix(seed) ^ pixel) ^ sample)) {}

    /// Uniform in (0, 1): never 0, so that its logarithm is finite.
    double uniform() {
        state_ += 0x9e3779b97f4a7c15ULL;
        return (static_cast<double>(mix(state_) >> 12) + 0.5) * 0x1p-52;
    }
    /// Exponential with mean 1.
    double exponential() { return -natural_log(uniform()); }

    /// Uniform cosine and sine of an azimuth (von Neumann's way, which needs no trigonometry).
    void azimuth(double* cosine, double* sine) {
        for (;;) {
            const double x = 2 * uniform() - 1;
            const double y = 2 * uniform() - 1;
            const double squared = x * x + y * y;
            if (squared > 1 || squared < 1e-12) continue;
            *cosine = (x * x - y * y) / squared;
            *sine = 2 * x * y / squared;
            return;
        }
    }
    /// A direction at angle `cosine` to `axis`, which is a unit vector.
    Vec3d around(const Vec3d& axis, double cosine);
    Vec3d on_sphere() {
        double c = 0, s = 0;
        azimuth(&c, &s);
        const double z = 2 * uniform() - 1;
        const double r = std::sqrt(std::max(0.0, 1 - z * z));
        return {r * c, r * s, z};
    }

  private:
    /// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
    static uint64_t mix(uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
        return x ^ (x >> 31);
    }

    uint64_t state_;
};

/// Sets `a` and `b` so that they and the unit vector `n` are an orthonormal frame (Duff et al. 2017).
inline void make_frame(const Vec3d& n, Vec3d* a, Vec3d* b) {
    const double sign = n.z >= 0 ? 1.0 : -1.0;
    const double u = -1 / (sign + n.z);
    const double v = n.x * n.y * u;
    *a = {1 + sign * n.x * n.x * u, sign * v, -sign * n.x};
    *b = {v, sign + n.y * n.y * u, -n.y};
}

inline Vec3d normalized(const Vec3d& v) {
    return v * (1 / length(v));
}

inline Vec3d Random::around(const Vec3d& axis, double cosine) {
    double c = 0, s = 0;
    azimuth(&c, &s);
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    Vec3d a, b;
    make_frame(axis, &a, &b);
    // Rounding errors of thousands of turns would add up.
    return normalized(axis * cosine + a * (sine * c) + b * (sine * s));
}

}  // namespace openfab::render
