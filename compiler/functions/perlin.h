// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Gradient noise on the integer lattice (Perlin, "Improving Noise", SIGGRAPH 2002): quintic fades,
// one gradient for each lattice point, by a hash of its coordinates instead of a table of 256. The
// value is 0 at lattice points and lies in [-1, 1] for every finite point; scale factors are those
// of tests/unit/functions, which bounds the largest value over a cell by branch and bound. Lattice
// points are distinct for |x| < 2^22.

#include <array>
#include <cstddef>

#include "compiler/functions/exponential.h"
#include "compiler/functions/hash.h"

namespace openfab::functions {

// Odd multipliers whose lattice of collisions modulo 2^32 has no short vector.
inline constexpr std::array<uint32_t, 3> kAxisFactors = {0x9e3779b1u, 0x85ebca77u, 0xc2b2ae3du};

/// A coordinate as the lattice points on both sides and the fraction between them, in [0, 1].
template <typename M>
struct Cell {
    std::array<typename M::U, 2> corner;  ///< only equality matters
    typename M::F t;
};

template <typename M>
typename M::U lattice_key(typename M::F whole) {
    return M::bits(whole + kRounder);
}

template <typename M>
Cell<M> cell_of(typename M::F x) {
    const typename M::F below = M::floor(x);
    const typename M::U key = lattice_key<M>(below);
    return {{key, key + 1u}, x - below};
}

/// Identifies lattice points that are `period` apart; the period is clamped to [1, 2^22].
template <typename M>
Cell<M> cell_of(typename M::F x, typename M::I period) {
    using F = typename M::F;
    const F below = M::floor(x);
    F p = M::to_float(period);
    p = M::select(p > 1.5f, p, 1.0f);
    p = M::select(p > 0x1p22f, 0x1p22f, p);
    // A quotient of integers below 2^24 is never rounded up to the next integer.
    const F first = below - M::floor(below / p) * p;
    const F next = first + 1.0f;
    const F second = M::select(next > p - 0.5f, 0.0f, next);
    return {{lattice_key<M>(first), lattice_key<M>(second)}, x - below};
}

template <typename M>
typename M::F flip(typename M::F x, typename M::U sign) {
    if constexpr (std::is_same_v<M, Wide>) {
        return sign == 0 ? x : -x;
    } else {
        return M::from_bits(M::bits(x) ^ sign);
    }
}

template <typename M>
typename M::B has_none(typename M::U bits, uint32_t mask) {
    return (bits & mask) == 0u;
}

/// Signs taken from bits 27, 26 and 25 of a hash.
template <typename M>
std::array<typename M::U, 3> signs_of(typename M::U h) {
    return {(h << 4u) & kSignBit, (h << 5u) & kSignBit, (h << 6u) & kSignBit};
}

inline constexpr float kTanPiEighth = 0.414213562f;

// The gradient that a hash chooses, as a dot product with d and in components:
//   1 axis   a number in [-1, 1)
//   2 axes   8 directions, 45 degrees apart, off the axes and diagonals
//   3 axes   from the middle of a cube to its 12 edges
//   4 axes   to the 32 edges' counterparts: three of four components +-1
template <typename M>
typename M::F gradient_dot(typename M::U h, const std::array<typename M::F, 1>& d) {
    return M::to_float(M::as_int(M::shift_down(h, 8u))) * 0x1p-23f * d[0];
}
template <typename M>
std::array<typename M::F, 1> gradient(typename M::U h, const std::array<typename M::F, 1>&) {
    return {M::to_float(M::as_int(M::shift_down(h, 8u))) * 0x1p-23f};
}

template <typename M>
typename M::F gradient_dot(typename M::U h, const std::array<typename M::F, 2>& d) {
    using F = typename M::F;
    const typename M::B x_first = has_none<M>(h, 0x80000000u);
    const auto sign = signs_of<M>(h);
    const F major = M::select(x_first, d[0], d[1]);
    const F minor = M::select(x_first, d[1], d[0]) * kTanPiEighth;
    return flip<M>(major, sign[0]) + flip<M>(minor, sign[1]);
}
template <typename M>
std::array<typename M::F, 2> gradient(typename M::U h, const std::array<typename M::F, 2>& d) {
    using F = typename M::F;
    const typename M::B x_first = has_none<M>(h, 0x80000000u);
    const auto sign = signs_of<M>(h);
    const F major = flip<M>(M::constant(d[0], 1.0f), sign[0]);
    const F minor = flip<M>(M::constant(d[0], kTanPiEighth), sign[1]);
    return {M::select(x_first, major, minor), M::select(x_first, minor, major)};
}

/// Selects the nonzero components: the first is x or y, the second y, z or x.
template <typename M>
struct EdgeChoice {
    typename M::B first_is_x;
    typename M::B second_is_y;
    typename M::B second_is_x;
};
template <typename M>
EdgeChoice<M> edge_choice(typename M::U h) {
    return {has_none<M>(h, 0x80000000u), has_none<M>(h, 0xc0000000u),
            (h & 0xd0000000u) == 0xc0000000u};
}

template <typename M>
typename M::F gradient_dot(typename M::U h, const std::array<typename M::F, 3>& d) {
    using F = typename M::F;
    const EdgeChoice<M> edge = edge_choice<M>(h);
    const auto sign = signs_of<M>(h);
    const F first = M::select(edge.first_is_x, d[0], d[1]);
    const F second = M::select(edge.second_is_y, d[1], M::select(edge.second_is_x, d[0], d[2]));
    return flip<M>(first, sign[0]) + flip<M>(second, sign[1]);
}
template <typename M>
std::array<typename M::F, 3> gradient(typename M::U h, const std::array<typename M::F, 3>& d) {
    using F = typename M::F;
    const EdgeChoice<M> edge = edge_choice<M>(h);
    const auto sign = signs_of<M>(h);
    const F first = flip<M>(M::constant(d[0], 1.0f), sign[0]);
    const F second = flip<M>(M::constant(d[0], 1.0f), sign[1]);
    const F zero = M::constant(d[0], 0.0f);
    return {M::select(edge.first_is_x, first, M::select(edge.second_is_x, second, zero)),
            M::select(edge.second_is_y, second, M::select(edge.first_is_x, zero, first)),
            M::select(edge.second_is_y | edge.second_is_x, zero, second)};
}

template <typename M>
typename M::F gradient_dot(typename M::U h, const std::array<typename M::F, 4>& d) {
    using F = typename M::F;
    const typename M::B high = has_none<M>(h, 0x80000000u);
    const typename M::B low = has_none<M>(h, 0x40000000u);
    const auto sign = signs_of<M>(h);
    // The zero component: x, y, z or w.
    const F a = M::select(high & low, d[1], d[0]);
    const F b = M::select(high, d[2], d[1]);
    const F c = M::select(high | low, d[3], d[2]);
    return (flip<M>(a, sign[0]) + flip<M>(b, sign[1])) + flip<M>(c, sign[2]);
}
template <typename M>
std::array<typename M::F, 4> gradient(typename M::U h, const std::array<typename M::F, 4>& d) {
    using F = typename M::F;
    const typename M::B high = has_none<M>(h, 0x80000000u);
    const typename M::B low = has_none<M>(h, 0x40000000u);
    const auto sign = signs_of<M>(h);
    const F one = M::constant(d[0], 1.0f);
    const F zero = M::constant(d[0], 0.0f);
    const F a = flip<M>(one, sign[0]);
    const F b = flip<M>(one, sign[1]);
    const F c = flip<M>(one, sign[2]);
    return {M::select(high & low, zero, a), M::select(high, M::select(low, a, zero), b),
            M::select(high, b, M::select(low, zero, c)), M::select(high | low, c, zero)};
}

inline constexpr std::array<float, 4> kPerlinScales = {1.999998f, 1.39f, 0.96f, 0.647f};

/// A value with its derivatives, none where only the value is asked for.
template <typename M, size_t kAxes>
struct Dual {
    typename M::F value;
    std::array<typename M::F, kAxes> d;
    bool has_d = false;
};

template <typename M, size_t kAxes>
class PerlinNoise {
  public:
    using F = typename M::F;
    using U = typename M::U;
    using Value = Dual<M, kAxes>;

