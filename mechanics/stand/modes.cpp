// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "mechanics/part/eigen.h"
#include "mechanics/part/part_results.h"
#include "mechanics/solver/parallel.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {

namespace {

using Vector = Field<double, kElastic>;

/// Lumped masses of nodes, in kg.
Field<double, kScalar> masses_of(const PartProblem& p) {
    const Grid& g = p.grid;
    Field<double, kScalar> out(g);
    // g/cm3 times mm3 is 1e-6 kg.
    const double volume = g.pitch_mm[0] * g.pitch_mm[1] * g.pitch_mm[2] * 1e-6;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (!(p.voxels.mu[at] > 0)) continue;
        const double mass = static_cast<double>(p.voxels.density[at]) * volume / 8;
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(g, {e, d})) {
                const int64_t row = node / g.nodes[0];
                out.row(0, static_cast<int32_t>(row % g.nodes[1]),
                        static_cast<int32_t>(row / g.nodes[1]))[node % g.nodes[0]] += mass;
            }
    }
    return out;
}

class Subspace {
  public:
    Subspace(const PartProblem& p, const ElementOperator<kElastic>& a, double unit,
             const ModeOptions& o)
        : g_(p.grid), a_(a), unit_(unit), o_(o), masses_(masses_of(p)), work_(p.grid) {
        // One more than is wanted: the last converges slowly.
        for (size_t k = 0; k < o.count + 1; ++k) {
            x_.emplace_back(p.grid);
            start(k);
        }
    }

    /// Returns whether it converged; nothing where it was stopped.
    std::optional<bool> run();
    const Vector& vector(size_t k) const { return x_[k]; }
    double square(size_t k) const { return squares_[k]; }
    double residual(size_t k);

  private:
    /// Smooth shapes first, so that few sweeps suffice: products of low polynomials, and some noise.
    void start(size_t k);
    void weigh(const Vector& x, Vector* out) const;
    /// Makes the vectors a basis in which K and M are diagonal, M to 1.
    void rotate();

    const Grid& g_;
    const ElementOperator<kElastic>& a_;
    double unit_;
    const ModeOptions& o_;
    Field<double, kScalar> masses_;
    std::vector<Vector> x_;
    Vector work_;
    std::vector<double> squares_;
};

void Subspace::start(size_t k) {
    for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t n) {
        uint32_t state =
            static_cast<uint32_t>(k) * 747796405U + static_cast<uint32_t>(c) * 2654435761U +
            static_cast<uint32_t>(y) * 40503U + static_cast<uint32_t>(z) * 2246822519U + 1U;
        double* x = x_[k].row(c, y, z);
        const double v = static_cast<double>(y) / g_.nodes[1] - 0.5,
                     w = static_cast<double>(z) / g_.nodes[2] - 0.5;
        const auto kind = static_cast<int>(k);
        for (int32_t i = 0; i < n; ++i) {
            const double u = static_cast<double>(i) / n - 0.5;
            state = state * 1664525U + 1013904223U;
            const double noise = static_cast<double>(state >> 8) / 16777216.0 - 0.5;
            // Pushed along an axis, turned about one, then waves.
            double smooth = 0;
            if (kind < 3)
                smooth = c == kind ? 1 : 0;
            else if (kind < 6) {
                const int a = (kind + 1) % 3, b = (kind + 2) % 3;
                const double r[3] = {u, v, w};
                smooth = c == a ? -r[b] : c == b ? r[a] : 0;
            } else {
                smooth = c == kind % 3 ? std::cos(std::numbers::pi * (kind / 3) * (u + v + w)) : 0;
            }
            x[i] = smooth + 0.05 * noise;
        }
    });
    a_.fix(&x_[k]);
}

void Subspace::weigh(const Vector& x, Vector* out) const {
    for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t n) {
        const double* from = x.row(c, y, z);
        const double* m = masses_.row(0, y, z);
        double* to = out->row(c, y, z);
        for (int32_t i = 0; i < n; ++i)
            to[i] = m[i] * from[i];
    });
    a_.fix(out);
}

