// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/buckling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanics/part/eigen.h"
#include "mechanics/part/part_results.h"
#include "mechanics/solver/conjugate_gradients.h"
#include "mechanics/solver/parallel.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {

namespace {

using Vector = Field<double, kElastic>;

/// What stresses do to a part that moves: compressed elements push further, stretched ones pull back. Its
/// sign is that of compression.
class GeometricOperator {
  public:
    /// Of the stresses of elements, void counted in, over `unit`.
    GeometricOperator(const PartProblem& p, const ElementValues& values, Vector* moved)
        : g_(p.grid), shape_(element_shape<double>(p.grid.pitch_mm)) {
        for (std::vector<float>& one : stress_)
            one.resize(values.first.size());
        for_each_index(g_.nodes[2], [&](int32_t z) { moved->fill_ghosts(z); });
        for_each_index(g_.elements[2], [&](int32_t z) {
            for (int32_t y = 0; y < g_.elements[1]; ++y)
                for (int32_t x = 0; x < g_.elements[0]; ++x) {
                    const size_t e = g_.element(x, y, z);
                    if (!(values.second[e] > 0)) continue;
                    const auto s = stress_of(strain_of(centre_gradient(*moved, g_, x, y, z)),
                                             static_cast<double>(values.first[e]),
                                             static_cast<double>(values.second[e]));
                    for (size_t i = 0; i < 6; ++i)
                        stress_[i][e] = static_cast<float>(-s[i]);
                }
        });
    }

    void apply(const Vector& x, Vector* out) const {
        for_each_index(g_.nodes[2],
                       [&](int32_t z) { std::fill_n(out->plane(z), out->plane_size(), 0.0); });
        for_layer_blocks(g_.elements[2], false, [&](int32_t begin, int32_t end) {
            std::vector<double> scratch(36 * (static_cast<size_t>(g_.elements[0]) + 1));
            for (int32_t z = begin; z < end; ++z)
                for (int32_t y = 0; y < g_.elements[1]; ++y) {
                    const double* in[12];
                    double* to[12];
                    for (int r = 0; r < 4; ++r)
                        for (int c = 0; c < 3; ++c) {
                            in[r * 3 + c] = x.row(c, y + (r & 1), z + (r >> 1));
                            to[r * 3 + c] = out->row(c, y + (r & 1), z + (r >> 1));
                        }
                    const float* stress[6];
                    for (size_t i = 0; i < 6; ++i)
                        stress[i] = stress_[i].data() + g_.element(0, y, z);
                    row_kernels().geometric(shape_, g_.elements[0], stress, in, to, scratch.data());
                }
        });
    }

  private:
    const Grid& g_;
    ElementShape<double> shape_;
    std::array<std::vector<float>, 6> stress_;
};

/// to = a to + sum of factors times vectors, of all nodes.
template <size_t N>
void combine(const Grid& g, std::array<const Vector*, N> from, const std::array<double, N>& by,
             Vector* to) {
    for_rows<kElastic>(g, [&](int c, int32_t y, int32_t z, int32_t n) {
        double* out = to->row(c, y, z);
        for (int32_t i = 0; i < n; ++i) {
            double sum = 0;
            for (size_t k = 0; k < N; ++k)
                sum += by[k] * from[k]->row(c, y, z)[i];
            out[i] = sum;
        }
    });
}

/// A vector, with what stiffness and stresses make of it.
struct Image {
    explicit Image(const Grid& g) : x(g), stiff(g), pushed(g) {}
    Vector x, stiff, pushed;
};

class Search {
  public:
    Search(const Grid& g, const ElementOperator<kElastic>& a, const GeometricOperator& b,
           const SolveOptions& o, int most_work)
        : g_(g),
          a_(a),
          b_(b),
          o_(o),
          most_work_(most_work),
          multigrid_(a, o.multigrid),
          x_(g),
          w_(g),
          p_(g),
          forces_(g) {}

    void run(double far, Buckling* out);
    const Vector& shape() const { return x_.x; }

  private:
    void apply(Image* v) {
        a_.apply(&v->x, &v->stiff);
        b_.apply(v->x, &v->pushed);
        a_.fix(&v->pushed);
    }
    /// What gives way to forces, `to`, nearly. One cycle of the multigrid would do for blocky parts; of a long strut it
    /// leaves out most of the first mode, and the search ends at a later one.
    void give_way(const Vector& forces, Vector* to);
    void start();
    /// The best of the three; returns its quotient.
    double improve();

