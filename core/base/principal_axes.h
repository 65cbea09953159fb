// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The principal axes of a symmetric matrix, by cyclic Jacobi rotations.

#include <cmath>

namespace openfab {

/// Turns a symmetric matrix into a diagonal one, whose eigenvectors become the rows of `axes`. It ends when the
/// others are together at most `rest` of the diagonal, or after so many sweeps.
inline void principal_axes(double a[3][3], double axes[3][3], double rest, int sweeps) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            axes[i][j] = i == j ? 1.0 : 0.0;
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        const double off = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
        if (off <= rest * (std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]))) break;
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0.0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                const double t =
                    (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0);
                const double s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = axes[p][k], y = axes[q][k];
                    axes[p][k] = c * x - s * y;
                    axes[q][k] = s * x + c * y;
                }
            }
        }
    }
}

}  // namespace openfab
