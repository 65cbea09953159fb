// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "base/affine.h"
#include "tools/fields/node_text.h"

namespace openfab::tools {

namespace {

/// A mesh of more sides is printed as it is.
constexpr size_t kMostPlanes = 64;

struct Plane {
    Vec3d n;
    double d = 0;
};

/// Returns the planes of a convex mesh; none where it is not, or has too many.
std::vector<Plane> planes_of(const mesh::ThreemfObject& mesh, const Box3d& box) {
    std::vector<Plane> planes;
    const Vec3d size = box.size();
    const double close = 1e-6 * std::max({size.x, size.y, size.z});
    // Inside out counts, too: the mean of the points lies inside of a convex mesh.
    Vec3d middle;
    for (const Vec3d& p : mesh.vertices)
        middle = middle + p * (1 / static_cast<double>(mesh.vertices.size()));
    for (const mesh::ThreemfTriangle& t : mesh.triangles) {
        const Vec3d& a = mesh.vertices[static_cast<size_t>(t.vertices[0])];
        Vec3d n = cross(mesh.vertices[static_cast<size_t>(t.vertices[1])] - a,
                        mesh.vertices[static_cast<size_t>(t.vertices[2])] - a);
        if (!(length(n) > 0)) continue;
        n = n * (1 / length(n));
        if (dot(n, a - middle) < 0) n = n * -1.0;
        const double d = dot(n, a);
        const bool known = std::ranges::any_of(planes, [&](const Plane& p) {
            return length(p.n - n) < 1e-6 && std::fabs(p.d - d) <= close;
        });
        if (known) continue;
        if (planes.size() == kMostPlanes) return {};
        for (const Vec3d& p : mesh.vertices) {
            if (dot(n, p) > d + close) return {};
        }
        planes.push_back({n, d});
    }
    return planes;
}

/// Whether the planes are the sides of the box.
bool is_box(const std::vector<Plane>& planes) {
    constexpr size_t kSides = 6;
    return planes.size() == kSides && std::ranges::all_of(planes, [](const Plane& p) {
               return std::max({std::fabs(p.n.x), std::fabs(p.n.y), std::fabs(p.n.z)}) > 1 - 1e-9;
           });
}

std::string vector_text(const Vec3d& v) {
    return fmt::format("float3({}, {}, {})", float_text(v.x), float_text(v.y), float_text(v.z));
}

}  // namespace

FieldBounds bounds_of(const mesh::ThreemfObject& mesh, bool box_only) {
    FieldBounds out;
    for (const Vec3d& p : mesh.vertices)
        out.box.add(p);
    std::vector<Plane> planes;
    if (!box_only) {
        planes = planes_of(mesh, out.box);
        if (planes.empty()) return out;
    }
    if (box_only || is_box(planes)) {
        out.text = fmt::format(
            "        float3 d = abs(q - {}) - {};\n"
            "        return max(d.x, max(d.y, d.z));\n",
            vector_text(out.box.center()), vector_text(out.box.size() * 0.5));
        return out;
    }
    out.text = "        float d = -1e30;\n";
    for (const Plane& p : planes)
        out.text += fmt::format("        d = max(d, dot(q, {}) - {});\n", vector_text(p.n),
                                float_text(p.d));
    out.text += "        return d;\n";
    return out;
}

std::string obj_text(const mesh::ThreemfObject& mesh, const Affine3d& map) {
    std::string out;
    for (const Vec3d& v : mesh.vertices) {
        const Vec3d p = map.apply(v);
        fmt::format_to(std::back_inserter(out), "v {:.9g} {:.9g} {:.9g}\n", p.x, p.y, p.z);
    }
    const bool mirrored = determinant(map) < 0;
    for (const mesh::ThreemfTriangle& t : mesh.triangles) {
        std::array<int32_t, 3> v = t.vertices;
        if (mirrored) std::swap(v[1], v[2]);
        fmt::format_to(std::back_inserter(out), "f {} {} {}\n", v[0] + 1, v[1] + 1, v[2] + 1);
    }
    return out;
}

}  // namespace openfab::tools
