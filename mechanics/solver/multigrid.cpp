// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/multigrid.h"

#include <cmath>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

template <int C>
struct Multigrid<C>::Level {
    Grid grid;
    Stencil<C> stencil;  ///< not of the finest
    Field<float, C> inverse_diagonal, b, x, d, q;
    double largest = 1;  ///< eigenvalue of D^-1 A

    explicit Level(const Grid& g) : grid(g), inverse_diagonal(g), b(g), x(g), d(g), q(g) {}
};

namespace {

/// Small enough for a dense factor.
constexpr int64_t kCoarsest = 500;

bool is_coarsest(const Grid& g, int components) {
    return g.node_count() * components <= kCoarsest ||
           *std::max_element(g.nodes.begin(), g.nodes.end()) <= 3;
}

template <int C>
void apply_to(const ElementOperator<C>& a, Field<float, C>* x, Field<float, C>* y,
              const PlaneDone& done) {
    a.apply(x, y, nullptr, done);
}
template <int C>
void apply_to(const Stencil<C>& a, Field<float, C>* x, Field<float, C>* y, const PlaneDone& done) {
    a.apply(x, y, done);
}

}  // namespace

template <int C>
Multigrid<C>::Multigrid(const ElementOperator<C>& fine, const MultigridOptions& options)
    : fine_(fine), options_(options) {
    levels_.push_back(std::make_unique<Level>(fine.grid()));
    fine.inverse_diagonal(&levels_[0]->inverse_diagonal);
    levels_[0]->largest = largest_eigenvalue(fine, levels_[0].get());
    while (levels_.size() == 1 || !is_coarsest(levels_.back()->grid, C)) {
        Stencil<C> next = levels_.size() == 1 ? coarsen(fine) : coarsen(levels_.back()->stencil);
        levels_.push_back(std::make_unique<Level>(next.grid));
        Level& l = *levels_.back();
        l.stencil = std::move(next);
        l.stencil.inverse_diagonal(&l.inverse_diagonal);
        l.largest = largest_eigenvalue(l.stencil, &l);
    }
    const Stencil<C>& last = levels_.back()->stencil;
    const Grid& g = last.grid;
    const auto n = static_cast<size_t>(g.node_count() * C);
    std::vector<double> matrix(n * n);
    const auto number = [&](int32_t x, int32_t y, int32_t z) {
        return (static_cast<size_t>(z) * static_cast<size_t>(g.nodes[1]) + static_cast<size_t>(y)) *
                   static_cast<size_t>(g.nodes[0]) +
               static_cast<size_t>(x);
    };
    for (int32_t z = 0; z < g.nodes[2]; ++z)
        for (int32_t y = 0; y < g.nodes[1]; ++y)
            for (int32_t x = 0; x < g.nodes[0]; ++x)
                for (int o = 0; o < 27; ++o) {
                    int32_t to[3] = {x + o % 3 - 1, y + o / 3 % 3 - 1, z + o / 9 - 1};
                    bool there = true;
                    for (size_t a = 0; a < 3; ++a) {
                        if (g.periodic) to[a] = (to[a] + g.nodes[a]) % g.nodes[a];
                        there = there && to[a] >= 0 && to[a] < g.nodes[a];
                    }
                    if (!there) continue;
                    for (int c = 0; c < C; ++c)
                        for (int d = 0; d < C; ++d)
                            matrix[(number(x, y, z) * C + static_cast<size_t>(c)) * n +
                                   number(to[0], to[1], to[2]) * C + static_cast<size_t>(d)] +=
                                static_cast<double>(last.at(x, y, z, o, c, d));
                }
    // Entries are sums of floats; what is left of a pivot below this is their rounding.
    constexpr double kVanishes = 4e-6;
    coarsest_ = DenseSolver(std::move(matrix), n, kVanishes);
    if (!options.bodies) return;
    bodies_ = std::make_unique<StiffBodies<C>>(fine);
    if (bodies_->empty()) bodies_.reset();
}

template <int C>
Multigrid<C>::~Multigrid() = default;

