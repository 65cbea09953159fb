// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Strains and gradients at the centres of elements.

#include <array>

#include "mechanics/solver/field.h"

namespace openfab::mechanics {

/// Derivatives at the centre of an element: [component][axis]. The ghosts of u are filled.
template <typename T, int C>
std::array<std::array<double, 3>, C> centre_gradient(const Field<T, C>& u, const Grid& g, int32_t x,
                                                     int32_t y, int32_t z) {
    const int32_t y1 = y + 1 == g.nodes[1] ? 0 : y + 1, z1 = z + 1 == g.nodes[2] ? 0 : z + 1;
    std::array<std::array<double, 3>, C> out;
    for (int c = 0; c < C; ++c) {
        const T* a = u.row(c, y, z) + x;
        const T* b = u.row(c, y1, z) + x;
        const T* d = u.row(c, y, z1) + x;
        const T* e = u.row(c, y1, z1) + x;
        const double a0 = static_cast<double>(a[0]), a1 = static_cast<double>(a[1]);
        const double b0 = static_cast<double>(b[0]), b1 = static_cast<double>(b[1]);
        const double d0 = static_cast<double>(d[0]), d1 = static_cast<double>(d[1]);
        const double e0 = static_cast<double>(e[0]), e1 = static_cast<double>(e[1]);
        out[static_cast<size_t>(c)] = {
            (((a1 - a0) + (b1 - b0)) + ((d1 - d0) + (e1 - e0))) / (4 * g.pitch_mm[0]),
            (((b0 - a0) + (b1 - a1)) + ((e0 - d0) + (e1 - d1))) / (4 * g.pitch_mm[1]),
            (((d0 - a0) + (d1 - a1)) + ((e0 - b0) + (e1 - b1))) / (4 * g.pitch_mm[2])};
    }
    return out;
}

/// xx, yy, zz, yz, xz, xy, engineering shears, of a displacement's gradient.
inline std::array<double, 6> strain_of(const std::array<std::array<double, 3>, 3>& g) {
    return {g[0][0], g[1][1], g[2][2], g[1][2] + g[2][1], g[0][2] + g[2][0], g[0][1] + g[1][0]};
}

/// The stress of an isotropic element.
inline std::array<double, 6> stress_of(const std::array<double, 6>& e, double lambda, double mu) {
    const double bulk = lambda * (e[0] + e[1] + e[2]);
    return {bulk + 2 * mu * e[0],
            bulk + 2 * mu * e[1],
            bulk + 2 * mu * e[2],
            mu * e[3],
            mu * e[4],
            mu * e[5]};
}

}  // namespace openfab::mechanics
