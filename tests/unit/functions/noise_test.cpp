// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Checks what compiler/functions/README.md states about noises and hashes: ranges, periods, seeds,
// zeros at lattice points, gradients, continuity, and the quality of the hash.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "compiler/functions/functions.h"
#include "compiler/functions/perlin.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::functions {

namespace {

using ir::Op;
using Point = std::vector<float>;

#ifdef OPENFAB_SANITIZED
constexpr int kPoints = 20000;
constexpr double kCorrelation = 0.06;  ///< the correlation that this many points may show by chance
#else
constexpr int kPoints = 300000;
constexpr double kCorrelation = 0.03;
#endif

float noise(Op op, const Point& p, int32_t which, uint32_t seed,
            const std::vector<int32_t>& periods = {}) {
    ir::Instr instr;
    instr.op = op;
    instr.a = which + (periods.empty() ? 0 : ir::kPeriodic);
    std::vector<uint32_t> args;
    for (const float x : p)
        args.push_back(ir::as_bits(x));
    for (const int32_t period : periods)
        args.push_back(ir::as_bits(period));
    args.push_back(seed);
    return ir::as_float(evaluate(instr, args));
}

class Points {
  public:
    explicit Points(uint32_t seed) : random_(seed) {}
    float unit() { return static_cast<float>(random_() >> 8) * 0x1p-24f; }
    Point point(size_t axes, float size) {
        Point out(axes);
        for (float& x : out)
            x = (unit() - 0.5f) * size;
        return out;
    }
    uint32_t draw() { return static_cast<uint32_t>(random_()); }

