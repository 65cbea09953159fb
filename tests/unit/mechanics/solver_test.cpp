// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The solver against closed forms, a dense twin and itself on other threads and instruction sets.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>
#include <vector>

#include "mechanics/solver/conjugate_gradients.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {
namespace {

struct Elastic {
    double young, poisson;
    double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
    double mu() const { return young / (2 * (1 + poisson)); }
};

ElementValues uniform(const Grid& g, const Elastic& m) {
    ElementValues v;
    v.first.assign(static_cast<size_t>(g.element_count()), static_cast<float>(m.lambda()));
    v.second.assign(static_cast<size_t>(g.element_count()), static_cast<float>(m.mu()));
    return v;
}

/// The stiffness of a hexahedron by Gauss points, with the volumetric strain of the middle (B-bar).
std::vector<double> dense_element(const std::array<double, 3>& h, double lambda, double mu) {
    std::vector<double> k(24 * 24);
    const double g = 1 / std::sqrt(3.0);
    const auto b_at = [&](double x, double y, double z) {
        std::array<std::array<double, 24>, 6> b{};
        for (size_t n = 0; n < 8; ++n) {
            const double s[3] = {n & 1 ? 1. : -1., n >> 1 & 1 ? 1. : -1., n >> 2 ? 1. : -1.};
            const double f[3] = {1 + s[0] * x, 1 + s[1] * y, 1 + s[2] * z};
            const double d[3] = {s[0] * f[1] * f[2] / 4 / h[0], f[0] * s[1] * f[2] / 4 / h[1],
                                 f[0] * f[1] * s[2] / 4 / h[2]};
            for (size_t c = 0; c < 3; ++c)
                b[c][3 * n + c] = d[c];
            b[3][3 * n + 1] = d[2];
            b[3][3 * n + 2] = d[1];
            b[4][3 * n] = d[2];
            b[4][3 * n + 2] = d[0];
            b[5][3 * n] = d[1];
            b[5][3 * n + 1] = d[0];
        }
        return b;
    };
    const auto middle = b_at(0, 0, 0);
    for (int p = 0; p < 8; ++p) {
        auto b = b_at(p & 1 ? g : -g, p & 2 ? g : -g, p & 4 ? g : -g);
        for (size_t j = 0; j < 24; ++j) {
            const double own = (b[0][j] + b[1][j] + b[2][j]) / 3;
            const double mean = (middle[0][j] + middle[1][j] + middle[2][j]) / 3;
            for (size_t c = 0; c < 3; ++c)
                b[c][j] += mean - own;
        }
        for (size_t i = 0; i < 24; ++i)
            for (size_t j = 0; j < 24; ++j) {
                const double ti = b[0][i] + b[1][i] + b[2][i], tj = b[0][j] + b[1][j] + b[2][j];
                double sum = lambda * ti * tj;
                for (size_t c = 0; c < 6; ++c)
                    sum += (c < 3 ? 2 : 1) * mu * b[c][i] * b[c][j];
                k[i * 24 + j] += sum * h[0] * h[1] * h[2] / 8;
            }
    }
    return k;
}

TEST(MechanicsElement, IsTheHexahedronOfTextbooks) {
    const std::array<double, 3> h{0.5, 1, 1.25};
    const std::vector<double> a = ElementOperator<3>::element_matrix(h, 0);
    const std::vector<double> b = ElementOperator<3>::element_matrix(h, 1);
    const std::vector<double> first = dense_element(h, 1, 0), second = dense_element(h, 0, 1);
    for (size_t i = 0; i < a.size(); ++i) {
        EXPECT_NEAR(a[i], first[i], 1e-14);
        EXPECT_NEAR(b[i], second[i], 1e-14);
    }
}

TEST(MechanicsElement, PatchTest) {
    // Nodes of a surface are moved by a linear field; those inside follow it, whatever elements are
    // like along z... of one material.
    const Grid g = Grid::make({5, 6, 7}, {0.5, 1, 0.8}, false);
    ElementValues v = uniform(g, {3, 0.3});
    v.normalise();
    const double slope[3][3] = {{1e-3, 2e-3, -1e-3}, {5e-4, -2e-3, 3e-3}, {-4e-4, 1e-3, 2e-3}};
    FixedNodes fixed;
    Field<double, 3> prescribed(g), b(g), x(g);
    const auto at = [&](int c, int32_t i, int32_t j, int32_t k) {
        const auto s = static_cast<size_t>(c);
        return slope[s][0] * i * 0.5 + slope[s][1] * j * 1.0 + slope[s][2] * k * 0.8;
    };
    for (int32_t k = 0; k < g.nodes[2]; ++k)
        for (int32_t j = 0; j < g.nodes[1]; ++j)
            for (int32_t i = 0; i < g.nodes[0]; ++i) {
                if (i > 0 && j > 0 && k > 0 && i < 5 && j < 6 && k < 7) continue;
                for (int c = 0; c < 3; ++c) {
                    fixed.push_back(((int64_t{k} * g.nodes[1] + j) * g.nodes[0] + i) * 3 + c);
                    prescribed.row(c, j, k)[i] = at(c, i, j, k);
                }
            }
    const FixedNodes none;
    const ElementOperator<3> whole(g, &v, &none), inner(g, &v, &fixed);
    whole.apply(&prescribed, &b);
    for (int32_t k = 0; k < g.nodes[2]; ++k)
        for (size_t n = 0; n < b.plane_size(); ++n)
            b.plane(k)[n] *= -1;
    Multigrid<3> multigrid(inner, {});
    SolveOptions options;
    options.tolerance = 1e-9;
    const SolveReport report = solve(inner, &multigrid, &b, &x, options);
    EXPECT_TRUE(report.converged);
    for (int32_t k = 1; k < 7; ++k)
        for (int32_t j = 1; j < 6; ++j)
            for (int32_t i = 1; i < 5; ++i)
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(x.row(c, j, k)[i], at(c, i, j, k), 1e-8);
}

/// A cube of 0 and 1 in which no two of one kind are favoured.
ElementValues hard(const Grid& g, double share, double soft) {
    std::mt19937 random(7);
    ElementValues v;
    const Elastic m{1, 0.35};
    for (int64_t i = 0; i < g.element_count(); ++i) {
        const double e = random() < share * 4294967296.0 ? 1 : soft;
        v.first.push_back(static_cast<float>(e * m.lambda()));
        v.second.push_back(static_cast<float>(e * m.mu()));
    }
    return v;
}

/// Solves for a strain of a periodic cell.
SolveReport strained(const Grid& g, const ElementValues& v, Field<double, 3>* x) {
    const FixedNodes none;
    const ElementOperator<3> a(g, &v, &none);
    Multigrid<3> multigrid(a, {});
    Field<double, 3> b(g);
    *x = Field<double, 3>(g);
    const double strain[6] = {1, 0, 0, 0, 0, 0};
    a.apply(x, &b, strain);
    for (int32_t z = 0; z < g.nodes[2]; ++z)
        for (size_t n = 0; n < b.plane_size(); ++n)
            b.plane(z)[n] *= -1;
    return solve(a, &multigrid, &b, x, {});
}

TEST(MechanicsSolver, ConvergesOnHardContrastsAndVoid) {
    const Grid g = Grid::make({24, 24, 24}, {1, 1, 1}, true);
    for (const double share : {0.3, 0.5})
        for (const double soft : {0.6 / 2000, 0.0}) {
            Field<double, 3> x;
            const SolveReport report = strained(g, hard(g, share, soft), &x);
            EXPECT_TRUE(report.converged) << share << " " << soft << " " << report.residual;
            EXPECT_LE(report.iterations, 60) << share << " " << soft;
        }
}

TEST(MechanicsSolver, OddPeriodicGridsConvergeAsEvenOnes) {
    const Grid g = Grid::make({25, 21, 23}, {1, 1, 1}, true);
    Field<double, 3> x;
    const SolveReport report = strained(g, hard(g, 0.5, 0.01), &x);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.iterations, 40);
}