void Subspace::rotate() {
    const size_t n = x_.size();
    std::vector<double> k(n * n), m(n * n);
    for (size_t i = 0; i < n; ++i) {
        weigh(x_[i], &work_);
        for (size_t j = 0; j < n; ++j)
            m[i * n + j] = dot(x_[j], work_);
    }
    for (size_t i = 0; i < n; ++i) {
        a_.apply(&x_[i], &work_);
        for (size_t j = 0; j < n; ++j)
            k[i * n + j] = unit_ * dot(x_[j], work_);
    }
    // M = Q d Q^T; with y = d^-1/2 Q^T x, a plain eigenproblem.
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < i; ++j) {
            m[i * n + j] = m[j * n + i] = 0.5 * (m[i * n + j] + m[j * n + i]);
            k[i * n + j] = k[j * n + i] = 0.5 * (k[i * n + j] + k[j * n + i]);
        }
    const Eigen of_m = eigen_of(m, n);
    std::vector<double> basis(n * n);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            basis[i * n + j] = of_m.vectors[i * n + j] /
                               std::sqrt(std::max(of_m.values[i], 1e-14 * of_m.values[n - 1]));
    std::vector<double> reduced(n * n);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            for (size_t a = 0; a < n; ++a)
                for (size_t b = 0; b < n; ++b)
                    reduced[i * n + j] += basis[i * n + a] * k[a * n + b] * basis[j * n + b];
    const Eigen of_k = eigen_of(reduced, n);
    squares_ = of_k.values;
    std::vector<double> turn(n * n);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            for (size_t a = 0; a < n; ++a)
                turn[i * n + j] += of_k.vectors[i * n + a] * basis[a * n + j];
    for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t count) {
        std::vector<double> old(n);
        for (int32_t i = 0; i < count; ++i) {
            for (size_t j = 0; j < n; ++j)
                old[j] = x_[j].row(c, y, z)[i];
            for (size_t j = 0; j < n; ++j) {
                double sum = 0;
                for (size_t a = 0; a < n; ++a)
                    sum += turn[j * n + a] * old[a];
                x_[j].row(c, y, z)[i] = sum;
            }
        }
    });
}

double Subspace::residual(size_t k) {
    Vector m(g_);
    weigh(x_[k], &m);
    a_.apply(&x_[k], &work_);
    double off = 0, all = 0;
    for (int32_t z = 0; z < g_.nodes[2]; ++z)
        for (int32_t y = 0; y < g_.nodes[1]; ++y)
            for (int c = 0; c < 3; ++c)
                for (int32_t i = 0; i < g_.nodes[0]; ++i) {
                    const double a = unit_ * work_.row(c, y, z)[i],
                                 b = squares_[k] * m.row(c, y, z)[i];
                    off += (a - b) * (a - b);
                    all += b * b;
                }
    return std::sqrt(off / std::max(all, 1e-300));
}

std::optional<bool> Subspace::run() {
    Multigrid<kElastic> multigrid(a_, o_.solve.multigrid);
    rotate();
    Vector b(g_);
    for (int sweep = 1; sweep <= o_.most_sweeps; ++sweep) {
        const std::vector<double> old = squares_;
        for (size_t k = 0; k < x_.size(); ++k) {
            weigh(x_[k], &b);
            // A good guess: the solution if the vector were a mode.
            for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t n) {
                double* x = x_[k].row(c, y, z);
                double* f = b.row(c, y, z);
                for (int32_t i = 0; i < n; ++i) {
                    x[i] /= squares_[k];
                    f[i] /= unit_;
                }
            });
            SolveOptions options = o_.solve;
            options.tolerance = 1e-3;
            options.progress = [&](int, double residual) {
                return !o_.progress || o_.progress(sweep, residual);
            };
            const SolveReport report = solve(a_, &multigrid, &b, &x_[k], options);
            if (report.stopped) return std::nullopt;
        }
        rotate();
        double change = 0;
        for (size_t k = 0; k < o_.count; ++k)
            change = std::max(change, std::abs(squares_[k] / old[k] - 1));
        if (change < o_.tolerance) return true;
    }
    return false;
}

}  // namespace

