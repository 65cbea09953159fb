// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random numbers of a path, a pure function of seed, pixel and sample: a picture does not depend on
// which thread traces which pixel. Everything is + - * / and square roots, without libm, so that it
// does not depend on the machine either.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/vec.h"

namespace openfab::render {

class Random {
  public:
    /// The stream of one sample of one pixel.
    Random(uint64_t seed, uint64_t pixel, uint64_t sample) {
        uint64_t key = mix(mix(mix(seed) ^ pixel) ^ sample);
        for (size_t i = 0; i < 4; i += 2) {
            key += 0x9e3779b97f4a7c15ULL;
            const uint64_t two = mix(key);
            state[i] = static_cast<uint32_t>(two);
            state[i + 1] = static_cast<uint32_t>(two >> 32);
        }
    }

    /// All bits are random: xoshiro128++ (Blackman and Vigna 2021), as lanes of paths have it, too (flights.inl).
    uint32_t bits() {
        std::array<uint32_t, 4>& s = state;
        const uint32_t out = std::rotl(s[0] + s[3], 7) + s[0];
        const uint32_t t = s[1] << 9;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = std::rotl(s[3], 11);
        return out;
    }
    /// Uniform in (0, 1).
    double uniform() { return (bits() + 0.5) * 0x1p-32; }

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

    std::array<uint32_t, 4> state;

  private:
    /// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
    static uint64_t mix(uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
        return x ^ (x >> 31);
    }
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
