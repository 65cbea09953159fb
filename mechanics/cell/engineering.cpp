// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/cell/engineering.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace openfab::mechanics {

std::optional<Stiffness> compliance_of(const Stiffness& stiffness) {
    Stiffness a = stiffness, inverse{};
    double largest = 0;
    for (size_t i = 0; i < 6; ++i) {
        inverse[i][i] = 1;
        largest = std::max(largest, std::abs(a[i][i]));
    }
    for (size_t c = 0; c < 6; ++c) {
        size_t pivot = c;
        for (size_t r = c + 1; r < 6; ++r)
            if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
        if (!(std::abs(a[pivot][c]) > 1e-7 * largest)) return std::nullopt;
        std::swap(a[c], a[pivot]);
        std::swap(inverse[c], inverse[pivot]);
        const double scale = 1 / a[c][c];
        for (size_t k = 0; k < 6; ++k) {
            a[c][k] *= scale;
            inverse[c][k] *= scale;
        }
        for (size_t r = 0; r < 6; ++r) {
            if (r == c) continue;
            const double f = a[r][c];
            for (size_t k = 0; k < 6; ++k) {
                a[r][k] -= f * a[c][k];
                inverse[r][k] -= f * inverse[c][k];
            }
        }
    }
    return inverse;
}

double young_along(const Stiffness& s, const std::array<double, 3>& n) {
    const double v[6] = {n[0] * n[0], n[1] * n[1], n[2] * n[2],
                         n[1] * n[2], n[0] * n[2], n[0] * n[1]};
    double sum = 0;
    for (size_t i = 0; i < 6; ++i)
        for (size_t j = 0; j < 6; ++j)
            sum += v[i] * s[i][j] * v[j];
    return 1 / sum;
}

Engineering engineering_of(const Stiffness& c, const Stiffness& s) {
    Engineering e;
    for (size_t i = 0; i < 3; ++i) {
        e.young[i] = 1 / s[i][i];
        e.shear[i] = 1 / s[i + 3][i + 3];
        e.poisson[i] = -s[(i + 1) % 3][i] / s[i][i];
    }
    const double c_axial = c[0][0] + c[1][1] + c[2][2], c_side = c[0][1] + c[1][2] + c[0][2],
                 c_shear = c[3][3] + c[4][4] + c[5][5];
    const double s_axial = s[0][0] + s[1][1] + s[2][2], s_side = s[0][1] + s[1][2] + s[0][2],
                 s_shear = s[3][3] + s[4][4] + s[5][5];
    e.bulk_voigt = (c_axial + 2 * c_side) / 9;
    e.shear_voigt = (c_axial - c_side + 3 * c_shear) / 15;
    e.bulk_reuss = 1 / (s_axial + 2 * s_side);
    e.shear_reuss = 15 / (4 * s_axial - 4 * s_side + 3 * s_shear);
    e.universal_anisotropy = 5 * e.shear_voigt / e.shear_reuss + e.bulk_voigt / e.bulk_reuss - 6;
    e.zener = 2 * c_shear / (c_axial - c_side);
    // Directions of a half sphere, 2 degrees apart.
    constexpr int kSteps = 90;
    e.young_least = 1e300;
    for (int i = 0; i <= kSteps / 2; ++i)
        for (int j = 0; j < 2 * kSteps; ++j) {
            const double up = std::numbers::pi * i / kSteps, turn = std::numbers::pi * j / kSteps;
            const std::array<double, 3> n{std::cos(up) * std::cos(turn),
                                          std::cos(up) * std::sin(turn), std::sin(up)};
            const double y = young_along(s, n);
            if (y < e.young_least) {
                e.young_least = y;
                e.softest = n;
            }
            if (y > e.young_most) {
                e.young_most = y;
                e.stiffest = n;
            }
        }
    return e;
}

}  // namespace openfab::mechanics