    const Grid& g_;
    const ElementOperator<kElastic>& a_;
    const GeometricOperator& b_;
    const SolveOptions& o_;
    int most_work_, work_ = 0, iteration_ = 1;
    double residual_ = 1;
    bool stopped_ = false;
    Multigrid<kElastic> multigrid_;
    Image x_, w_, p_;
    Vector forces_;
};

void Search::give_way(const Vector& forces, Vector* to) {
    for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t n) {
        std::copy_n(forces.row(c, y, z), n, forces_.row(c, y, z));
        std::fill_n(to->row(c, y, z), n, 0.0);
    });
    a_.fix(&forces_);
    SolveOptions loose;
    loose.tolerance = 0.03;
    loose.most_iterations = 80;
    // One solution may take as long as the whole search of a small part.
    if (o_.progress)
        loose.progress = [this](int, double) { return o_.progress(iteration_, residual_); };
    const SolveReport report = solve(a_, &multigrid_, &forces_, to, loose);
    work_ += report.iterations;
    stopped_ = stopped_ || report.stopped;
    a_.fix(to);
}

void Search::start() {
    // Forces that have something of each shape, the same on each machine: what gives way most to them.
    for_rows<kElastic>(g_, [&](int c, int32_t y, int32_t z, int32_t n) {
        uint32_t state = static_cast<uint32_t>(c) * 2654435761U +
                         static_cast<uint32_t>(y) * 40503U +
                         static_cast<uint32_t>(z) * 2246822519U + 7U;
        double* r = w_.x.row(c, y, z);
        for (int32_t i = 0; i < n; ++i) {
            state = state * 1664525U + 1013904223U;
            r[i] = static_cast<double>(state >> 8) / 8388608.0 - 1;
        }
    });
    a_.fix(&w_.x);
    give_way(w_.x, &x_.x);
    apply(&x_);
    give_way(x_.pushed, &w_.x);
    combine<2>(g_, {&x_.x, &w_.x}, {1, 1}, &x_.x);
    apply(&x_);
    apply(&w_);
}

double Search::improve() {
    std::array<Image*, 3> v{&x_, &w_, &p_};
    std::array<double, 3> norm;
    for (size_t i = 0; i < 3; ++i) {
        const double square = dot(v[i]->x, v[i]->stiff);
        norm[i] = square > 0 ? 1 / std::sqrt(square) : 0;
    }
    std::vector<double> a(9), b(9);
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = i; j < 3; ++j) {
            const double scale = norm[i] * norm[j];
            a[i * 3 + j] = a[j * 3 + i] = scale * dot(v[i]->x, v[j]->stiff);
            b[i * 3 + j] = b[j * 3 + i] = scale * dot(v[i]->x, v[j]->pushed);
        }
    // In a basis in which stiffness is 1, without what depends on the rest.
    const Eigen of_a = eigen_of(a, 3);
    constexpr double kDepends = 1e-12;
    std::vector<std::array<double, 3>> basis;
    for (size_t i = 0; i < 3; ++i)
        if (of_a.values[i] > kDepends) {
            const double s = 1 / std::sqrt(of_a.values[i]);
            basis.push_back({s * of_a.vectors[i * 3], s * of_a.vectors[i * 3 + 1],
                             s * of_a.vectors[i * 3 + 2]});
        }
    const size_t n = basis.size();
    std::vector<double> reduced(n * n);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            for (size_t k = 0; k < 3; ++k)
                for (size_t l = 0; l < 3; ++l)
                    reduced[i * n + j] += basis[i][k] * b[k * 3 + l] * basis[j][l];
    const Eigen best = eigen_of(reduced, n);
    std::array<double, 3> by{};
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < 3; ++k)
            by[k] += best.vectors[(n - 1) * n + i] * basis[i][k] * norm[k];
    const auto mix = [&](Vector Image::*of) {
        combine<2>(g_, {&(w_.*of), &(p_.*of)}, {by[1], by[2]}, &(p_.*of));
        combine<2>(g_, {&(x_.*of), &(p_.*of)}, {by[0], 1}, &(x_.*of));
    };
    mix(&Image::x);
    mix(&Image::stiff);
    mix(&Image::pushed);
    return best.values[n - 1];
}