TEST(MechanicsSolver, SaysWhereItDidNotConverge) {
    const Grid g = Grid::make({16, 16, 16}, {1, 1, 1}, true);
    const ElementValues v = hard(g, 0.3, 0.001);
    const FixedNodes none;
    const ElementOperator<3> a(g, &v, &none);
    Multigrid<3> multigrid(a, {});
    Field<double, 3> b(g), x(g);
    const double strain[6] = {1, 0, 0, 0, 0, 0};
    a.apply(&x, &b, strain);
    SolveOptions options;
    options.most_iterations = 3;
    const SolveReport report = solve(a, &multigrid, &b, &x, options);
    EXPECT_FALSE(report.converged);
    EXPECT_GT(report.residual, options.tolerance);
}

/// Stiff bodies and thin soft layers between: elements of layers at x, y or z divisible by `every`.
template <int C>
ElementValues layered(const Grid& g, int32_t every, float soft) {
    ElementValues v;
    const Elastic m{1, 0.35};
    for (int32_t z = 0; z < g.elements[2]; ++z)
        for (int32_t y = 0; y < g.elements[1]; ++y)
            for (int32_t x = 0; x < g.elements[0]; ++x) {
                const bool joint = (z + 1) % every == 0 || (y > 0 && y % 17 == 0);
                const float e = joint ? soft : 1;
                v.first.push_back(C == 3 ? e * static_cast<float>(m.lambda()) : e);
                if (C == 3) v.second.push_back(e * static_cast<float>(m.mu()));
            }
    return v;
}

