// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/eigen.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace openfab::mechanics {

Eigen eigen_of(std::vector<double> a, size_t n) {
    std::vector<double> v(n * n);
    for (size_t i = 0; i < n; ++i)
        v[i * n + i] = 1;
    constexpr int kMostSweeps = 60;
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
        double off = 0, all = 0;
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j < n; ++j)
                (i == j ? all : off) += a[i * n + j] * a[i * n + j];
        if (off <= 1e-30 * all) break;
        for (size_t p = 0; p < n; ++p)
            for (size_t q = p + 1; q < n; ++q) {
                const double apq = a[p * n + q];
                if (apq == 0) continue;
                const double theta = (a[q * n + q] - a[p * n + p]) / (2 * apq);
                const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::hypot(theta, 1.0));
                const double c = 1 / std::hypot(t, 1.0), s = t * c;
                for (size_t k = 0; k < n; ++k) {
                    const double x = a[k * n + p], y = a[k * n + q];
                    a[k * n + p] = c * x - s * y;
                    a[k * n + q] = s * x + c * y;
                }
                for (size_t k = 0; k < n; ++k) {
                    const double x = a[p * n + k], y = a[q * n + k];
                    a[p * n + k] = c * x - s * y;
                    a[q * n + k] = s * x + c * y;
                    const double u = v[p * n + k], w = v[q * n + k];
                    v[p * n + k] = c * u - s * w;
                    v[q * n + k] = s * u + c * w;
                }
            }
    }
    std::vector<size_t> order(n);
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::stable_sort(order,
                             [&](size_t i, size_t j) { return a[i * n + i] < a[j * n + j]; });
    Eigen out;
    for (const size_t i : order) {
        out.values.push_back(a[i * n + i]);
        for (size_t k = 0; k < n; ++k)
            out.vectors.push_back(v[i * n + k]);
    }
    return out;
}

std::array<double, 3> principal_of(const std::array<double, 6>& s) {
    // Of the deviator: its invariants give the angle.
    const double mean = (s[0] + s[1] + s[2]) / 3;
    const double x = s[0] - mean, y = s[1] - mean, z = s[2] - mean;
    const double j2 = (x * x + y * y + z * z) / 2 + s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    if (!(j2 > 0)) return {mean, mean, mean};
    const double j3 = x * (y * z - s[3] * s[3]) - s[5] * (s[5] * z - s[3] * s[4]) +
                      s[4] * (s[5] * s[3] - y * s[4]);
    const double radius = 2 * std::sqrt(j2 / 3);
    const double cosine = std::clamp(1.5 * std::sqrt(3.0) * j3 / (j2 * std::sqrt(j2)), -1.0, 1.0);
    const double angle = std::acos(cosine) / 3;
    constexpr double kThird = 2.0943951023931953;
    return {mean + radius * std::cos(angle + kThird), mean + radius * std::cos(angle - kThird),
            mean + radius * std::cos(angle)};
}

}  // namespace openfab::mechanics
