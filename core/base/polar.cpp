// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/polar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/messages.h"

namespace openfab {
namespace {

using Matrix = std::array<double, 9>;

constexpr Matrix kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

double determinant(const Matrix& m) {
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
           m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/// To 12 decimals, so that equal scales under different rotations give equal bits.
double rounded(double value) {
    constexpr double kUnit = 1e12;
    if (std::fabs(value) >= 9e3) return value;  // the integer would not be exact
    return std::floor(value * kUnit + 0.5) / kUnit;
}

double snapped_to_unit(double value) {
    constexpr double kSlack =
        1e-14;  // rounding of the iteration, far below any rotation one could ask for
    if (std::fabs(value) < kSlack) return 0;
    if (std::fabs(value - 1) < kSlack) return 1;
    if (std::fabs(value + 1) < kSlack) return -1;
    return value;
}

}  // namespace

Matrix inverse_transposed(const Matrix& m) {
    const double det = determinant(m);
    return {(m[4] * m[8] - m[5] * m[7]) / det, (m[5] * m[6] - m[3] * m[8]) / det,
            (m[3] * m[7] - m[4] * m[6]) / det, (m[2] * m[7] - m[1] * m[8]) / det,
            (m[0] * m[8] - m[2] * m[6]) / det, (m[1] * m[6] - m[0] * m[7]) / det,
            (m[1] * m[5] - m[2] * m[4]) / det, (m[2] * m[3] - m[0] * m[5]) / det,
            (m[0] * m[4] - m[1] * m[3]) / det};
}

Result<PolarFactors> polar_factors(const Matrix& m) {
    double largest = 0;
    for (double value : m) {
        if (!std::isfinite(value)) return user_error(messages::kTransformNotFinite);
        largest = std::max(largest, std::fabs(value));
    }
    const double det = determinant(m);
    if (std::fabs(det) < 1e-12 || std::fabs(det) < 1e-9 * largest * largest * largest) {
        return user_error(fmt::format(messages::kTransformFlattens, det),
                          messages::kTransformFlattensHelp);
    }
    // Newton's iteration for the orthogonal polar factor (Higham 1986): quadratic once near,
    // halving before, so the number of steps is bounded by the logarithm of the scale.
    Matrix r = m;
    for (int step = 0; step < 200; ++step) {
        const Matrix other = inverse_transposed(r);
        double change = 0;
        for (size_t i = 0; i < 9; ++i) {
            const double next = 0.5 * (r[i] + other[i]);
            change = std::max(change, std::fabs(next - r[i]));
            r[i] = next;
        }
        if (change < 1e-15) break;
    }
    for (double& value : r)
        value = snapped_to_unit(value);
    // S = R^T M, made symmetric.
    Matrix s{};
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            s[i * 3 + j] = r[i] * m[j] + r[3 + i] * m[3 + j] + r[6 + i] * m[6 + j];
        }
    }
    constexpr double kDiagonal = 1e-9;
    bool diagonal = true;
    bool identity = true;
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = i; j < 3; ++j) {
            const double value = rounded(0.5 * (s[i * 3 + j] + s[j * 3 + i]));
            s[i * 3 + j] = s[j * 3 + i] = value;
            if (i != j) diagonal = diagonal && std::fabs(value) < kDiagonal;
            identity = identity && std::fabs(value - (i == j ? 1 : 0)) < kDiagonal;
        }
    }
    if (identity) {
        s = kIdentity;
    } else if (diagonal) {
        s = {s[0], 0, 0, 0, s[4], 0, 0, 0, s[8]};
    }
    return PolarFactors{r, s};
}

}  // namespace openfab
