// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace openfab::testing {

namespace {

struct Facets {
    std::vector<Vec3d> vertices;
    std::vector<std::array<int, 3>> triangles;
};

/// Rings of the second ball, then of the first; between them is the cone.
Facets facets_of(const Hull& hull) {
    const Vec3d way = hull.to - hull.from;
    const double size = length(way);
    const Vec3d along = way * (1 / size);
    const Vec3d across = cross(along, Vec3d{0.3, 0.5, 0.8}), side = across * (1 / length(across));
    const Vec3d up = cross(along, side);
    const double edge = std::acos((hull.radius - hull.other) / size);
    const int before = std::max(2, static_cast<int>(std::ceil(edge * kAround / (2 * M_PI)))),
              after =
                  std::max(2, static_cast<int>(std::ceil((M_PI - edge) * kAround / (2 * M_PI))));
    Facets out;
    const auto ring = [&](double angle, const Vec3d& centre, double radius) {
        for (int k = 0; k < kAround; ++k) {
            const double turn = 2 * M_PI * k / kAround;
            out.vertices.push_back(
                centre + (along * std::cos(angle) +
                          (side * std::cos(turn) + up * std::sin(turn)) * std::sin(angle)) *
                             radius);
        }
    };
    out.vertices.push_back(hull.to + along * hull.other);
    for (int i = 1; i <= before; ++i)
        ring(edge * i / before, hull.to, hull.other);
    for (int i = 0; i < after; ++i)
        ring(edge + (M_PI - edge) * i / after, hull.from, hull.radius);
    out.vertices.push_back(hull.from - along * hull.radius);
    const int rings = before + after, last = 1 + rings * kAround;
    for (int k = 0; k < kAround; ++k) {
        const int next = (k + 1) % kAround;
        out.triangles.push_back({0, 1 + k, 1 + next});
        for (int i = 0; i + 1 < rings; ++i) {
            const int a = 1 + i * kAround + k, b = 1 + i * kAround + next;
            out.triangles.push_back({a, a + kAround, b + kAround});
            out.triangles.push_back({a, b + kAround, b});
        }
        const int end = 1 + (rings - 1) * kAround;
        out.triangles.push_back({last, end + next, end + k});
    }
    return out;
}

}  // namespace

std::string hull_obj(const Hull& hull, double by, const std::string& name) {
    std::string out;
    int first = 1;
    if (!name.empty()) {
        out += "o other\n";
        for (int i = 0; i < 8; ++i)
            out += fmt::format("v {} {} {}\n", 20 + (i & 1), 20 + (i >> 1 & 1), 20 + (i >> 2));
        out +=
            "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 "
            "7 3\nf 2 4 8\nf 2 8 6\n";
        out += "o " + name + "\n";
        first = 9;
    }
    const Facets facets = facets_of(hull);
    for (const Vec3d& v : facets.vertices)
        out += fmt::format("v {:.7f} {:.7f} {:.7f}\n", v.x / by, v.y / by, v.z / by);
    for (const std::array<int, 3>& t : facets.triangles)
        out += fmt::format("f {} {} {}\n", t[0] + first, t[1] + first, t[2] + first);
    return out;
}

std::string hull_answer(const Hull& hull) {
    const Facets facets = facets_of(hull);
    std::string out = fmt::format("mesh {} {}\n", facets.vertices.size(), facets.triangles.size());
    for (const Vec3d& v : facets.vertices)
        out += fmt::format("{:.7f} {:.7f} {:.7f}\n", v.x, v.y, v.z);
    for (const std::array<int, 3>& t : facets.triangles)
        out += fmt::format("{} {} {}\n", t[0], t[1], t[2]);
    return out;
}

double hull_distance(const Hull& hull, const Vec3d& p) {
    // The nearest ball of the axis, see runtime/solid/beams/beam.h; here by its angle.
    const Vec3d way = hull.to - hull.from, v = p - hull.from;
    const double size = length(way), lean = (hull.radius - hull.other) / size;
    const double y = dot(v, way) / size;
    const double x = std::sqrt(std::max(0.0, dot(v, v) - y * y));
    const double s = std::clamp(y - x * std::tan(std::asin(lean)), 0.0, size);
    return std::hypot(x, y - s) - (hull.radius - lean * s);
}

}  // namespace openfab::testing