    /// `which`: 0 the value, k its derivative along axis k - 1.
    static F result(const std::array<Cell<M>, kAxes>& cells, U seed, int32_t which) {
        return keyed(cells, seed_key<M>(seed), which);
    }

    /// Same for a seed's key.
    static F keyed(const std::array<Cell<M>, kAxes>& cells, U key, int32_t which) {
        const PerlinNoise noise(cells, key, which != 0);
        const Value value = noise.along(kAxes - 1, 0);
        const F out = which == 0 ? value.value : value.d[which - 1];
        return out * kPerlinScales[kAxes - 1];
    }

  private:
    PerlinNoise(const std::array<Cell<M>, kAxes>& cells, U key, bool derivatives)
        : cells_(cells), derivatives_(derivatives) {
        for (size_t side = 0; side < 2; ++side)
            first_[side] = mix<M>(cells[0].corner[side] ^ key);
        for (size_t axis = 0; axis < kAxes; ++axis) {
            const F t = cells[axis].t;
            fades_[axis] = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
            if (derivatives) slopes_[axis] = t * t * (t * (t - 2.0f) + 1.0f) * 30.0f;
            from_[axis] = {t, t - 1.0f};
            if (axis == 0) continue;
            const uint32_t factor = kAxisFactors[axis - 1];
            const std::array<U, 2>& corner = cells[axis].corner;
            products_[axis] = {corner[0] * factor, corner[1] * factor};
        }
    }

    /// Interpolates along axes 0 to `axis`; higher bits of `corner` give the sides of the other
    /// axes.
    Value along(size_t axis, uint32_t corner) const {
        const uint32_t bit = 1u << axis;
        const Value a = axis == 0 ? at(corner) : along(axis - 1, corner);
        const Value b = axis == 0 ? at(corner | bit) : along(axis - 1, corner | bit);
        const F fade = fades_[axis];
        const F rise = b.value - a.value;
        Value out{a.value + fade * rise, a.d};
        for (size_t k = 0; derivatives_ && k < kAxes; ++k) {
            out.d[k] = a.d[k] + fade * (b.d[k] - a.d[k]);
            if (k == axis) out.d[k] = out.d[k] + slopes_[axis] * rise;
        }
        return out;
    }

    /// The ramp of one corner.
    Value at(uint32_t corner) const {
        U sum = first_[corner & 1u];
        std::array<F, kAxes> d;
        for (size_t axis = 0; axis < kAxes; ++axis) {
            const size_t side = (corner >> axis) & 1u;
            d[axis] = from_[axis][side];
            if (axis > 0) sum = sum + products_[axis][side];
        }
        const U h = kAxes == 1 ? sum : mix_high<M>(sum);
        Value out{gradient_dot<M>(h, d), d};
        if (derivatives_) out.d = gradient<M>(h, d);
        return out;
    }

    const std::array<Cell<M>, kAxes>& cells_;
    bool derivatives_;
    std::array<U, 2> first_;                        ///< hash of the first axis, by side
    std::array<std::array<U, 2>, kAxes> products_;  ///< of the other axes, by side
    std::array<F, kAxes> fades_;
    std::array<F, kAxes> slopes_;
    std::array<std::array<F, 2>, kAxes> from_;  ///< offset from each side
};

}  // namespace openfab::functions