template <int C>
template <typename Operator>
double Multigrid<C>::largest_eigenvalue(const Operator& a, Level* l) const {
    // By the power method from a vector that has something of each mode, the same on each machine.
    for_rows<C>(l->grid, [&](int c, int32_t y, int32_t z, int32_t n) {
        uint32_t state = static_cast<uint32_t>(c) * 2654435761U +
                         static_cast<uint32_t>(y) * 40503U +
                         static_cast<uint32_t>(z) * 2246822519U + 1U;
        float* x = l->x.row(c, y, z);
        const float* d = l->inverse_diagonal.row(c, y, z);
        for (int32_t i = 0; i < n; ++i) {
            state = state * 1664525U + 1013904223U;
            x[i] = d[i] > 0 ? static_cast<float>(state >> 8) / 8388608.F - 1 : 0;
        }
    });
    double estimate = 0;
    for (int k = 0; k < 16; ++k) {
        a.apply(&l->x, &l->q);
        double norm = dot(l->x, l->x);
        if (norm <= 0) return 1;
        for_rows<C>(l->grid, [&](int c, int32_t y, int32_t z, int32_t n) {
            float* q = l->q.row(c, y, z);
            const float* d = l->inverse_diagonal.row(c, y, z);
            for (int32_t i = 0; i < n; ++i)
                q[i] *= d[i];
        });
        const double grown = dot(l->q, l->q);
        estimate = std::sqrt(grown / norm);
        if (grown <= 0) return 1;
        const auto scale = static_cast<float>(1 / std::sqrt(grown));
        for_rows<C>(l->grid, [&](int c, int32_t y, int32_t z, int32_t n) {
            float* x = l->x.row(c, y, z);
            const float* q = l->q.row(c, y, z);
            for (int32_t i = 0; i < n; ++i)
                x[i] = q[i] * scale;
        });
    }
    return 1.2 * estimate;
}

template <int C>
template <typename Operator>
void Multigrid<C>::smooth(const Operator& a, Level* l, int degree, bool from_zero) const {
    const double high = l->largest, low = high / options_.range;
    const double theta = 0.5 * (high + low), delta = 0.5 * (high - low), sigma = theta / delta;
    double rho = 1 / sigma;
    // q becomes the residual's part that is not in b; b stays what is wanted of A x.
    const RowKernels& kernels = row_kernels();
    const size_t n = l->x.plane_size();
    const auto first = static_cast<float>(1 / theta);
    const auto begin = [&](int32_t z) {
        kernels.smooth_first(n, first, l->inverse_diagonal.plane(z), l->b.plane(z),
                             from_zero ? nullptr : l->q.plane(z), l->d.plane(z), l->x.plane(z));
    };
    if (from_zero)
        for_each_index(l->grid.nodes[2], begin);
    else
        apply_to(a, &l->x, &l->q, begin);
    for (int k = 1; k < degree; ++k) {
        const double next = 1 / (2 * sigma - rho);
        const auto keep = static_cast<float>(next * rho),
                   add = static_cast<float>(2 * next / delta);
        rho = next;
        apply_to(a, &l->x, &l->q, [&](int32_t z) {
            kernels.smooth_next(n, keep, add, l->inverse_diagonal.plane(z), l->b.plane(z),
                                l->q.plane(z), l->d.plane(z), l->x.plane(z));
        });
    }
}

template <int C>
void Multigrid<C>::solve_coarsest() {
    Level& l = *levels_.back();
    std::vector<double> x(coarsest_.size());
    size_t at = 0;
    for (int32_t z = 0; z < l.grid.nodes[2]; ++z)
        for (int32_t y = 0; y < l.grid.nodes[1]; ++y)
            for (int32_t i = 0; i < l.grid.nodes[0]; ++i)
                for (int c = 0; c < C; ++c)
                    x[at++] = static_cast<double>(l.b.row(c, y, z)[i]);
    coarsest_.solve(x.data());
    at = 0;
    for (int32_t z = 0; z < l.grid.nodes[2]; ++z)
        for (int32_t y = 0; y < l.grid.nodes[1]; ++y)
            for (int32_t i = 0; i < l.grid.nodes[0]; ++i)
                for (int c = 0; c < C; ++c)
                    l.x.row(c, y, z)[i] = static_cast<float>(x[at++]);
}

