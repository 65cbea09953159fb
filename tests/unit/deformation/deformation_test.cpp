// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Displacements, against closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "deformation/field.h"
#include "deformation/fit_field.h"
#include "deformation/refine.h"

namespace openfab::deformation {
namespace {

double distance(const Vec3d& a, const Vec3d& b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) +
                     (a.z - b.z) * (a.z - b.z));
}

Field field_of(const std::function<Vec3d(const Vec3d& p)>& u) {
    Field field;
    field.origin_mm = {-10, -5, 0};
    field.spacing_mm = {2, 1, 3};
    field.nodes = {11, 11, 8};
    for (int32_t z = 0; z < field.nodes.z; ++z) {
        for (int32_t y = 0; y < field.nodes.y; ++y) {
            for (int32_t x = 0; x < field.nodes.x; ++x)
                field.u_mm.push_back(u({-10 + 2.0 * x, -5 + 1.0 * y, 3.0 * z}));
        }
    }
    return field;
}

Vec3d waves(const Vec3d& p) {
    return {0.3 * std::sin(p.y), 0.2 * std::cos(p.x * 0.5) + 0.02 * p.z, 0.4 * std::sin(p.x + p.y)};
}

TEST(Field, IsLinearBetweenItsNodes) {
    const auto linear = [](const Vec3d& p) {
        return Vec3d{0.1 * p.x + 0.3, 0.2 * p.z - 0.1 * p.y, 0.05 * p.x * p.y};
    };
    const Field field = field_of(linear);
    for (const Vec3d& p : {Vec3d{0.3, 1.2, 4.7}, Vec3d{-9.9, 4.9, 20.9}, Vec3d{10, 5, 21}})
        EXPECT_LT(distance(field.displacement(p), linear(p)), 1e-12);
    EXPECT_LT(distance(field.displacement({-50, 2, 4}), linear({-10, 2, 4})), 1e-12);
}

TEST(Field, AndItsInverseReturn) {
    const Field field = field_of(waves);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-12, 24);
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p{place(random), place(random), place(random)};
        const std::optional<Vec3d> back = field.moved_back(p);
        ASSERT_TRUE(back);
        // 1/256 of a voxel of 0.02 mm is 8e-5 mm.
        ASSERT_LT(distance(field.moved(*back), p), 1e-6);
        ASSERT_LT(distance(*field.moved_back(field.moved(p)), p), 1e-5);
    }
    EXPECT_NEAR(field_of([](const Vec3d& p) {
                    return Vec3d{0, -3 * p.x, 0};
                }).steepest(),
                3, 1e-12);
    EXPECT_LT(field.steepest(), 0.5);
}

TEST(FitField, FindsWhatIsLinearEvenWhereNothingWasMeasured) {
    const auto linear = [](const Vec3d& p) {
        return Vec3d{0.01 * p.x + 0.3, 0.02 * p.z - 0.01 * p.y, 0.005 * p.x};
    };
    std::mt19937 random(6);
    std::uniform_real_distribution<double> place(0, 5);
    std::vector<Pair> pairs;
    for (int i = 0; i < 300; ++i) {
        const Vec3d p{place(random), place(random), place(random)};
        pairs.push_back({p, p + linear(p)});
    }
    Field field = field_of(waves);
    EXPECT_LT(fit_field(pairs, 1e-3, &field), 1e-5);
    for (const Vec3d& p : {Vec3d{1, 2, 3}, Vec3d{-10, -5, 0}, Vec3d{10, 5, 21}})
        EXPECT_LT(distance(field.displacement(p), linear(p)), 1e-3);
}

TEST(FitField, FollowsWhatWasMeasured) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> x(-10, 10), y(-5, 5), z(0, 21);
    std::vector<Pair> pairs;
    for (int i = 0; i < 20000; ++i) {
        const Vec3d p{x(random), y(random), z(random)};
        pairs.push_back({p, p + waves(p) * 0.2});
    }
    Field field = field_of(waves);
    EXPECT_LT(fit_field(pairs, 1e-3, &field), 0.02);
}

TEST(Refine, KeepsAClosedSurfaceClosedAndItsAttributes) {
    // A tetrahedron, with its positions as an attribute of two seams.
    Surface surface;
    surface.positions = {{0, 0, 0}, {9, 0, 0}, {0, 5, 0}, {1, 1, 14}};
    surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    Surface::Attribute attribute;
    attribute.components = 3;
    for (int32_t t = 0; t < 4; ++t) {
        for (const int32_t corner : surface.triangles[static_cast<size_t>(t)]) {
            const Vec3d& p = surface.positions[static_cast<size_t>(corner)];
            for (const double c : {p.x, p.y, p.z})
                attribute.values.push_back(static_cast<float>(c));
        }
        attribute.corners.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    surface.attributes.push_back(attribute);
    const auto from = refine(1.0, 100'000, &surface);
    ASSERT_TRUE(from);
    ASSERT_EQ(from->size(), surface.triangles.size());
    EXPECT_GT(surface.triangles.size(), 200u);
    std::map<std::pair<int32_t, int32_t>, int> edges;
    double volume = 0;
    for (size_t i = 0; i < surface.triangles.size(); ++i) {
        const auto& t = surface.triangles[i];
        for (size_t e = 0; e < 3; ++e) {
            const int32_t a = t[e], b = t[(e + 1) % 3];
            ++edges[{a, b}];
            EXPECT_LE(distance(surface.positions[static_cast<size_t>(a)],
                               surface.positions[static_cast<size_t>(b)]),
                      1.0);
            const auto value = static_cast<size_t>(surface.attributes[0].corners[i][e]) * 3;
            const float* v = &surface.attributes[0].values[value];
            const Vec3d& p = surface.positions[static_cast<size_t>(a)];
            EXPECT_LT(distance({v[0], v[1], v[2]}, p), 1e-5);
        }
        const Vec3d &p = surface.positions[static_cast<size_t>(t[0])],
                    &q = surface.positions[static_cast<size_t>(t[1])],
                    &r = surface.positions[static_cast<size_t>(t[2])];
        volume += (p.x * (q.y * r.z - q.z * r.y) + p.y * (q.z * r.x - q.x * r.z) +
                   p.z * (q.x * r.y - q.y * r.x)) /
                  6;
    }
    EXPECT_NEAR(volume, 9.0 * 5 * 14 / 6, 1e-9);
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    EXPECT_FALSE(refine(0.001, 10'000, &surface));
}

}  // namespace
}  // namespace openfab::deformation