void Search::run(double far, Buckling* out) {
    start();
    double quotient = improve();
    constexpr int kLeast = 4, kMost = 60;
    Vector residual(g_);
    for (out->iterations = 1; out->iterations <= kMost; ++out->iterations) {
        out->stopped = stopped_;
        out->given_up = !stopped_ && work_ > most_work_;
        if (out->stopped || out->given_up) return;
        iteration_ = out->iterations;
        // What is carried along drifts.
        if (out->iterations % 16 == 0) apply(&x_);
        combine<2>(g_, {&x_.pushed, &x_.stiff}, {1, -quotient}, &residual);
        give_way(residual, &w_.x);
        const double square = dot(w_.x, residual);
        if (!(square > 0) || !std::isfinite(square)) {
            multigrid_.widen();
            continue;
        }
        // The nearest eigenvalue is about that near; the quotient is nearer, by its square.
        out->residual = std::sqrt(square) / std::max(std::abs(quotient), 1e-300);
        if (out->residual < kBucklingTolerance) break;
        if (out->iterations >= kLeast && quotient + std::sqrt(square) < 1 / far) break;
        residual_ = out->residual;
        apply(&w_);
        quotient = improve();
    }
    out->converged = out->iterations <= kMost;
    if (quotient > 1 / far)
        out->factor = 1 / quotient;
    else
        out->at_least = far;
}

/// How far the part goes on from each element, along the axis along which it is thinnest.
std::vector<float> thickness_of(const PartProblem& p) {
    const Grid& g = p.grid;
    std::vector<float> thick(p.elements.kind.size(), 1e30F);
    const size_t stride[3] = {
        1, static_cast<size_t>(g.elements[0]),
        static_cast<size_t>(g.elements[0]) * static_cast<size_t>(g.elements[1])};
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto n = static_cast<size_t>(g.elements[axis]);
        const size_t a = (axis + 1) % 3, b = (axis + 2) % 3, step = stride[axis];
        for_each_index(g.elements[b], [&](int32_t j) {
            for (int32_t i = 0; i < g.elements[a]; ++i) {
                const size_t first =
                    static_cast<size_t>(i) * stride[a] + static_cast<size_t>(j) * stride[b];
                for (size_t begin = 0, end = 0; begin < n; begin = end + 1) {
                    float sum = 0;
                    for (end = begin; end < n && p.elements.kind[first + end * step] != kNothing;
                         ++end)
                        sum += p.voxels.solid[first + end * step];
                    sum *= static_cast<float>(g.pitch_mm[axis]);
                    for (size_t k = begin; k < end; ++k)
                        thick[first + k * step] = std::min(thick[first + k * step], sum);
                }
            }
        });
    }
    return thick;
}

/// Euler's factor of a strut of a part, clamped at one end: pressed by so many MPa, `slender` thick for its length.
double strut_factor(double young, double slender, double pressed) {
    return std::numbers::pi * std::numbers::pi / 48 * young * slender * slender / pressed;
}

/// Mean stresses and strains of a block of a dithered part, and where it is thinnest.
struct Block {
    std::array<double, 6> stress{}, strain{};  ///< sums
    int32_t elements = 0;
    float thick = 1e30F;
};

/// The least factor of blocks. A block is about as stiff as its mean stress is to its mean strain.
double least_of_blocks(const PartProblem& p, Field<double, kElastic>* moved,
                       const std::vector<float>& thick, double longest) {
    const Grid& g = p.grid;
    constexpr int32_t kSide = 8;
    for_each_index(g.nodes[2], [&](int32_t z) { moved->fill_ghosts(z); });
    const auto blocks = [&](size_t a) { return (g.elements[a] + kSide - 1) / kSide; };
    std::vector<double> least(static_cast<size_t>(blocks(2)), 1e6);
    for_each_index(blocks(2), [&](int32_t layer) {
        std::vector<Block> all(static_cast<size_t>(blocks(0)) * static_cast<size_t>(blocks(1)));
        for (int32_t z = layer * kSide; z < std::min((layer + 1) * kSide, g.elements[2]); ++z)
            for (int32_t y = 0; y < g.elements[1]; ++y)
                for (int32_t x = 0; x < g.elements[0]; ++x) {
                    const size_t e = g.element(x, y, z);
                    if (p.elements.kind[e] != kSolid) continue;
                    Block& b = all[static_cast<size_t>(y / kSide * blocks(0) + x / kSide)];
                    const auto strain = strain_of(centre_gradient(*moved, g, x, y, z));
                    const auto stress = stress_of(strain, static_cast<double>(p.voxels.lambda[e]),
                                                  static_cast<double>(p.voxels.mu[e]));
                    for (size_t i = 0; i < 6; ++i) {
                        b.stress[i] += stress[i];
                        b.strain[i] += strain[i];
                    }
                    ++b.elements;
                    b.thick = std::min(b.thick, thick[e]);
                }
        for (const Block& b : all) {
            // Of what is solid: a rod that is thinner than a block is pressed no less for the air around it.
            const double pressed = -principal_of(b.stress)[0] / std::max(1, b.elements);
            if (!(pressed > 0)) continue;
            double stresses = 0, strains = 0;
            for (size_t i = 0; i < 3; ++i) {
                stresses += b.stress[i] * b.stress[i] + 2 * b.stress[i + 3] * b.stress[i + 3];
                strains += b.strain[i] * b.strain[i] + b.strain[i + 3] * b.strain[i + 3] / 2;
            }
            const double young = std::sqrt(stresses / std::max(strains, 1e-300));
            double& one = least[static_cast<size_t>(layer)];
            one =
                std::min(one, strut_factor(young, static_cast<double>(b.thick) / longest, pressed));
        }
    });
    return *std::ranges::min_element(least);
}

}  // namespace

