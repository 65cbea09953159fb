// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/polygon.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace openfab::mesh {
namespace {

TEST(Polygon, TriangulatesConcaveOnesWithoutOverlap) {
    // An L; fans from its first corner would leave it.
    const std::vector<Vec3d> l = {{0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}};
    double area = 0;
    int64_t effort = kTriangulationEffort;
    for (const auto& t : triangulate(l, &effort)) {
        const auto p = [&](size_t i) { return l[t[i]]; };
        const double part = cross(p(1) - p(0), p(2) - p(0)).z / 2;
        EXPECT_GT(part, 0);
        area += part;
    }
    EXPECT_EQ(area, 3);
    EXPECT_EQ(triangulate({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, &effort),
              (std::vector<std::array<int32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

/// Same as triangulate, but tests everything again for each triangle.
std::vector<std::array<int32_t, 3>> clip_ears(const std::vector<Vec3d>& p) {
    Vec3d normal;
    for (size_t i = 1; i + 1 < p.size(); ++i)
        normal = normal + cross(p[i] - p[0], p[i + 1] - p[0]);
    const auto turn = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        return dot(cross(b - a, c - a), normal);
    };
    std::vector<int32_t> ring(p.size());
    std::iota(ring.begin(), ring.end(), 0);
    const auto at = [&](size_t i) { return p[static_cast<size_t>(ring[i % ring.size()])]; };
    const auto is_ear = [&](size_t i) {
        const size_t n = ring.size();
        const Vec3d a = at(i + n - 1), b = at(i), c = at(i + 1);
        if (!(turn(a, b, c) > 0)) return false;
        for (size_t k = i + 2; k < i + n - 1; ++k) {
            const Vec3d q = at(k);
            if (q == a || q == b || q == c) continue;
            if (turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0) return false;
        }
        return true;
    };
    std::vector<std::array<int32_t, 3>> out;
    while (ring.size() > 3) {
        size_t ear = 0;
        while (ear < ring.size() && !is_ear(ear))
            ++ear;
        if (ear == ring.size()) ear = 0;
        const size_t m = ring.size();
        out.push_back({ring[(ear + m - 1) % m], ring[ear], ring[(ear + 1) % m]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    out.push_back({ring[0], ring[1], ring[2]});
    return out;
}

TEST(Polygon, FindsTheEarsThatALongSearchFinds) {
    std::mt19937 random(3);
    const auto below = [&](unsigned n) { return static_cast<double>(random() % n); };
    for (int round = 0; round < 2000; ++round) {
        // Stars, and random corners, which cross and touch each other.
        const size_t n = 5 + random() % 30;
        std::vector<Vec3d> p = {{0, 0, 0}};
        for (size_t i = 1; i < n; ++i) {
            const double a = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(n);
            const double r = 1 + below(9);
            p.push_back(round % 2 == 0 ? Vec3d{r * std::cos(a), r * std::sin(a), 0}
                                       : Vec3d{below(6), below(6), below(2)});
        }
        int64_t effort = kTriangulationEffort;
        const auto found = triangulate(p, &effort);
        // Convex ones are fans, which ears need not be.
        if (found[0] == std::array<int32_t, 3>{0, 1, 2}) continue;
        ASSERT_EQ(found, clip_ears(p)) << round;
    }
}

}  // namespace
}  // namespace openfab::mesh
