// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What stands, rocks, rolls and falls, by the lowest layers of closed forms, wherever voxels begin.

#include "mechanics/stand/foot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

namespace openfab::mechanics {
namespace {

using Kind = Foot::Kind;
using Point = std::array<double, 3>;

double square(double v) {
    return v * v;
}

struct Shape {
    std::string name;
    std::function<bool(const Point&)> inside;  ///< above the ground at 0
    double half_mm;                            ///< of the square that has it
    Point centre_mm;
    Kind kind;
    double margin_mm = 0, round_mm = 0;  ///< 0: not compared
};

/// The lowest layers in `n` voxels along a side, moved by a part of one.
FootLayers layers_of(const Shape& s, int32_t n, double shift, double lift) {
    const double pitch = 2 * s.half_mm / n;
    FootLayers out;
    out.size = {n + 4, n + 4, kFootLayers};
    out.pitch_mm = {pitch, pitch, pitch};
    out.origin_mm = {(shift - n / 2 - 2) * pitch, (shift - n / 2 - 2) * pitch, -lift * pitch};
    for (int32_t z = 0; z < out.size[2]; ++z)
        for (int32_t y = 0; y < out.size[1]; ++y)
            for (int32_t x = 0; x < out.size[0]; ++x) {
                const Point p{out.origin_mm[0] + (x + 0.5) * pitch,
                              out.origin_mm[1] + (y + 0.5) * pitch,
                              out.origin_mm[2] + (z + 0.5) * pitch};
                out.inside.push_back(p[2] > 0 && s.inside(p) ? 1 : 0);
            }
    return out;
}

/// The same about the vertical.
Shape turned(Shape s, double degrees) {
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 t = std::sin(degrees * std::numbers::pi / 180);
    s.inside = [of = s.inside, c, t](const Point& p) {
        return of({c * p[0] + t * p[1], c * p[1] - t * p[0], p[2]});
    };
    s.centre_mm = {c * s.centre_mm[0] - t * s.centre_mm[1], t * s.centre_mm[0] + c * s.centre_mm[1],
                   s.centre_mm[2]};
    return s;
}

std::vector<Shape> shapes() {
    const auto ellipsoid = [](double a, double b, double c) {
        return [=](const Point& p) {
            return square(p[0] / a) + square(p[1] / b) + square((p[2] - c) / c) < 1;
        };
    };
    const auto prism = [](double low, double slope) {
        return [=](const Point& p) {
            return std::abs(p[0] - slope * p[2]) < low && std::abs(p[1]) < 5;
        };
    };
    const auto plate_on = [](const std::function<bool(const Point&)>& bump) {
        return [=](const Point& p) {
            return bump(p) || (p[2] > 0.4 && std::max(std::abs(p[0]), std::abs(p[1])) < 10);
        };
    };
    return {
        {"ball", ellipsoid(5, 5, 5), 5, {0, 0, 5}, Kind::kRolls, 0, 5},
        {"small ball", ellipsoid(1.5, 1.5, 1.5), 1.5, {0, 0, 1.5}, Kind::kRolls, 0, 1.5},
        {"half a ball", ellipsoid(5, 5, 5), 5, {0, 0, 3.125}, Kind::kRocks, 0, 5},
        {"a lens that lies", ellipsoid(10, 10, 4), 10, {0, 0, 4}, Kind::kRocks, 0, 25},
        {"a cigar that lies", ellipsoid(10, 4, 4), 10, {0, 0, 4}, Kind::kRolls, 0, 4},
        {"an egg that stands", ellipsoid(4, 4, 10), 4, {0, 0, 10}, Kind::kRolls, 0, 1.6},
        {"a cylinder that lies",
         [](const Point& p) { return std::abs(p[0]) < 10 && square(p[1]) + square(p[2] - 4) < 16; },
         11,
         {0, 0, 4},
         Kind::kRolls,
         0,
         4},
        {"a cylinder that stands",
         [](const Point& p) { return std::hypot(p[0], p[1]) < 4; },
         5,
         {0, 0, 10},
         Kind::kStands,
         4},
        {"a cone on its tip",
         [](const Point& p) { return std::hypot(p[0], p[1]) < p[2] / 2; },
         8,
         {0, 0, 11},
         Kind::kRolls},
        {"a cone on its base",
         [](const Point& p) { return std::hypot(p[0], p[1]) < 8 - p[2] / 2; },
         8,
         {0, 0, 4},
         Kind::kStands,
         8},
        {"a prism on its edge",
         [](const Point& p) { return std::abs(p[0]) < 0.3 * p[2] && std::abs(p[1]) < 5; },
         6,
         {0, 0, 6.67},
         Kind::kRolls},
        {"a torus that lies",
         [](const Point& p) {
             return square(std::hypot(p[0], p[1]) - 4.5) + square(p[2] - 1.5) < 2.25;
         },
         6,
         {0, 0, 1.5},
         Kind::kStands,
         4.5},
        {"a torus upright",
         [](const Point& p) {
             return square(std::hypot(p[0], p[2] - 6) - 4.5) + square(p[1]) < 2.25;
         },
         6,
         {0, 0, 6},
         Kind::kRolls,
         0,
         1.5},
        {"a leaning box", prism(4, 0.7), 12, {3.5, 0, 5}, Kind::kStands, 0.5},
        {"a box that leans too far", prism(4, 0.9), 12, {4.5, 0, 5}, Kind::kFalls, -0.5},
        {"three balls for feet",
         [](const Point& p) {
             for (const Point& at : {Point{8, 0, 1}, Point{-4, 6.928, 1}, Point{-4, -6.928, 1}})
                 if (square(p[0] - at[0]) + square(p[1] - at[1]) + square(p[2] - at[2]) < 1)
                     return true;
             return false;
         },
         9.5,
         {0, 0, 6},
         Kind::kStands,
         4},
        {"a plate on a round bump",
         plate_on(
             [](const Point& p) { return square(p[0]) + square(p[1]) + square(p[2] - 1) < 1; }),
         10.5,
         {0, 0, 1.5},
         Kind::kRolls,
         0,
         1},
        {"a plate on a flat bump",
         plate_on([](const Point& p) { return std::hypot(p[0], p[1]) < 1; }),
         10.5,
         {0, 0, 1.5},
         Kind::kStands,
         1},
    };
}

// The side is that which a print of the foot has, and less.
TEST(MechanicsFoot, ClosedFormsStandOrDoNotWhereverVoxelsBegin) {
    for (const Shape& one : shapes())
        for (const auto& [n, degrees, shift, lift] :
             {std::tuple(512, 0.0, 0.0, 0.0), {400, 30.0, 0.3, 0.9}}) {
            const Shape s = turned(one, degrees);
            const Foot f = foot_of(layers_of(s, n, shift, lift), {s.centre_mm[0], s.centre_mm[1]},
                                   s.centre_mm[2]);
            const std::string what = s.name + " " + std::to_string(n) + " " + std::to_string(lift);
            // What does not stand may be not resolved where voxels lie badly.
            const bool lost =
                degrees != 0 && s.kind == Kind::kRolls && f.kind == Kind::kNotResolved;
            if (lost) continue;
            EXPECT_EQ(static_cast<int>(f.kind), static_cast<int>(s.kind)) << what;
            if (s.margin_mm != 0) {
                EXPECT_NEAR(f.margin_mm, s.margin_mm, 0.15) << what;
            }
            if (s.round_mm != 0) {
                EXPECT_NEAR(f.round_mm / s.round_mm, 1, 0.12) << what;
            }
        }
}

// Within a voxel of the edge of a flat foot no voxels tell.
TEST(MechanicsFoot, WhatVoxelsDoNotTellIsNotResolved) {
    Shape box{"box",
              [](const Point& p) { return std::abs(p[0]) < 4 && std::abs(p[1]) < 5; },
              6,
              {3.99, 0, 5},
              Kind::kNotResolved};
    EXPECT_EQ(foot_of(layers_of(box, 100, 0.3, 0), {3.99, 0}, 5).kind, Kind::kNotResolved);
    EXPECT_EQ(foot_of(layers_of(box, 100, 0.3, 0), {4.5, 0}, 5).kind, Kind::kFalls);
    EXPECT_EQ(foot_of(layers_of(box, 100, 0.3, 0), {3.5, 0}, 5).kind, Kind::kStands);
    EXPECT_EQ(foot_of(FootLayers{{1, 1, 1}, {1, 1, 1}, {}, {0}}, {0, 0}, 1).kind,
              Kind::kNotResolved);
}

}  // namespace
}  // namespace openfab::mechanics
