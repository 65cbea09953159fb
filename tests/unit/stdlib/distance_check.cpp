// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/stdlib/distance_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace openfab::testing {

namespace {

constexpr double kStep = 2e-3;

class Points {
  public:
    explicit Points(const Box3& box) : box_(box) {}
    Vec next() {
        Vec p;
        for (size_t axis = 0; axis < 3; ++axis)
            p[axis] = box_.low[axis] + (box_.high[axis] - box_.low[axis]) * unit_(random_);
        return p;
    }
    Vec near(const Vec& p, double reach) {
        Vec q = p;
        for (double& x : q)
            x += reach * (2 * unit_(random_) - 1);
        return q;
    }

  private:
    Box3 box_;
    std::mt19937 random_{11};
    std::uniform_real_distribution<double> unit_{0, 1};
};

double way(const Vec& a, const Vec& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::string at(const Vec& p) {
    return std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " + std::to_string(p[2]);
}

}  // namespace

void expect_bound(const LibraryFunction& f, const Box3& box, double slack) {
    Points points(box);
    for (int k = 0; k < 3000; ++k) {
        const Vec p = points.next();
        // Far and near: the steepest places are small.
        const Vec q = k % 3 == 0 ? points.next() : points.near(p, k % 3 == 1 ? 0.5 : 0.02);
        ASSERT_LE(std::abs(f(p) - f(q)), way(p, q) + slack) << at(p) << " and " << at(q);
    }
}

void expect_exact(const LibraryFunction& f, const Box3& box) {
    Points points(box);
    int known = 0;
    constexpr int kPoints = 1500;
    for (int k = 0; k < kPoints; ++k) {
        const Vec p = points.next();
        const double d = f(p);
        Vec gradient;
        for (size_t axis = 0; axis < 3; ++axis) {
            Vec before = p, after = p;
            before[axis] -= kStep;
            after[axis] += kStep;
            gradient[axis] = (f(after) - f(before)) / (2 * kStep);
        }
        const double length = way(gradient, {0, 0, 0});
        if (length < 0.99) continue;
        ++known;
        Vec foot = p;
        for (size_t axis = 0; axis < 3; ++axis)
            foot[axis] -= d * gradient[axis] / length;
        ASSERT_LE(std::abs(f(foot)), 2e-5 + 4e-3 * std::abs(d)) << at(p) << ": " << d;
    }
    EXPECT_GT(known, kPoints * 8 / 10);
}

std::vector<Vec> surface_points(const LibraryFunction& f, const Box3& box, size_t count) {
    Points points(box);
    std::vector<Vec> out;
    for (size_t tries = 0; out.size() < count && tries < 100 * count; ++tries) {
        Vec a = points.next(), b = points.next();
        if ((f(a) < 0) == (f(b) < 0)) continue;
        if (f(b) < 0) std::swap(a, b);
        for (int k = 0; k < 20; ++k) {
            const Vec middle = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
            (f(middle) < 0 ? a : b) = middle;
        }
        out.push_back(a);
    }
    EXPECT_EQ(out.size(), count);
    return out;
}

double tightness(const LibraryFunction& f, const Box3& box, double away) {
    const std::vector<Vec> surface = surface_points(f, box, 6000);
    Points points(box);
    double least = 1e9;
    for (int k = 0; k < 1500; ++k) {
        const Vec p = points.next();
        double distance = 1e9;
        for (const Vec& q : surface)
            distance = std::min(distance, way(p, q));
        if (distance > away) least = std::min(least, std::abs(f(p)) / distance);
    }
    return least;
}

}  // namespace openfab::testing
