// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Foams against the polyhedra of all sites around a point, cut out plane by plane in double
// precision.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

LibraryFunction function(const std::string& expression) {
    return LibraryFunction::of("voronoi", expression);
}

double dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec along(const Vec& a, const Vec& b, double t) {
    return {a[0] + b[0] * t, a[1] + b[1] * t, a[2] + b[2] * t};
}

struct Plane {
    Vec normal;
    double from_p;
};

/// The polyhedron around p: planes from it outwards.
std::vector<Plane> polyhedron(const std::vector<Vec>& sites, const Vec& p) {
    const auto square = [&](const Vec& s) {
        const Vec off = along(s, p, -1);
        return dot(off, off);
    };
    const Vec own = *std::ranges::min_element(sites, {}, square);
    std::vector<Plane> out;
    for (const Vec& s : sites) {
        Vec n = along(s, own, -1);
        const double length = std::sqrt(dot(n, n));
        if (length == 0) continue;
        n = along({}, n, 1 / length);
        const Vec middle = along(along({}, own, 0.5), s, 0.5);
        out.push_back({n, dot(along(middle, p, -1), n)});
    }
    std::ranges::sort(out, {}, &Plane::from_p);
    return out;
}

/// The nearest edge, and how far its nearest point is from being cut off by a third plane.
std::array<double, 2> nearest_edge(const std::vector<Plane>& planes) {
    std::array<double, 2> best = {1e9, 0};
    const size_t count = std::min<size_t>(planes.size(), 24);
    for (size_t i = 0; i < count; ++i) {
        for (size_t j = i + 1; j < count; ++j) {
            const double c = dot(planes[i].normal, planes[j].normal), a = planes[i].from_p,
                         b = planes[j].from_p;
            if (1 - c * c < 1e-6) continue;
            // The foot is u n_i + v n_j.
            const double u = (a - b * c) / (1 - c * c), v = (b - a * c) / (1 - c * c);
            const Vec foot = along(along({}, planes[i].normal, u), planes[j].normal, v);
            double room = 1e9;
            for (size_t k = 0; k < planes.size(); ++k) {
                if (k != i && k != j)
                    room = std::min(room, planes[k].from_p - dot(foot, planes[k].normal));
            }
            const double d = std::sqrt(dot(foot, foot));
            if (room > 0 && d < best[0]) best = {d, room};
        }
    }
    return best;
}

TEST(Voronoi, FacesAndEdgesAreThoseOfThePolyhedra) {
    constexpr double kCell = 4;
    const std::array<LibraryFunction, 3> site = {function("voronoi_site(p, 4, 0.6, 3).x"),
                                                 function("voronoi_site(p, 4, 0.6, 3).y"),
                                                 function("voronoi_site(p, 4, 0.6, 3).z")};
    std::vector<Vec> sites;
    for (int x = -3; x <= 3; ++x) {
        for (int y = -3; y <= 3; ++y) {
            for (int z = -3; z <= 3; ++z) {
                const Vec index = {double(x), double(y), double(z)};
                sites.push_back({site[0](index), site[1](index), site[2](index)});
                for (size_t k = 0; k < 3; ++k) {
                    EXPECT_GE(sites.back()[k], (index[k] + 0.2) * kCell - 1e-4);
                    EXPECT_LE(sites.back()[k], (index[k] + 0.8) * kCell + 1e-4);
                }
            }
        }
    }
    const LibraryFunction walls = function("voronoi_walls(p, 4, 0.6, 0.5, 3)");
    const LibraryFunction struts = function("voronoi_struts(p, 4, 0.6, 0.4, 3)");
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-kCell, kCell);
    int edges = 0;
    for (int k = 0; k < 400; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        const std::vector<Plane> planes = polyhedron(sites, p);
        EXPECT_NEAR(walls(p), planes[0].from_p - 0.25, 1e-4);
        const auto [edge, room] = nearest_edge(planes);
        // Away from nodes, to a strut of up to a fifth of the cell.
        if (edge > 0.8 || room < 0.4) continue;
        EXPECT_NEAR(struts(p), edge - 0.4, 2e-3);
        ++edges;
    }
    EXPECT_GT(edges, 60);
}

}  // namespace
}  // namespace openfab::testing
