// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/primitives.h"

#include "base/rotation.h"
#include "mesh/model/primitive_builder.h"

namespace openfab::mesh {
namespace {

constexpr int32_t kAround = kFacetsAround;
constexpr int32_t kStacks = 64;

}  // namespace

Mesh make_box(const Vec3d& size_mm) {
    PrimitiveBuilder b("box");
    const double x = size_mm.x / 2;
    const double y = size_mm.y / 2;
    const double z = size_mm.z;
    // Bits of a corner: 1 +x, 2 +y, 4 +z.
    for (int32_t i = 0; i < 8; ++i) {
        b.position({(i & 1) != 0 ? x : 0 - x, (i & 2) != 0 ? y : 0 - y, (i & 4) != 0 ? z : 0});
    }
    const std::array<int32_t, 4> uv{b.uv(0, 0), b.uv(1, 0), b.uv(1, 1), b.uv(0, 1)};
    const auto side = [&](const std::array<int32_t, 4>& p, const Vec3d& normal, int32_t face) {
        const int32_t n = b.normal(normal);
        b.quad(p, uv, {n, n, n, n}, face);
    };
    side({4, 5, 7, 6}, {0, 0, 1}, 0);
    const int32_t down = b.normal({0, 0, -1});
    // The back starts at the front's lower left corner, too, and runs the other way, with the
    // front's uv.
    b.quad({0, 2, 3, 1}, {uv[0], uv[3], uv[2], uv[1]}, {down, down, down, down}, 1);
    side({0, 1, 5, 4}, {0, -1, 0}, 2);
    side({1, 3, 7, 5}, {1, 0, 0}, 3);
    side({3, 2, 6, 7}, {0, 1, 0}, 4);
    side({2, 0, 4, 6}, {-1, 0, 0}, 5);
    return b.take();
}

Mesh make_sphere(double diameter_mm) {
    PrimitiveBuilder b("sphere");
    const double r = diameter_mm / 2;
    const int32_t south = b.position({0, 0, 0});
    const int32_t south_n = b.normal({0, 0, -1});
    // Rings from the south pole up; ring k holds positions and normals of latitude k, starting at
    // -y.
    const auto ring = [](int32_t stack, int32_t i) {
        return 1 + (stack - 1) * kAround + i % kAround;
    };
    for (int32_t stack = 1; stack < kStacks; ++stack) {
        const SinCos lat = sin_cos_degrees(-90.0 + 180.0 * stack / kStacks);
        for (int32_t i = 0; i < kAround; ++i) {
            const SinCos lon = sin_cos_degrees(-90.0 + 360.0 * i / kAround);
            const Vec3d n{lat.cos * lon.cos, lat.cos * lon.sin, lat.sin};
            b.position(n * r + Vec3d{0, 0, r});
            b.normal(n);
        }
    }
    const int32_t north = b.position({0, 0, diameter_mm});
    const int32_t north_n = b.normal({0, 0, 1});
    for (int32_t stack = 0; stack <= kStacks; ++stack) {
        for (int32_t i = 0; i <= kAround; ++i) {
            b.uv(static_cast<double>(i) / kAround, static_cast<double>(stack) / kStacks);
        }
    }
    const auto uv = [](int32_t stack, int32_t i) { return stack * (kAround + 1) + i; };
    for (int32_t i = 0; i < kAround; ++i) {
        b.triangle({south, ring(1, i + 1), ring(1, i)}, {uv(0, i), uv(1, i + 1), uv(1, i)},
                   {south_n, ring(1, i + 1), ring(1, i)}, 0);
        for (int32_t stack = 1; stack + 1 < kStacks; ++stack) {
            const std::array<int32_t, 4> p{ring(stack, i), ring(stack, i + 1),
                                           ring(stack + 1, i + 1), ring(stack + 1, i)};
            // Positions and normals are numbered alike.
            b.quad(p, {uv(stack, i), uv(stack, i + 1), uv(stack + 1, i + 1), uv(stack + 1, i)}, p,
                   0);
        }
        const int32_t last = kStacks - 1;
        b.triangle({ring(last, i), ring(last, i + 1), north},
                   {uv(last, i), uv(last, i + 1), uv(kStacks, i)},
                   {ring(last, i), ring(last, i + 1), north_n}, 0);
    }
    return b.take();
}

Mesh make_cylinder(double diameter_mm, double height_mm) {
    PrimitiveBuilder b("cylinder");
    const double r = diameter_mm / 2;
    const int32_t bottom = b.position({0, 0, 0});
    const int32_t top = b.position({0, 0, height_mm});
    const int32_t down = b.normal({0, 0, -1});
    const int32_t up = b.normal({0, 0, 1});
    const int32_t middle = b.uv(0.5, 0.5);
    for (int32_t i = 0; i < kAround; ++i) {
        const SinCos a = sin_cos_degrees(-90.0 + 360.0 * i / kAround);
        b.position({a.cos * r, a.sin * r, 0});
        b.position({a.cos * r, a.sin * r, height_mm});
        b.normal({a.cos, a.sin, 0});
        b.uv(0.5 + 0.5 * a.cos, 0.5 + 0.5 * a.sin);
    }
    const int32_t side_uv = 1 + kAround;
    for (int32_t i = 0; i <= kAround; ++i) {
        b.uv(static_cast<double>(i) / kAround, 0);
        b.uv(static_cast<double>(i) / kAround, 1);
    }
    for (int32_t i = 0; i < kAround; ++i) {
        const int32_t next = (i + 1) % kAround;
        const int32_t low = 2 + 2 * i;
        const int32_t low_next = 2 + 2 * next;
        b.triangle({top, low + 1, low_next + 1}, {middle, middle + 1 + i, middle + 1 + next},
                   {up, up, up}, 0);
        b.triangle({bottom, low_next, low}, {middle, middle + 1 + next, middle + 1 + i},
                   {down, down, down}, 1);
        const int32_t u = side_uv + 2 * i;
        b.quad({low, low_next, low_next + 1, low + 1}, {u, u + 2, u + 3, u + 1},
               {2 + i, 2 + next, 2 + next, 2 + i}, 2);
    }
    return b.take();
}

Mesh make_plane(double x_mm, double y_mm) {
    PrimitiveBuilder b("plane");
    const double x = x_mm / 2;
    const double y = y_mm / 2;
    const std::array<int32_t, 4> p{b.position({0 - x, 0 - y, 0}), b.position({x, 0 - y, 0}),
                                   b.position({x, y, 0}), b.position({0 - x, y, 0})};
    const std::array<int32_t, 4> uv{b.uv(0, 0), b.uv(1, 0), b.uv(1, 1), b.uv(0, 1)};
    const int32_t up = b.normal({0, 0, 1});
    const int32_t down = b.normal({0, 0, -1});
    b.quad(p, uv, {up, up, up, up}, 0);
    // The back uses the other diagonal: at the same one four triangles would meet.
    b.quad({p[1], p[0], p[3], p[2]}, {uv[1], uv[0], uv[3], uv[2]}, {down, down, down, down}, 1);
    return b.take();
}

}  // namespace openfab::mesh
