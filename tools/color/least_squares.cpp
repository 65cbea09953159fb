// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/least_squares.h"

#include <cmath>

namespace openfab::color {

namespace {

double sum_of_squares(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values)
        sum += value * value;
    return sum;
}

}  // namespace

bool invert_positive(Square* matrix) {
    Square& m = *matrix;
    const size_t n = m.size();
    // L below and on the diagonal.
    for (size_t j = 0; j < n; ++j) {
        double pivot = m.at(j, j);
        for (size_t k = 0; k < j; ++k)
            pivot -= m.at(j, k) * m.at(j, k);
        if (!(pivot > 0)) return false;
        const double root = std::sqrt(pivot);
        m.at(j, j) = root;
        for (size_t i = j + 1; i < n; ++i) {
            double value = m.at(i, j);
            for (size_t k = 0; k < j; ++k)
                value -= m.at(i, k) * m.at(j, k);
            m.at(i, j) = value / root;
        }
    }
    // Its inverse, transposed into the upper triangle: row j holds column j of L^-1 from j on.
    std::vector<double> diagonal(n);
    for (size_t j = 0; j < n; ++j) {
        diagonal[j] = 1 / m.at(j, j);
        for (size_t i = j + 1; i < n; ++i) {
            double value = m.at(i, j) * diagonal[j];
            for (size_t k = j + 1; k < i; ++k)
                value += m.at(i, k) * m.at(j, k);
            m.at(j, i) = -value / m.at(i, i);
        }
    }
    // L^-T L^-1.
    Square out(n);
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = i; j < n; ++j) {
            double value = 0;
            for (size_t k = j; k < n; ++k) {
                value += (k == i ? diagonal[i] : m.at(i, k)) * (k == j ? diagonal[j] : m.at(j, k));
            }
            out.at(i, j) = out.at(j, i) = value;
        }
    }
    m = std::move(out);
    return true;
}

double minimise_squares(const Residuals& residuals, size_t count, std::vector<double>* values) {
    constexpr int kMostSteps = 40;
    constexpr double kNudge = 1e-5, kLeastGain = 1e-9, kMostDamping = 1e8;
    const size_t n = values->size();
    std::vector<double> here(count), there(count);
    std::vector<std::vector<double>> slopes(n, std::vector<double>(count));
    residuals(*values, &here);
    double error = sum_of_squares(here);
    double damping = 1e-3;
    for (int step = 0; step < kMostSteps; ++step) {
        for (size_t i = 0; i < n; ++i) {
            std::vector<double> moved = *values;
            moved[i] += kNudge;
            residuals(moved, &slopes[i]);
            for (size_t k = 0; k < count; ++k)
                slopes[i][k] = (slopes[i][k] - here[k]) / kNudge;
        }
        Square normal(n);
        std::vector<double> gradient(n);
        for (size_t i = 0; i < n; ++i) {
            for (size_t j = 0; j < n; ++j) {
                for (size_t k = 0; k < count; ++k)
                    normal.at(i, j) += slopes[i][k] * slopes[j][k];
            }
            for (size_t k = 0; k < count; ++k)
                gradient[i] += slopes[i][k] * here[k];
        }
        bool better = false;
        double gain = 0;
        while (!better && damping < kMostDamping) {
            Square damped = normal;
            for (size_t i = 0; i < n; ++i)
                damped.at(i, i) += damping * (normal.at(i, i) + 1e-12);
            std::vector<double> moved = *values;
            if (invert_positive(&damped)) {
                for (size_t i = 0; i < n; ++i) {
                    for (size_t j = 0; j < n; ++j)
                        moved[i] -= damped.at(i, j) * gradient[j];
                }
                residuals(moved, &there);
                const double now = sum_of_squares(there);
                better = now < error;
                if (better) {
                    gain = error - now;
                    error = now;
                    *values = moved;
                    here.swap(there);
                }
            }
            damping *= better ? 0.2 : 10;
        }
        if (!better || gain < kLeastGain * error) break;
    }
    return error;
}

}  // namespace openfab::color