/// Held below, pushed aside at the top.
template <int C>
SolveReport pushed(const Grid& g, const ElementValues& v, bool bodies, Field<double, C>* x) {
    FixedNodes fixed;
    for (int64_t n = 0; n < int64_t{g.nodes[0]} * g.nodes[1] * C; ++n)
        fixed.push_back(n);
    const ElementOperator<C> a(g, &v, &fixed);
    SolveOptions options;
    options.multigrid.bodies = bodies;
    Multigrid<C> multigrid(a, options.multigrid);
    Field<double, C> b(g);
    *x = Field<double, C>(g);
    for (int32_t y = 0; y < g.nodes[1]; ++y)
        for (int32_t i = 0; i < g.nodes[0]; ++i)
            b.row(0, y, g.nodes[2] - 1)[i] = 1 + 0.01 * i;
    return solve(a, &multigrid, &b, x, options);
}

TEST(MechanicsSolver, BodiesThatThinSoftLayersJoinMoveAsWholes) {
    const Grid g = Grid::make({32, 31, 33}, {1, 1, 1}, false);
    for (const int32_t every : {11, 15, 33}) {
        const ElementValues v = layered<3>(g, every, 0.6F / 2000);
        Field<double, 3> x, plain;
        const SolveReport with = pushed<3>(g, v, true, &x),
                          without = pushed<3>(g, v, false, &plain);
        EXPECT_TRUE(with.converged) << with.residual;
        // Of 15 the uppermost plate has three elements, and bends.
        EXPECT_LE(with.iterations, every == 15 ? 70 : 40) << every;
        EXPECT_LE(with.iterations, without.iterations) << every;
        // It is the same solution.
        EXPECT_NEAR(dot(x, plain) / dot(x, x), 1, 1e-4);
        Field<double, 1> warm;
        const ElementValues k = layered<1>(g, every, 1e-5F);
        const SolveReport scalar = pushed<1>(g, k, true, &warm);
        EXPECT_TRUE(scalar.converged) << scalar.residual;
        EXPECT_LE(scalar.iterations, 30) << every;
    }
}

TEST(MechanicsSolver, WithBodiesTheCycleIsSymmetric) {
    const Grid g = Grid::make({12, 18, 15}, {1, 0.8, 1.2}, false);
    const ElementValues v = layered<3>(g, 5, 0.001F);
    FixedNodes fixed;
    for (int64_t n = 0; n < int64_t{g.nodes[0]} * g.nodes[1] * 3; ++n)
        fixed.push_back(n);
    const ElementOperator<3> a(g, &v, &fixed);
    Multigrid<3> multigrid(a, {});
    Field<double, 3> p(g), q(g);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> value(-1, 1);
    for (Field<double, 3>* f : {&p, &q}) {
        for (int32_t z = 0; z < g.nodes[2]; ++z)
            for (int32_t y = 0; y < g.nodes[1]; ++y)
                for (int c = 0; c < 3; ++c)
                    for (int32_t x = 0; x < g.nodes[0]; ++x)
                        f->row(c, y, z)[x] = value(random);
        a.fix(f);
    }
    const double one = dot(multigrid.apply(p), q), other = dot(multigrid.apply(q), p);
    EXPECT_NEAR(one / other, 1, 1e-3);
    EXPECT_GT(dot(multigrid.apply(p), p), 0);
}

TEST(MechanicsSolver, SameBitsForAnyNumberOfThreads) {
    const Grid g = Grid::make({18, 20, 19}, {1, 1, 1}, true);
    const ElementValues v = hard(g, 0.5, 0.01);
    double sums[2];
    for (const int threads : {1, 4}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<size_t>(threads));
        Field<double, 3> x, y;
        strained(g, v, &x);
        pushed<3>(Grid::make({18, 20, 19}, {1, 1, 1}, false),
                  layered<3>(Grid::make({18, 20, 19}, {1, 1, 1}, false), 7, 0.001F), true, &y);
        sums[threads == 1 ? 0 : 1] = dot(x, x) + dot(y, y);
    }
    EXPECT_EQ(sums[0], sums[1]);
}