  private:
    std::mt19937 random_;
};

struct Extremes {
    float least = 0;
    float most = 0;
    double sum = 0;
};

/// The range of a noise over many cells and seeds; half the points at cell centers, where it is
/// large.
Extremes extremes(Op op, size_t axes, int32_t which) {
    Points points(11);
    Extremes out;
    for (int k = 0; k < kPoints; ++k) {
        Point p = points.point(axes, 4000.0f);
        for (float& x : p) {
            if (k % 2 == 0) x = std::floor(x) + 0.3f + 0.4f * points.unit();
        }
        const float value = noise(op, p, which, points.draw());
        out.least = std::min(out.least, value);
        out.most = std::max(out.most, value);
        out.sum += value;
    }
    return out;
}

TEST(Noise, StaysInItsRange) {
    for (size_t axes = 1; axes <= 4; ++axes) {
        for (const Op op : {Op::kNoise, Op::kSimplex}) {
            if (op == Op::kSimplex && axes == 1) continue;
            const Extremes e = extremes(op, axes, 0);
            SCOPED_TRACE(::testing::Message() << ir::spelling(op) << ' ' << axes);
            EXPECT_GE(e.least, -1.0f);
            EXPECT_LE(e.most, 1.0f);
            // And most of the range is used.
            EXPECT_LT(e.least, -0.6f);
            EXPECT_GT(e.most, 0.6f);
            EXPECT_NEAR(e.sum / kPoints, 0.0, 0.005);
        }
    }
}

/// All 12 gradients at all 8 corners are independent, so the largest value at a point is the sum of
/// the corners' maxima: bounded over a cell by branch and bound.
TEST(Noise, LargestValueOfThreeAxesIsBelowOne) {
    const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const auto largest = [&](const std::array<double, 3>& t) {
        double sum = 0;
        for (uint32_t corner = 0; corner < 8; ++corner) {
            double weight = 1;
            std::array<double, 3> d{};
            for (size_t k = 0; k < 3; ++k) {
                const bool upper = (corner >> k & 1u) != 0;
                weight *= upper ? fade(t[k]) : 1 - fade(t[k]);
                d[k] = std::abs(t[k] - (upper ? 1 : 0));
            }
            // The two greatest of three components.
            sum += weight * (d[0] + d[1] + d[2] - std::min({d[0], d[1], d[2]}));
        }
        return sum * kPerlinScales[2];
    };
    // No slope along an axis exceeds 3.65: in a cube of half side h it grows by 11 h at most.
    constexpr double kSlope = 11;
    struct Cube {
        std::array<double, 3> centre;
        double half;
    };
    std::vector<Cube> open = {{{0.25, 0.25, 0.25}, 0.25}};  // the others by symmetry
    size_t visited = 0;
    while (!open.empty()) {
        const Cube cube = open.back();
        open.pop_back();
        ++visited;
        const double value = largest(cube.centre);
        ASSERT_LT(value, 1.0);
        if (value + kSlope * cube.half < 1.0) continue;
        for (uint32_t octant = 0; octant < 8; ++octant) {
            Cube part{cube.centre, cube.half / 2};
            for (size_t k = 0; k < 3; ++k)
                part.centre[k] += (octant >> k & 1u) != 0 ? part.half : -part.half;
            open.push_back(part);
        }
        ASSERT_LT(visited, 20000000u);
    }
}

TEST(Noise, IsZeroAtLatticePoints) {
    Points points(3);
    for (size_t axes = 1; axes <= 4; ++axes) {
        for (int k = 0; k < 1000; ++k) {
            Point p = points.point(axes, 8000000.0f);
            for (float& x : p)
                x = std::round(x);
            EXPECT_EQ(noise(Op::kNoise, p, 0, points.draw()), 0.0f);
        }
    }
}

TEST(Noise, RepeatsAfterItsPeriod) {
    Points points(4);
    for (size_t axes = 1; axes <= 4; ++axes) {
        for (int k = 0; k < 2000; ++k) {
            const Point p = points.point(axes, 64.0f);
            std::vector<int32_t> periods;
            Point shifted = p;
            for (size_t axis = 0; axis < axes; ++axis) {
                // Coordinates that keep their fraction when a whole number is added.
                shifted[axis] = std::round(p[axis] * 4096.0f) / 4096.0f;
                periods.push_back(1 + static_cast<int32_t>(points.draw() % 9));
            }
            const Point first = shifted;
            for (size_t axis = 0; axis < axes; ++axis) {
                const auto turns = static_cast<float>(static_cast<int>(points.draw() % 7) - 3);
                shifted[axis] += turns * static_cast<float>(periods[axis]);
            }
            EXPECT_EQ(noise(Op::kNoise, first, 0, 9, periods),
                      noise(Op::kNoise, shifted, 0, 9, periods));
        }
    }
    // With a long period the noise equals the aperiodic one, for positive coordinates.
    EXPECT_EQ(noise(Op::kNoise, {3.3f, 5.1f}, 0, 7, {1000, 1000}),
              noise(Op::kNoise, {3.3f, 5.1f}, 0, 7));
    EXPECT_EQ(noise(Op::kNoise, {0.25f}, 0, 7, {0}), noise(Op::kNoise, {5.25f}, 0, 7, {1}));
}

/// Pearson correlation of a noise with itself under another seed or shifted by whole cells.
double correlation(Op op, size_t axes, uint32_t seed, float shift) {
    Points points(5);
    double sum = 0;
    double squares = 0;
    for (int k = 0; k < kPoints / 6; ++k) {
        Point p = points.point(axes, axes == 1 ? 100000.0f : 500.0f);
        const float a = noise(op, p, 0, 0);
        p[0] += shift;
        const float b = noise(op, p, 0, seed);
        sum += static_cast<double>(a) * b;
        squares += 0.5 * (static_cast<double>(a) * a + static_cast<double>(b) * b);
    }
    return sum / squares;
}

TEST(Noise, SeedsAndPlacesHaveNothingInCommon) {
    for (size_t axes = 1; axes <= 3; ++axes) {
        for (const uint32_t seed : {1u, 2u, 256u, 0x80000000u}) {
            EXPECT_NEAR(correlation(Op::kNoise, axes, seed, 0), 0.0, kCorrelation)
                << axes << ' ' << seed;
            EXPECT_NEAR(correlation(Op::kNoise, axes, seed, 1), 0.0, kCorrelation)
                << axes << ' ' << seed;
        }
        // Neighbours share a gradient.
        for (const float shift : {2.0f, 16.0f, 256.0f, 65536.0f})
            EXPECT_NEAR(correlation(Op::kNoise, axes, 0, shift), 0.0, 2 * kCorrelation)
                << axes << shift;
    }
}

/// Analytic gradients against differences.
TEST(Noise, GradientsAreRight) {
    Points points(6);
    for (const Op op : {Op::kNoise, Op::kSimplex}) {
        for (size_t axes = op == Op::kNoise ? 1 : 2; axes <= 4; ++axes) {
            for (int k = 0; k < 3000; ++k) {
                const Point p = points.point(axes, 10.0f);
                const size_t axis = points.draw() % axes;
                Point before = p;
                Point after = p;
                before[axis] -= 0.005f;
                after[axis] += 0.005f;
                const float step = after[axis] - before[axis];
                const float difference = (noise(op, after, 0, 1) - noise(op, before, 0, 1)) / step;
                EXPECT_NEAR(noise(op, p, static_cast<int32_t>(axis) + 1, 1), difference, 0.02f)
                    << ir::spelling(op) << ' ' << axes;
            }
        }
    }
}

/// Nearest distances are 1-Lipschitz, across cell borders, too.
TEST(Cellular, DistancesAreContinuous) {
    Points points(7);
    for (size_t axes = 2; axes <= 3; ++axes) {
        float most = 0;
        for (int k = 0; k < kPoints / 10; ++k) {
            const Point p = points.point(axes, 50.0f);
            Point q = p;
            float square = 0;
            for (float& x : q) {
                const float step = (points.unit() - 0.5f) * 0.02f;
                x += step;
                square += step * step;
            }
            for (const int32_t which : {0, 1}) {
                const float a = noise(Op::kCellular, p, which, 3);
                const float b = noise(Op::kCellular, q, which, 3);
                EXPECT_LE(std::abs(a - b), std::sqrt(square) + 1e-5f);
                EXPECT_GE(a, 0.0f);
                EXPECT_LE(a, 1.0f);
                most = std::max(most, a);
            }
            EXPECT_LE(noise(Op::kCellular, p, 0, 3), noise(Op::kCellular, p, 1, 3));
            const float id = noise(Op::kCellular, p, 2, 3);
            EXPECT_TRUE(id >= 0.0f && id < 1.0f);
        }
        EXPECT_GT(most, 0.9f);
    }
}

/// Each input bit flips each output bit in half of all cases.
TEST(Hash, Avalanches) {
    Points points(8);
    constexpr int kDraws = kPoints / 6;
    for (size_t words = 1; words <= 3; ++words) {
        for (uint32_t bit = 0; bit < 32 * words; bit += 3) {
            std::array<int, 32> flips{};
            for (int k = 0; k < kDraws; ++k) {
                // Small numbers too, as lattice coordinates are.
                std::vector<uint32_t> list(words);
                for (uint32_t& word : list)
                    word = k % 2 == 0 ? points.draw() : points.draw() % 65536;
                const uint32_t before = hash<Plain>(list, 0);
                list[bit / 32] ^= 1u << (bit % 32);
                const uint32_t change = before ^ hash<Plain>(list, 0);
                for (uint32_t out = 0; out < 32; ++out)
                    flips[out] += static_cast<int>(change >> out & 1u);
            }
            // Six standard deviations.
            for (const int count : flips)
                EXPECT_NEAR(count, kDraws / 2, 3 * std::sqrt(kDraws) + kDraws * 0.004);
        }
    }
}

/// The hashes of one list are independent, and so are those of lists with swapped words.
TEST(Hash, ResultsAreIndependent) {
    int equal = 0;
    for (uint32_t x = 0; x < 1000; ++x) {
        for (uint32_t which = 1; which < 4; ++which) {
            equal += hash<Plain>({x, 5u}, 0) >> 24 == hash<Plain>({x, 5u}, which) >> 24 ? 1 : 0;
            equal += hash<Plain>({x, which}, 0) >> 24 == hash<Plain>({which, x}, 0) >> 24 ? 1 : 0;
        }
    }
    EXPECT_LT(equal, 50);  // 6000 / 256 expected
}

}  // namespace

}  // namespace openfab::functions
