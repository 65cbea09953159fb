// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "runtime/nearest/tree/triangle.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/reference/closest_point.h"

namespace openfab::nearest {
namespace {

struct Made {
    TriangleFrame frame;
    TriangleDetail detail;
    Made(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
        make_triangle(a, b, c, 0, 0, &frame, &detail);
    }
    Hit at(const Vec3f& p) const { return closest_point(frame, detail, p); }
};

bool same_bits(float a, float b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

TEST(ClosestPoint, KnownRegions) {
    const Made t({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    const auto expect = [&](const Vec3f& p, float d2, float b1, float b2) {
        const Hit h = t.at(p);
        EXPECT_NEAR(h.distance2, d2, 1e-6f) << p.x << " " << p.y << " " << p.z;
        EXPECT_NEAR(h.bary1, b1, 1e-6f);
        EXPECT_NEAR(h.bary2, b2, 1e-6f);
    };
    expect({1, 1, 3}, 9, 0.25f, 0.25f);   // face
    expect({1, 1, -2}, 4, 0.25f, 0.25f);  // face from below
    expect({2, -3, 0}, 9, 0.5f, 0);       // edge 0
    expect({4, 4, 0}, 8, 0.5f, 0.5f);     // edge 1
    expect({-2, 1, 0}, 4, 0, 0.25f);      // edge 2
    expect({-1, -1, 1}, 3, 0, 0);         // corners
    expect({6, -1, 0}, 5, 1, 0);
    expect({-1, 6, 0}, 5, 0, 1);
}

TEST(ClosestPoint, TrianglesAroundAFeatureGiveItsBits) {
    std::mt19937 random(3);
    const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1; };
    const auto point = [&] {
        const float x = uniform(), y = uniform(), z = uniform();
        return Vec3f{x, y, z};
    };
    int edges = 0, vertices = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3f a = point(), b = point(), c = point(), d = point(), p = point() * 2.0f;
        // The edge (a, b) from both sides and every rotation.
        const Hit h[4] = {Made(a, b, c).at(p), Made(b, a, d).at(p), Made(d, b, a).at(p),
                          Made(a, d, b).at(p)};
        const auto on_edge = [](float bary_opposite) { return bary_opposite == 0; };
        if (on_edge(h[0].bary2) && on_edge(h[1].bary2) && h[2].bary1 + h[2].bary2 == 1 &&
            on_edge(h[3].bary1)) {
            ++edges;
            EXPECT_TRUE(same_bits(h[0].distance2, h[1].distance2));
            EXPECT_TRUE(same_bits(h[0].distance2, h[2].distance2));
            EXPECT_TRUE(same_bits(h[0].distance2, h[3].distance2));
        }
        // The vertex a, from triangles that share nothing else.
        const Hit u = Made(a, b, c).at(p), v = Made(d, point(), a).at(p);
        if (u.bary1 == 0 && u.bary2 == 0 && v.bary2 == 1) {
            ++vertices;
            EXPECT_TRUE(same_bits(u.distance2, v.distance2));
        }
    }
    EXPECT_GT(edges, 500);
    EXPECT_GT(vertices, 500);
}

/// |d - d_ref| <= 1e-5 d_ref + 2^-21 (largest coordinate), over sizes, shapes and distances; points
/// on the triangle too.
TEST(ClosestPoint, AsExactAsPromised) {
    std::mt19937 random(11);
    const auto uniform = [&](double r) { return (random() * 0x1p-31 - 1) * r; };
    const auto point = [&](double r) {
        const double x = uniform(r), y = uniform(r), z = uniform(r);
        return Vec3d{x, y, z};
    };
    double worst = 0;
    for (int i = 0; i < 400000; ++i) {
        const double extent = 50;
        const double size = std::pow(10.0, uniform(2) - 0.3);
        const Vec3d center = point(extent - std::min(size, extent));
        const auto inside = [&](const Vec3d& v) {
            Vec3f f;
            for (int a = 0; a < 3; ++a)
                f[a] = static_cast<float>(std::clamp(v[a], -extent, extent));
            return f;
        };
        const Vec3f a = inside(center), b = inside(center + point(size));
        Vec3f c = inside(center + point(size));
        if (i % 5 == 1)
            c = inside(vec_cast<double>(a) * 0.3 + vec_cast<double>(b) * 0.7 + point(size * 1e-4));
        if (i % 5 == 2) c = inside(vec_cast<double>(b) + point(size * 1e-4));
        if (i % 50 == 3) c = inside((vec_cast<double>(a) + vec_cast<double>(b)) * 0.5);
        const Vec3d va = vec_cast<double>(a), vb = vec_cast<double>(b), vc = vec_cast<double>(c);
        Vec3d p = point(extent);
        if (i % 3 != 0) {
            const double u = std::abs(uniform(1.1)), v = std::abs(uniform(1.1));
            p = va + (vb - va) * u + (vc - va) * v + point(std::pow(10.0, uniform(3) - 3));
        }
        const Vec3f pf = inside(p);
        const double want = length(vec_cast<double>(pf) -
                                   reference::closest_point(vec_cast<double>(pf), va, vb, vc));
        const Hit hit = Made(a, b, c).at(pf);
        const double got = std::sqrt(static_cast<double>(hit.distance2));
        double largest = 0;
        for (const Vec3f& v : {a, b, c, pf}) {
            for (int k = 0; k < 3; ++k)
                largest = std::max(largest, std::abs(static_cast<double>(v[k])));
        }
        const double allowed = 1e-5 * want + std::ldexp(largest, -21);
        worst = std::max(worst, std::abs(got - want) / allowed);
        ASSERT_LE(std::abs(got - want), allowed) << "case " << i << ": " << got << " for " << want;

        // The barycentrics give a point at that distance; in slivers they are as inaccurate as the
        // shape is thin.
        const double longest = std::max({length(vb - va), length(vc - va), length(vc - vb)});
        const double height = length(cross(vb - va, vc - va)) / longest;
        if (height < 0.05 * longest) continue;
        const Vec3d q = va + (vb - va) * static_cast<double>(hit.bary1) +
                        (vc - va) * static_cast<double>(hit.bary2);
        ASSERT_NEAR(length(vec_cast<double>(pf) - q), want, 20 * allowed) << "case " << i;
    }
    RecordProperty("worst_of_allowed", std::to_string(worst));
    std::printf("worst error: %.3f of what is allowed\n", worst);
}

}  // namespace
}  // namespace openfab::nearest
