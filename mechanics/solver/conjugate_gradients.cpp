// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/conjugate_gradients.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

template <int C>
SolveReport solve(const ElementOperator<C>& a, Multigrid<C>* preconditioner, Field<double, C>* b,
                  Field<double, C>* x, const SolveOptions& options) {
    const Grid& g = a.grid();
    a.fix(b);
    const double wanted = std::sqrt(dot(*b, *b));
    SolveReport report;
    if (!(wanted > 0)) {
        for (int32_t z = 0; z < g.nodes[2]; ++z)
            std::fill_n(x->plane(z), x->plane_size(), 0.0);
        report.converged = true;
        return report;
    }
    Field<double, C> r(g), p(g), q(g);
    // Sums of planes, each made while the plane is in the cache.
    std::vector<double> sums(static_cast<size_t>(g.nodes[2]));
    const auto sum = [&] { return std::accumulate(sums.begin(), sums.end(), 0.0); };
    double size = 0;  // of r
    const auto take_residual = [&] {
        a.apply(x, &q, nullptr, [&](int32_t z) {
            for (int32_t y = 0; y < g.nodes[1]; ++y)
                for (int c = 0; c < C; ++c)
                    for (int32_t i = 0; i < g.nodes[0]; ++i)
                        r.row(c, y, z)[i] = b->row(c, y, z)[i] - q.row(c, y, z)[i];
            sums[static_cast<size_t>(z)] = dot(r, r, z);
        });
        size = std::sqrt(sum());
        return size / wanted;
    };
    report.residual = take_residual();
    // Again from the true residual where the one that was carried along had moved away from it.
    for (int restart = 0; restart < 6 && report.residual > options.tolerance; ++restart) {
        double old = 0;
        double carried = report.residual;
        while (carried > options.tolerance && report.iterations < options.most_iterations) {
            double rho = 0;
            const Field<float, C>& z_ = preconditioner->apply(r, size, &rho);
            if (!(rho > 0) || !std::isfinite(rho)) {
                preconditioner->widen();
                break;
            }
            const double beta = old > 0 ? rho / old : 0;
            old = rho;
            for_rows<C>(g, [&](int c, int32_t y, int32_t z, int32_t n) {
                double* to = p.row(c, y, z);
                const float* from = z_.row(c, y, z);
                for (int32_t i = 0; i < n; ++i)
                    to[i] = static_cast<double>(from[i]) + beta * to[i];
            });
            a.apply(&p, &q, nullptr,
                    [&](int32_t z) { sums[static_cast<size_t>(z)] = dot(p, q, z); });
            const double curvature = sum();
            if (!(curvature > 0) || !std::isfinite(curvature)) break;
            const double alpha = rho / curvature;
            for_each_index(g.nodes[2], [&](int32_t z) {
                for (int32_t y = 0; y < g.nodes[1]; ++y)
                    for (int c = 0; c < C; ++c) {
                        double* xs = x->row(c, y, z);
                        double* rs = r.row(c, y, z);
                        const double* ps = p.row(c, y, z);
                        const double* qs = q.row(c, y, z);
                        for (int32_t i = 0; i < g.nodes[0]; ++i) {
                            xs[i] += alpha * ps[i];
                            rs[i] -= alpha * qs[i];
                        }
                    }
                sums[static_cast<size_t>(z)] = dot(r, r, z);
            });
            size = std::sqrt(sum());
            carried = size / wanted;
            ++report.iterations;
            if (options.progress && !options.progress(report.iterations, carried)) {
                report.stopped = true;
                break;
            }
        }
        report.residual = take_residual();
        if (report.stopped || report.iterations >= options.most_iterations) break;
    }
    report.converged = report.residual <= options.tolerance;
    return report;
}

template <int C>
int64_t solver_bytes(const Grid& grid) {
    const int64_t field = int64_t{grid.nodes[0] + 2} * grid.nodes[1] * grid.nodes[2] * C * 8;
    return 5 * field + Multigrid<C>::needed_bytes(grid) + (C == 3 ? 8 : 4) * grid.element_count();
}

template SolveReport solve(const ElementOperator<kElastic>&, Multigrid<kElastic>*,
                           Field<double, kElastic>*, Field<double, kElastic>*, const SolveOptions&);
template SolveReport solve(const ElementOperator<kScalar>&, Multigrid<kScalar>*,
                           Field<double, kScalar>*, Field<double, kScalar>*, const SolveOptions&);
template int64_t solver_bytes<kElastic>(const Grid&);
template int64_t solver_bytes<kScalar>(const Grid&);

}  // namespace openfab::mechanics