Modes softest_modes(PartProblem* problem, const ModeOptions& o) {
    PartProblem& p = *problem;
    const Grid& g = p.grid;
    Modes out;
    ElementValues values{std::move(p.voxels.lambda), std::move(p.voxels.mu), 1};
    values.normalise();
    // Masses are of what is stiff.
    p.voxels.mu = values.second;
    FixedNodes fixed;
    for (const Held& h : p.held)
        fixed.push_back(h.dof);
    const ElementOperator<kElastic> a(g, &values, &fixed);
    Subspace subspace(p, a, values.unit, o);
    const std::optional<bool> done = subspace.run();
    const auto unit = static_cast<float>(values.unit);
    p.voxels.lambda = values.first;
    for (std::vector<float>* all : {&p.voxels.lambda, &p.voxels.mu})
        for (float& v : *all)
            v *= unit;
    out.stopped = !done;
    out.converged = done.value_or(false);
    if (!done) return out;
    out.weakness.resize(p.voxels.solid.size());
    for (size_t k = 0; k < o.count; ++k) {
        Vector x = subspace.vector(k);
        const PartFields fields = fields_of(p, &x);
        const PartSummary s = summary_of(p, fields, x, 1);
        Mode mode;
        // N/mm/kg is 1000/s2.
        mode.frequency_Hz =
            std::sqrt(std::max(0.0, subspace.square(k)) * 1000) / (2 * std::numbers::pi);
        mode.residual = subspace.residual(k);
        mode.moved_at_mm = s.moved_at_mm;
        for (size_t c = 0; c < 3; ++c)
            mode.moved[c] = s.moved_there_mm[c] / std::max(s.most_moved_mm, 1e-300);
        const auto most = std::ranges::max_element(fields.von_mises_MPa);
        const auto place = static_cast<int64_t>(most - fields.von_mises_MPa.begin());
        for (size_t c = 0; c < 3; ++c)
            mode.strained_at_mm[c] =
                p.voxels.origin_mm[c] + (place_of(g, place)[c] + 0.5) * g.pitch_mm[c];
        mode.material = p.voxels.code[static_cast<size_t>(place)];
        mode.strained = place;
        mode.von_mises_MPa = static_cast<double>(*most);
        const std::array<int32_t, 3> at = place_of(g, place);
        const auto e = static_cast<size_t>(place);
        const double solid = static_cast<double>(p.voxels.solid[e]);
        mode.stress_MPa = stress_of(strain_of(centre_gradient(x, g, at[0], at[1], at[2])),
                                    static_cast<double>(p.voxels.lambda[e]) / solid,
                                    static_cast<double>(p.voxels.mu[e]) / solid);
        // Of unit energy x K x / 2: so that a soft mode counts as much as a stiff one that costs as much.
        const auto scale =
            static_cast<float>(1 / std::sqrt(std::max(subspace.square(k), 1e-300) / 2));
        for (size_t i = 0; i < out.weakness.size(); ++i)
            out.weakness[i] = std::max(out.weakness[i], scale * fields.von_mises_MPa[i]);
        out.all.push_back(mode);
    }
    return out;
}

int64_t modes_bytes(const Grid& grid, size_t count) {
    const int64_t field = int64_t{grid.nodes[0] + 2} * grid.nodes[1] * grid.nodes[2] * kElastic * 8;
    return part_bytes(grid) + (static_cast<int64_t>(count) + 4) * field + 12 * grid.element_count();
}

}  // namespace openfab::mechanics
