// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/cell/homogenise.h"

#include <algorithm>
#include <cmath>

#include "mechanics/solver/parallel.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {

template <int N>
bool Homogenised<N>::converged() const {
    return std::ranges::all_of(reports, &SolveReport::converged);
}
template <int N>
double Homogenised<N>::worst_residual() const {
    return std::ranges::max(reports, {}, &SolveReport::residual).residual;
}
template <int N>
int Homogenised<N>::most_iterations() const {
    return std::ranges::max(reports, {}, &SolveReport::iterations).iterations;
}

namespace {

/// Means over the cell of the elements' own tensors.
SquareMatrix<6> voigt_mean(const ElementValues& v) {
    double lambda = 0, mu = 0;
    for (size_t i = 0; i < v.first.size(); ++i) {
        lambda += static_cast<double>(v.first[i]);
        mu += static_cast<double>(v.second[i]);
    }
    lambda /= static_cast<double>(v.first.size());
    mu /= static_cast<double>(v.first.size());
    SquareMatrix<6> out{};
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j)
            out[i][j] = lambda + (i == j ? 2 * mu : 0);
        out[i + 3][i + 3] = mu;
    }
    return out;
}
SquareMatrix<3> scalar_mean(const ElementValues& v) {
    double sum = 0;
    for (const float k : v.first)
        sum += static_cast<double>(k);
    SquareMatrix<3> out{};
    for (size_t i = 0; i < 3; ++i)
        out[i][i] = sum / static_cast<double>(v.first.size());
    return out;
}

/// Means over the cell of the stresses, or fluxes, that a fluctuation adds.
template <int C, int N>
std::array<double, N> mean_stress(const Grid& g, const ElementValues& v, Field<double, C>* u) {
    std::vector<std::array<double, N>> planes(static_cast<size_t>(g.elements[2]));
    for_each_index(g.nodes[2], [&](int32_t z) { u->fill_ghosts(z); });
    for_each_index(g.elements[2], [&](int32_t z) {
        std::array<double, N>& sum = planes[static_cast<size_t>(z)];
        for (int32_t y = 0; y < g.elements[1]; ++y)
            for (int32_t x = 0; x < g.elements[0]; ++x) {
                const size_t e = g.element(x, y, z);
                const auto gradient = centre_gradient(*u, g, x, y, z);
                if constexpr (C == 3) {
                    const auto s = stress_of(strain_of(gradient), static_cast<double>(v.first[e]),
                                             static_cast<double>(v.second[e]));
                    for (size_t i = 0; i < N; ++i)
                        sum[i] += s[i];
                } else {
                    for (size_t i = 0; i < N; ++i)
                        sum[i] += static_cast<double>(v.first[e]) * gradient[0][i];
                }
            }
    });
    std::array<double, N> out{};
    for (const std::array<double, N>& one : planes)
        for (size_t i = 0; i < N; ++i)
            out[i] += one[i] / static_cast<double>(g.element_count());
    return out;
}

/// The norm of forces that are rounding alone: of equal elements next to each other, which push against each other
/// with up to stiffness times area.
double rounding_of(const Grid& grid, const ElementValues& values) {
    double stiffest = 0;
    for (size_t e = 0; e < values.first.size(); ++e)
        stiffest = std::max(
            stiffest,
            static_cast<double>(values.first[e]) +
                (values.second.empty() ? 0.0 : 2.0 * static_cast<double>(values.second[e])));
    const auto& h = grid.pitch_mm;
    const double area = std::max({h[0] * h[1], h[1] * h[2], h[2] * h[0]});
    return 1e-13 * stiffest * area * std::sqrt(static_cast<double>(grid.node_count()));
}

template <int C, int N>
Homogenised<N> homogenise(const Grid& grid, const ElementValues& values, SquareMatrix<N> mean,
                          const HomogeniseOptions& options) {
    const FixedNodes fixed;
    const ElementOperator<C> a(grid, &values, &fixed);
    Multigrid<C> multigrid(a, options.solve.multigrid);
    Field<double, C> b(grid), x(grid);
    Homogenised<N> out;
    const double rounding = rounding_of(grid, values);
    for (size_t j = 0; j < N; ++j) {
        double strain[N] = {};
        strain[j] = 1;
        for (int32_t z = 0; z < grid.nodes[2]; ++z)
            std::fill_n(x.plane(z), x.plane_size(), 0.0);
        a.apply(&x, &b, strain);
        for_each_index(grid.nodes[2], [&](int32_t z) {
            double* p = b.plane(z);
            for (size_t k = 0; k < b.plane_size(); ++k)
                p[k] = -p[k];
        });
        // Layers take some strains as one: their forces are none, and have no solution where they are but rounding.
        if (dot(b, b) <= rounding * rounding)
            for_each_index(grid.nodes[2],
                           [&](int32_t z) { std::fill_n(b.plane(z), b.plane_size(), 0.0); });
        SolveOptions solve_options = options.solve;
        if (options.progress)
            solve_options.progress = [&](int iteration, double residual) {
                return options.progress(static_cast<int>(j), iteration, residual);
            };
        out.reports[j] = solve(a, &multigrid, &b, &x, solve_options);
        if (out.reports[j].stopped) {
            out.stopped = true;
            return out;
        }
        // The error of a diagonal entry is that of the energy, quadratic in that of x.
        const std::array<double, N> stress = mean_stress<C, N>(grid, values, &x);
        for (size_t i = 0; i < N; ++i)
            out.tensor[i][j] = mean[i][j] + stress[i];
    }
    for (size_t i = 0; i < N; ++i)
        for (size_t j = 0; j < i; ++j)
            out.tensor[i][j] = out.tensor[j][i] = 0.5 * (out.tensor[i][j] + out.tensor[j][i]);
    for (auto& row : out.tensor)
        for (double& v : row)
            v *= values.unit;
    return out;
}

}  // namespace

Homogenised<6> homogenise_stiffness(const Grid& grid, const ElementValues& values,
                                    const HomogeniseOptions& options) {
    return homogenise<kElastic, 6>(grid, values, voigt_mean(values), options);
}
Homogenised<3> homogenise_conductivity(const Grid& grid, const ElementValues& values,
                                       const HomogeniseOptions& options) {
    return homogenise<kScalar, 3>(grid, values, scalar_mean(values), options);
}

template struct Homogenised<6>;
template struct Homogenised<3>;

}  // namespace openfab::mechanics