TEST(MechanicsSolver, SameBitsForInstructionSets) {
    constexpr int32_t n = 37;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> value(-1, 1);
    std::vector<float> in(12 * (n + 1)), lambda(n), mu(n), scratch(36 * (n + 1));
    for (std::vector<float>* all : {&in, &lambda, &mu})
        for (float& f : *all)
            f = value(random);
    const ElementShape<float> shape = element_shape<float>({0.7, 1, 1.3});
    std::vector<std::vector<float>> results;
    for (const int limit : {0, 1, 2}) {
        std::vector<float> out(in.size());
        const float* from[12];
        float* to[12];
        for (size_t r = 0; r < 12; ++r) {
            from[r] = in.data() + r * (n + 1);
            to[r] = out.data() + r * (n + 1);
        }
        row_kernels(limit).elastic_float(shape, n, lambda.data(), mu.data(), from, to, nullptr,
                                         scratch.data());
        results.push_back(out);
    }
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

/// Numbers between -1 and 1.
std::vector<float> numbers(size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> value(-1, 1);
    std::vector<float> out(count);
    for (float& f : out)
        f = value(random);
    return out;
}

TEST(MechanicsSolver, RowsOfStencilsAreTheirSumsForEachWidth) {
    for (const int32_t n : {1, 3, 4, 15, 16, 23, 37}) {
        const auto count = static_cast<size_t>(n);
        const std::vector<float> block = numbers(27 * 9 * count, 5),
                                 in = numbers(27 * 3 * count, 6);
        const float* blocks[27];
        const float* from[81];
        for (size_t o = 0; o < 27; ++o) {
            blocks[o] = o == 4 || o == 22 ? nullptr : block.data() + 9 * o * count;
            for (size_t c = 0; c < 3; ++c)
                from[3 * o + c] = in.data() + (3 * o + c) * count;
        }
        std::vector<double> expected(3 * count);
        for (size_t o = 0; o < 27; ++o)
            for (size_t c = 0; c < 3 && blocks[o]; ++c)
                for (size_t d = 0; d < 3; ++d)
                    for (size_t x = 0; x < count; ++x)
                        expected[c * count + x] +=
                            double{blocks[o][(o < 13 ? 3 * d + c : 3 * c + d) * count + x]} *
                            double{from[3 * o + d][x]};
        std::vector<std::vector<float>> results;
        for (const int limit : {0, 1, 2}) {
            std::vector<float> out(3 * count, 9);
            float* to[3] = {out.data(), out.data() + count, out.data() + 2 * count};
            row_kernels(limit).stencil3(n, count, blocks, from, to);
            results.push_back(out);
        }
        EXPECT_EQ(results[0], results[1]) << n;
        EXPECT_EQ(results[0], results[2]) << n;
        for (size_t i = 0; i < expected.size(); ++i)
            EXPECT_NEAR(double{results[0][i]}, expected[i], 1e-5) << n << ", " << i;
    }
}

TEST(MechanicsSolver, StepsOfTheSmootherAreTheirFormulaInEachSet) {
    constexpr size_t n = 37;
    const std::vector<float> w = numbers(n, 1), b = numbers(n, 2), q = numbers(n, 3),
                             d0 = numbers(n, 4), x0 = numbers(n, 5);
    std::vector<std::vector<float>> results;
    for (const int limit : {0, 1, 2}) {
        const RowKernels& k = row_kernels(limit);
        std::vector<float> d = d0, x = x0, first_d = d0, first_x = x0, zero_d = d0, zero_x = x0;
        k.smooth_next(n, 0.25F, 0.5F, w.data(), b.data(), q.data(), d.data(), x.data());
        k.smooth_first(n, 0.5F, w.data(), b.data(), q.data(), first_d.data(), first_x.data());
        k.smooth_first(n, 0.5F, w.data(), b.data(), nullptr, zero_d.data(), zero_x.data());
        for (size_t i = 0; i < n; ++i) {
            const float step = 0.5F * (w[i] * (b[i] - q[i]));
            EXPECT_EQ(d[i], 0.25F * d0[i] + step);
            EXPECT_EQ(x[i], x0[i] + d[i]);
            EXPECT_EQ(first_d[i], step);
            EXPECT_EQ(first_x[i], x0[i] + step);
            EXPECT_EQ(zero_d[i], 0.5F * (w[i] * b[i]));
            EXPECT_EQ(zero_x[i], zero_d[i]);
        }
        results.push_back(x);
    }
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

TEST(MechanicsSolver, TakesAtMost150BytesAnUnknown) {
    const Grid g = Grid::make({128, 128, 128}, {1, 1, 1}, true);
    EXPECT_LE(static_cast<double>(solver_bytes<3>(g)) / (3.0 * static_cast<double>(g.node_count())),
              150);
}

}  // namespace
}  // namespace openfab::mechanics