double least_buckling_factor(const PartProblem& p, const PartFields& fields, Vector* moved,
                             bool dithered, size_t* where) {
    double longest = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, p.grid.elements[a] * p.grid.pitch_mm[a]);
    const std::vector<float> thick = thickness_of(p);
    if (dithered) return least_of_blocks(p, moved, thick, longest);
    double least = 1e6;
    for (size_t e = 0; e < thick.size(); ++e) {
        const double pressed = -static_cast<double>(fields.compression_MPa[e]);
        if (p.elements.kind[e] != kSolid || !(pressed > 0)) continue;
        const double share = static_cast<double>(p.voxels.solid[e]),
                     lambda = static_cast<double>(p.voxels.lambda[e]) / share,
                     mu = static_cast<double>(p.voxels.mu[e]) / share;
        const double young = mu * (3 * lambda + 2 * mu) / (lambda + mu);
        const double slender = static_cast<double>(thick[e]) / longest;
        const double factor = strut_factor(young, slender, pressed);
        if (factor >= least) continue;
        least = factor;
        if (where) *where = e;
    }
    return least;
}

int64_t buckling_bytes(const Grid& grid) {
    const int64_t field = int64_t{grid.nodes[0] + 2} * grid.nodes[1] * grid.nodes[2] * kElastic * 8;
    // Eleven fields besides those of a solution and what is moved, six stresses and what is known of elements.
    constexpr int64_t kMore = 11;
    return part_bytes(grid) + kMore * field + (6 + 4) * 4 * grid.element_count();
}

Buckling buckling_of(PartProblem* problem, Vector* moved, double far, const SolveOptions& options,
                     int most_work) {
    PartProblem& p = *problem;
    Buckling out;
    ElementValues values{std::move(p.voxels.lambda), std::move(p.voxels.mu), 1};
    values.normalise();
    FixedNodes fixed;
    for (const Held& h : p.held)
        fixed.push_back(h.dof);
    {
        const ElementOperator<kElastic> a(p.grid, &values, &fixed);
        const GeometricOperator b(p, values, moved);
        Search search(p.grid, a, b, options, most_work);
        search.run(far, &out);
        // Of what is solid: elsewhere nothing resists, and the shape is whatever the search began with.
        double most = 0;
        for (int64_t e = 0; out.factor > 0 && e < p.grid.element_count(); ++e) {
            if (p.elements.kind[static_cast<size_t>(e)] != kSolid) continue;
            const std::array<int32_t, 3> first = place_of(p.grid, e);
            for (const uint8_t d : {uint8_t{4}, uint8_t{5}}) {
                const std::array<int64_t, 4> nodes = nodes_of(p.grid, {e, d});
                for (size_t k = 0; k < 4; ++k) {
                    const Vec3 u = moved_at(search.shape(), nodes[k]);
                    const double length = std::hypot(u[0], u[1], u[2]);
                    if (length <= most) continue;
                    most = length;
                    const size_t at[3] = {k % 2, k / 2, d - size_t{4}};
                    for (size_t c = 0; c < 3; ++c) {
                        out.moves[c] = u[c] / length;
                        out.moves_at_mm[c] =
                            p.voxels.origin_mm[c] +
                            (first[c] + static_cast<double>(at[c])) * p.grid.pitch_mm[c];
                    }
                }
            }
        }
    }
    values.restore();
    p.voxels.lambda = std::move(values.first);
    p.voxels.mu = std::move(values.second);
    return out;
}

}  // namespace openfab::mechanics
