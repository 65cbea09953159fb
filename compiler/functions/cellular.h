// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cellular noise (Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996) of 2 or 3 axes: one
// point in each unit cell, anywhere in it. The 3 x 3 (x 3) surrounding cells are searched; they
// contain every point nearer than 1, so distances clamped to 1 are exact and continuous.

#include "compiler/functions/perlin.h"

namespace openfab::functions {

enum class CellularResult : int32_t { kNearest, kSecond, kCell };

template <typename M>
std::array<typename M::F, 2> point_in_cell(typename M::U h, const std::array<typename M::F, 2>&) {
    return {M::to_float(M::as_int(h & 0xffffu)) * 0x1p-16f,
            M::to_float(M::as_int(h >> 16u)) * 0x1p-16f};
}
template <typename M>
std::array<typename M::F, 3> point_in_cell(typename M::U h, const std::array<typename M::F, 3>&) {
    return {M::to_float(M::as_int(h & 0x7ffu)) * 0x1p-11f,
            M::to_float(M::as_int((h >> 11u) & 0x7ffu)) * 0x1p-11f,
            M::to_float(M::as_int(h >> 22u)) * 0x1p-10f};
}

template <typename M, size_t kAxes>
typename M::F cellular(const std::array<typename M::F, kAxes>& p, typename M::U seed,
                       CellularResult which) {
    using F = typename M::F;
    using U = typename M::U;
    std::array<std::array<U, 3>, kAxes> keys;
    std::array<F, kAxes> t;
    const U key = seed_key<M>(seed);
    for (size_t k = 0; k < kAxes; ++k) {
        const Cell<M> cell = cell_of<M>(p[k]);
        t[k] = cell.t;
        for (uint32_t side = 0; side < 3; ++side) {
            const U here = cell.corner[0] + (side - 1u);
            keys[k][side] = k == 0 ? mix<M>(here ^ key) : here * kAxisFactors[k - 1];
        }
    }
    F nearest = M::constant(p[0], 16.0f);
    F second = nearest;
    U owner = key;
    const uint32_t cells = kAxes == 2 ? 9 : 27;
    for (uint32_t number = 0; number < cells; ++number) {
        uint32_t rest = number;
        U state = key;
        std::array<F, kAxes> d;
        for (size_t k = 0; k < kAxes; ++k, rest /= 3) {
            const uint32_t side = rest % 3;
            state = k == 0 ? keys[0][side] : state + keys[k][side];
            d[k] = (static_cast<float>(side) - 1.0f) - t[k];
        }
        const U h = mix<M>(state);
        const std::array<F, kAxes> at = point_in_cell<M>(h, d);
        F square = (d[0] + at[0]) * (d[0] + at[0]);
        for (size_t k = 1; k < kAxes; ++k)
            square = square + (d[k] + at[k]) * (d[k] + at[k]);
        const typename M::B closer = square < nearest;
        const F loser = M::select(closer, nearest, square);
        second = M::select(loser < second, loser, second);
        nearest = M::select(closer, square, nearest);
        owner = M::select(closer, h, owner);
    }
    if (which == CellularResult::kCell) {
        return M::to_float(M::as_int(mix<M>(owner + 0x9e3779b9u) >> 8u)) * 0x1p-24f;
    }
    const F square = which == CellularResult::kNearest ? nearest : second;
    // Not a minimum: a NaN coordinate must give NaN.
    return M::select(square > 1.0f, 1.0f, M::sqrt(square));
}

}  // namespace openfab::functions
