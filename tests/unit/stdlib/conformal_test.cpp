// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Conformal cells: sizes are what coordinates really change by, axes stay at right angles, cells
// are whole where they close, and walls are as thick as asked.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

LibraryFunction function(const std::string& expression) {
    return LibraryFunction::of("conformal lattice", expression);
}

Vec gradient(const LibraryFunction& function, const Vec& p) {
    constexpr double kStep = 0.02;
    Vec out;
    for (size_t k = 0; k < 3; ++k) {
        Vec more = p, less = p;
        more[k] += kStep;
        less[k] -= kStep;
        out[k] = (function(more) - function(less)) / (2 * kStep);
    }
    return out;
}

double dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec along(const Vec& a, const Vec& b, double t) {
    return {a[0] + b[0] * t, a[1] + b[1] * t, a[2] + b[2] * t};
}

struct Case {
    const char* name;
    const char* cells;
    Vec low, high;  ///< where in part space
};

class Conformal : public ::testing::TestWithParam<Case> {
  protected:
    /// Returns an expression of the cells `c`.
    LibraryFunction of_cells(const std::string& result) const {
        return {"conformal lattice",
                std::string("Cells c = ") + GetParam().cells + "; return " + result + ";"};
    }
    std::vector<Vec> points(int count) const {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> unit(0, 1);
        std::vector<Vec> out;
        for (int k = 0; k < count; ++k) {
            Vec p;
            for (size_t a = 0; a < 3; ++a)
                p[a] = GetParam().low[a] + (GetParam().high[a] - GetParam().low[a]) * unit(random);
            out.push_back(p);
        }
        return out;
    }
};

TEST_P(Conformal, SizesAreWhatTheCoordinatesChangeBy) {
    const std::array<const char*, 3> axes = {"x", "y", "z"};
    std::vector<LibraryFunction> at, size;
    for (const char* axis : axes) {
        at.push_back(of_cells(std::string("c.at.") + axis));
        size.push_back(of_cells(std::string("c.size.") + axis));
    }
    for (const Vec& p : points(40)) {
        std::array<Vec, 3> slopes;
        for (size_t k = 0; k < 3; ++k) {
            slopes[k] = gradient(at[k], p);
            EXPECT_NEAR(std::sqrt(dot(slopes[k], slopes[k])) * size[k](p), 1, 2e-3) << axes[k];
        }
        for (size_t k = 0; k < 3; ++k) {
            const size_t next = (k + 1) % 3;
            EXPECT_NEAR(dot(slopes[k], slopes[next]) * size[k](p) * size[next](p), 0, 2e-3);
        }
    }
}

/// From points on the surface half a wall to either side.
TEST_P(Conformal, WallsAreAsThickAsAsked) {
    constexpr double kWall = 0.6;
    const LibraryFunction wall = of_cells("gyroid_distance(c.at * c.size, c.size)");
    int measured = 0;
    double sum = 0;
    for (Vec p : points(60)) {
        for (int step = 0; step < 6; ++step) {
            const Vec n = gradient(wall, p);
            p = along(p, n, -wall(p) / std::max(dot(n, n), 0.25));
        }
        if (std::abs(wall(p)) > 1e-3) continue;
        Vec n = gradient(wall, p);
        n = along({}, n, 1 / std::sqrt(dot(n, n)));
        const double thickness = wall(along(p, n, kWall / 2)) - wall(along(p, n, -kWall / 2));
        EXPECT_NEAR(thickness, kWall, 0.04 * kWall);
        sum += thickness;
        ++measured;
    }
    ASSERT_GT(measured, 30);
    EXPECT_NEAR(sum / measured, kWall, 0.02 * kWall);
}

INSTANTIATE_TEST_SUITE_P(
    All, Conformal,
    ::testing::Values(
        Case{"box", "cells_box(p, float3(1, 2, 3), float3(5, 6, 7))", {-9, -9, -9}, {9, 9, 9}},
        Case{"graded", "cells_graded_z(p, 0, 40, 4, 8, float2(6, 6))", {-9, -9, 1}, {9, 9, 39}},
        Case{"growing", "cells_growing(p, 10, 16, 5)", {8, -16, -9}, {20, 16, 9}},
        Case{"cylinder", "cells_cylinder(p, 20, float3(5, 5, 5))", {16, -16, -9}, {24, 16, 9}},
        Case{"sphere", "cells_sphere(p, 20, float3(5, 5, 5))", {16, -12, -8}, {24, 12, 8}},
        Case{
            "between", "cells_between(p.z - 2, 12 - p.z, 2, p.xy / 5, 5)", {-9, -9, 3}, {9, 9, 11}},
        Case{"surface",
             "cells_surface(p.xy / 30, 30, float2(6, 5), 9 - p.z, 4)",
             {-9, -9, 0},
             {9, 9, 9}}),
    [](const auto& info) { return info.param.name; });

/// A long way around is a whole number of cells, and so is what was fitted.
TEST(ConformalCells, CloseWhole) {
    for (const char* cells : {"cells_cylinder(p, 20, 4.7)", "cells_sphere(p, 20, 4.7)",
                              "cells_growing(p, 20, 27, 4)"}) {
        const LibraryFunction x = function(std::string(cells) + ".at.x");
        const double turn = x({-20, 1e-4, 0}) - x({-20, -1e-4, 0});
        EXPECT_NEAR(turn, std::round(turn), 1e-3) << cells;
        EXPECT_NEAR(turn, 27, 0.5) << cells;
    }
    const LibraryFunction poles = function("cells_sphere(p, 20, 4.7).at.y");
    EXPECT_NEAR(poles({1e-3, 0, 20}) - poles({1e-3, 0, -20}), 13, 0.02);
    EXPECT_NEAR(function("cells_fit(20, 6)")({}), 20.0 / 3, 1e-5);
    EXPECT_NEAR(function("cells_fit(2, 6)")({}), 2, 1e-6);
    const LibraryFunction between = function("cells_between(p.x, p.y, 3, 0, 1).at.z");
    EXPECT_NEAR(between({0, 5, 0}), 0, 1e-6);
    EXPECT_NEAR(between({5, 0, 0}), 3, 1e-6);
}

/// The phase is the integral of 1 / size, across both ends, and for sizes that hardly change.
TEST(ConformalCells, GradedPhasesAreIntegrals) {
    for (const char* sizes : {"2, 6", "6, 2", "4, 4", "4, 4.01"}) {
        const LibraryFunction phase =
            function(std::string("cells_graded(p.x, 10, 30, ") + sizes + ").x");
        const LibraryFunction size =
            function(std::string("cells_graded(p.x, 10, 30, ") + sizes + ").y");
        constexpr double kStep = 0.05;
        double sum = 0;
        for (int k = 0; k < 1000; ++k) {
            sum += kStep / size({(k + 0.5) * kStep, 0, 0});
            if (k % 100 != 99) continue;
            const double found = phase({(k + 1) * kStep, 0, 0}) - phase({});
            EXPECT_NEAR(found, sum, 2e-4 * sum) << sizes << ' ' << k;
        }
    }
}

}  // namespace
}  // namespace openfab::testing
