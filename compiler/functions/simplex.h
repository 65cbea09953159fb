// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Simplex noise (Perlin, "Noise hardware", SIGGRAPH 2001 course notes): a sum over the corners of
// the simplex around a point, of 2 to 4 axes. The kernel has the radius sqrt(1/2), so that it is 0
// at every face that does not touch its corner: value and gradient are continuous. Gradients,
// hashes and the meaning of 2^22 are those of perlin.h, scale factors from the same test.

#include "compiler/functions/perlin.h"

namespace openfab::functions {

inline constexpr std::array<float, 5> kSkews = {0.0f, 0.0f, 0.366025404f, 0.333333333f,
                                                0.309016994f};
inline constexpr std::array<float, 5> kUnskews = {0.0f, 0.0f, 0.211324865f, 0.166666667f,
                                                  0.138196601f};
inline constexpr std::array<float, 5> kSimplexScales = {0.0f, 0.0f, 92.4f, 76.8f, 62.7f};

template <typename M, size_t kAxes>
class SimplexNoise {
  public:
    using F = typename M::F;
    using U = typename M::U;
    using Vector = std::array<F, kAxes>;

    /// `which`: 0 the value, k its derivative along axis k - 1.
    static F result(const Vector& p, U seed, int32_t which) {
        return SimplexNoise(p, seed).sum(which) * kSimplexScales[kAxes];
    }

  private:
    SimplexNoise(const Vector& p, U seed) {
        F total = p[0];
        for (size_t k = 1; k < kAxes; ++k)
            total = total + p[k];
        const F skew = total * kSkews[kAxes];
        Vector cell;
        for (size_t k = 0; k < kAxes; ++k) {
            cell[k] = M::floor(p[k] + skew);
            total = k == 0 ? cell[0] : total + cell[k];
        }
        const F back = total * kUnskews[kAxes];
        for (size_t k = 0; k < kAxes; ++k) {
            from_[k] = (p[k] - cell[k]) + back;
            key_[k] = lattice_key<M>(cell[k]);
        }
        // The rank of each component: corners are visited along the greatest first.
        for (size_t k = 0; k < kAxes; ++k)
            rank_[k] = M::constant(p[0], 0.0f);
        for (size_t j = 0; j < kAxes; ++j) {
            for (size_t k = j + 1; k < kAxes; ++k) {
                const typename M::B greater = from_[j] > from_[k];
                rank_[j] = rank_[j] + M::select(greater, 1.0f, 0.0f);
                rank_[k] = rank_[k] + M::select(greater, 0.0f, 1.0f);
            }
        }
        const U seed_hash = seed_key<M>(seed);
        first_[0] = mix<M>(key_[0] ^ seed_hash);
        first_[1] = mix<M>((key_[0] + 1u) ^ seed_hash);
        for (size_t k = 1; k < kAxes; ++k)
            product_[k] = key_[k] * kAxisFactors[k - 1];
    }

    F sum(int32_t which) const {
        F out = corner(0, which);
        for (size_t m = 1; m <= kAxes; ++m)
            out = out + corner(m, which);
        return out;
    }

    F corner(size_t number, int32_t which) const {
        Vector d = from_;
        U state = first_[0];
        for (size_t k = 0; k < kAxes; ++k) {
            typename M::B stepped = rank_[k] > static_cast<float>(kAxes - number) - 0.5f;
            const bool all = number == kAxes;
            const F step = number == 0 ? M::constant(d[0], 0.0f)
                           : all       ? M::constant(d[0], 1.0f)
                                       : M::select(stepped, 1.0f, 0.0f);
            d[k] = (from_[k] - step) + static_cast<float>(number) * kUnskews[kAxes];
            if (number == 0) {
                state = k == 0 ? first_[0] : state + product_[k];
            } else if (k == 0) {
                state = all ? first_[1] : M::select(stepped, first_[1], first_[0]);
            } else {
                const uint32_t factor = kAxisFactors[k - 1];
                const U extra =
                    all ? product_[k] + factor : product_[k] + M::select(stepped, factor, 0u);
                state = state + extra;
            }
        }
        const U h = mix_high<M>(state);
        F square = d[0] * d[0];
        for (size_t k = 1; k < kAxes; ++k)
            square = square + d[k] * d[k];
        const F a = M::select(square < 0.5f, 0.5f - square, 0.0f);
        const F a2 = a * a;
        const F ramp = gradient_dot<M>(h, d);
        if (which == 0) return a2 * a2 * ramp;
        const auto axis = static_cast<size_t>(which - 1);
        return a2 * (a2 * gradient<M>(h, d)[axis] - a * d[axis] * 8.0f * ramp);
    }

    Vector from_;
    Vector rank_;
    std::array<U, kAxes> key_;
    std::array<U, 2> first_;
    std::array<U, kAxes> product_;
};

}  // namespace openfab::functions