template <int C>
template <typename Operator>
void Multigrid<C>::cycle_with(const Operator& a, size_t level, int degree) {
    Level& l = *levels_[level];
    Level& below = *levels_[level + 1];
    smooth(a, &l, degree, true);
    apply_to(a, &l.x, &l.q, [&](int32_t z) {
        for (int32_t y = 0; y < l.grid.nodes[1]; ++y)
            for (int c = 0; c < C; ++c) {
                float* q = l.q.row(c, y, z);
                const float* b = l.b.row(c, y, z);
                for (int32_t i = 0; i < l.grid.nodes[0]; ++i)
                    q[i] = b[i] - q[i];
            }
    });
    restrict_to(l.q, l.grid, &below.b);
    cycle(level + 1);
    add_prolonged(&below.x, l.grid, &l.x);
    if (level == 0) fine_.fix(&l.x);
    smooth(a, &l, degree, false);
}

template <int C>
void Multigrid<C>::cycle(size_t level) {
    if (level + 1 == levels_.size()) return solve_coarsest();
    if (level == 0) return cycle_with(fine_, 0, options_.smooth_fine);
    cycle_with(levels_[level]->stencil, level, options_.smooth_coarse);
}

template <int C>
const Field<float, C>& Multigrid<C>::apply(const Field<double, C>& r) {
    return apply(r, std::sqrt(dot(r, r)), nullptr);
}

template <int C>
const Field<float, C>& Multigrid<C>::apply(const Field<double, C>& r, double size,
                                           double* product) {
    Level& l = *levels_[0];
    // So that floats neither vanish nor overflow, whatever the load is.
    const double scale = size > 0 ? 1 / size : 0;
    for_rows<C>(l.grid, [&](int c, int32_t y, int32_t z, int32_t n) {
        const double* from = r.row(c, y, z);
        float* b = l.b.row(c, y, z);
        for (int32_t i = 0; i < n; ++i)
            b[i] = static_cast<float>(scale * from[i]);
    });
    // Bodies first, then the grids with what is left, then bodies again: a symmetric operator (balancing,
    // Mandel 1993).
    std::vector<double> motions;
    if (bodies_) {
        motions = bodies_->motions_of(r);
        for (double& m : motions)
            m *= scale;
        bodies_->take_forces(motions, &l.b);
    }
    cycle(0);
    if (bodies_) {
        const std::vector<double> again = bodies_->motions_in(l.x);
        for (size_t i = 0; i < motions.size(); ++i)
            motions[i] -= again[i];
        bodies_->add(motions, &l.x);
    }
    const auto back = static_cast<float>(size);
    const double sum = sum_over(l.grid.nodes[2], [&](int32_t z) {
        for (int32_t y = 0; y < l.grid.nodes[1]; ++y)
            for (int c = 0; c < C; ++c) {
                float* x = l.x.row(c, y, z);
                for (int32_t i = 0; i < l.grid.nodes[0]; ++i)
                    x[i] *= back;
            }
        return product ? dot(l.x, r, z) : 0;
    });
    if (product) *product = sum;
    return l.x;
}

template <int C>
void Multigrid<C>::widen() {
    for (const std::unique_ptr<Level>& l : levels_)
        l->largest *= 1.5;
}

template <int C>
int Multigrid<C>::levels() const {
    return static_cast<int>(levels_.size());
}

template <int C>
int64_t Multigrid<C>::bytes() const {
    size_t sum = 0;
    for (const std::unique_ptr<Level>& l : levels_)
        sum += 5 * l->x.bytes() + l->stencil.blocks.size() * sizeof(float);
    return static_cast<int64_t>(sum);
}

template <int C>
int64_t Multigrid<C>::needed_bytes(const Grid& grid) {
    const auto per_field = [](const Grid& g) {
        return int64_t{g.nodes[0] + 2} * g.nodes[1] * g.nodes[2] * C * int64_t{sizeof(float)};
    };
    int64_t sum = 5 * per_field(grid);
    Grid g = grid;
    do {
        g = coarser(g);
        sum += 5 * per_field(g) + Stencil<C>::kKept * C * per_field(g);
    } while (!is_coarsest(g, C));
    return sum + 8 * kCoarsest * kCoarsest + StiffBodies<C>::needed_bytes(grid);
}

template class Multigrid<kElastic>;
template class Multigrid<kScalar>;

}  // namespace openfab::mechanics
