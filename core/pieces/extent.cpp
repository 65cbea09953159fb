// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "pieces/extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace openfab::pieces {

namespace {

/// Cuts a convex polygon by a side; corners that are inside keep their bits.
void clip(const Side& side, std::vector<Vec3d>* polygon, std::vector<Vec3d>* scratch) {
    scratch->clear();
    const size_t n = polygon->size();
    for (size_t i = 0; i < n; ++i) {
        const Vec3d &a = (*polygon)[i], &b = (*polygon)[(i + 1) % n];
        const double da = side.depth(a), db = side.depth(b);
        if (da >= 0) scratch->push_back(a);
        if ((da > 0 && db < 0) || (da < 0 && db > 0))
            scratch->push_back(a + (b - a) * (da / (da - db)));
    }
    polygon->swap(*scratch);
}

/// Returns the point where three planes meet; false where they do not.
bool corner(const Side& a, const Side& b, const Side& c, Vec3d* out) {
    const Vec3d bc = cross(b.normal, c.normal);
    const double det = dot(a.normal, bc);
    if (std::fabs(det) < 1e-9) return false;
    *out = (bc * a.offset + cross(c.normal, a.normal) * b.offset +
            cross(a.normal, b.normal) * c.offset) *
           (1 / det);
    return true;
}

Box3d common(const Box3d& a, const Box3d& b) {
    Box3d out;
    for (int axis = 0; axis < 3; ++axis) {
        out.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
        out.hi[axis] = std::min(a.hi[axis], b.hi[axis]);
    }
    return out;
}

void add_mapped(const Box3d& box, const Affine3d& map, Box3d* out) {
    if (box.empty()) return;
    for (uint32_t i = 0; i < 8; ++i) {
        out->add(map.apply({(i & 1) != 0 ? box.hi.x : box.lo.x, (i & 2) != 0 ? box.hi.y : box.lo.y,
                            (i & 4) != 0 ? box.hi.z : box.lo.z}));
    }
}

bool holds(const Box3d& box, const Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
        if (p[a] < box.lo[a] || p[a] > box.hi[a]) return false;
    }
    return true;
}

/// Adds the corners of the region that `inside` holds: no polygon of the surface reaches them.
template <typename Inside>
void add_corners(const Region& region, const Affine3d& map, const Inside& inside, Box3d* out) {
    const std::vector<Side>& sides = region.sides;
    const size_t n = sides.size();
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = i + 1; j < n; ++j) {
            for (size_t k = j + 1; k < n; ++k) {
                Vec3d p;
                if (!corner(sides[i], sides[j], sides[k], &p)) continue;
                const bool within = std::all_of(sides.begin(), sides.end(), [&](const Side& side) {
                    return side.depth(p) >= -1e-6;
                });
                if (within && inside(p)) out->add(map.apply(p));
            }
        }
    }
}

/// Adds the pegs and dowels of a region, which may be longer than the part.
void add_shapes(const Region& region, const Box3d& whole, const Affine3d& map, Box3d* out) {
    for (const Shape& shape : region.added) {
        Shape part = region.shapes_only ? shape : shape.upper();
        add_mapped(common(part.box(), whole), map, out);
    }
}

Vec3d nearest_of_triangle(const std::array<Vec3d, 3>& t, const Vec3d& p) {
    const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
    const double area = dot(n, n);
    bool above = area > 0;
    for (size_t i = 0; i < 3 && above; ++i)
        above = dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), n) >= 0;
    if (above) return p - n * (dot(p - t[0], n) / area);
    Vec3d best = t[0];
    double least = 1e300;
    for (size_t i = 0; i < 3; ++i) {
        const Vec3d e = t[(i + 1) % 3] - t[i];
        const double size = dot(e, e);
        const double s = size > 0 ? std::clamp(dot(p - t[i], e) / size, 0.0, 1.0) : 0;
        const Vec3d q = t[i] + e * s;
        const double d = dot(p - q, p - q);
        if (d < least) least = d, best = q;
    }
    return best;
}

}  // namespace

std::array<Vec3d, 3> Body::triangle(size_t t) const {
    const std::array<int32_t, 3>& v = triangles[t];
    return {positions[static_cast<size_t>(v[0])], positions[static_cast<size_t>(v[1])],
            positions[static_cast<size_t>(v[2])]};
}

bool Body::holds(const Vec3d& p) const {
    // Of crossings of the ray along +x; the point is moved by (e, e²) in y and z, which decides ties.
    const auto side = [&](Vec3d a, Vec3d b) {
        double turn = 1;
        if (b.y < a.y || (b.y == a.y && b.z < a.z)) std::swap(a, b), turn = -1;
        const double dy = b.y - a.y, dz = b.z - a.z;
        double s = dy * (p.z - a.z) - dz * (p.y - a.y);
        if (s == 0) s = 0 - dz;
        if (s == 0) s = dy;
        return s == 0 ? 0 : (s > 0 ? turn : 0 - turn);
    };
    double winding = 0;
    for (size_t i = 0; i < triangles.size(); ++i) {
        const auto [a, b, c] = triangle(i);
        if (std::max({a.x, b.x, c.x}) <= p.x) continue;
        const double turn = side(a, b);
        if (turn == 0 || side(b, c) != turn || side(c, a) != turn) continue;
        const Vec3d n = cross(b - a, c - a);
        if (n.x == 0) continue;
        if (a.x - (n.y * (p.y - a.y) + n.z * (p.z - a.z)) / n.x > p.x) winding += turn;
    }
    return winding > 0;
}

void add_triangle(const std::array<Vec3d, 3>& triangle, std::span<const Side> sides,
                  const Affine3d& map, Box3d* out) {
    if (sides.empty()) {
        for (const Vec3d& p : triangle)
            out->add(map.apply(p));
        return;
    }
    thread_local std::vector<Vec3d> polygon, scratch;
    polygon.assign(triangle.begin(), triangle.end());
    for (const Side& side : sides) {
        if (polygon.empty()) return;
        clip(side, &polygon, &scratch);
    }
    for (const Vec3d& p : polygon)
        out->add(map.apply(p));
}

bool may_hold(std::span<const Side> sides, const Box3f& box) {
    return std::all_of(sides.begin(), sides.end(), [&](const Side& side) {
        Vec3d deepest;
        for (int a = 0; a < 3; ++a) {
            const bool up = (side.normal[a] > 0) == side.front;
            deepest[a] = static_cast<double>(up ? box.hi[a] : box.lo[a]);
        }
        return side.depth(deepest) >= 0;
    });
}

Box3d corner_box(const Box3d& box, const Region& region, const Affine3d& map) {
    Box3d out;
    add_corners(
        region, map, [&](const Vec3d& p) { return holds(box, p); }, &out);
    return out;
}

Box3d added_box(const Box3d& box, const Region& region, const Affine3d& map) {
    Box3d out;
    add_shapes(region, box, map, &out);
    return out;
}

Box3d piece_box(const Body& body, const Region& region, const Affine3d& map) {
    Box3d out, whole;
    for (const Vec3d& p : body.positions)
        whole.add(p);
    if (region.shapes_only || whole.empty()) return added_box(whole, region, map);
    for (size_t i = 0; i < body.triangles.size(); ++i)
        add_triangle(body.triangle(i), region.sides, map, &out);
    add_corners(
        region, map, [&](const Vec3d& p) { return holds(whole, p) && body.holds(p); }, &out);
    if (!out.empty()) add_shapes(region, whole, map, &out);
    return out;
}

Box3d piece_box(const Box3d& box, const Region& region, const Affine3d& map) {
    // The faces of the box as a mesh.
    std::vector<Vec3d> corners;
    for (uint32_t i = 0; i < 8; ++i) {
        corners.push_back({(i & 1) != 0 ? box.hi.x : box.lo.x, (i & 2) != 0 ? box.hi.y : box.lo.y,
                           (i & 4) != 0 ? box.hi.z : box.lo.z});
    }
    const std::vector<std::array<int32_t, 3>> triangles = {
        {0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
        {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return piece_box(Body{corners, triangles}, region, map);
}

double distance(const Shape& shape, const std::array<Vec3d, 3>& triangle) {
    // Nearest points in turn; the plane between them bounds the distance from below.
    constexpr int kMost = 400;
    constexpr double kGap_mm = 1e-4;
    Vec3d on = nearest_of_triangle(triangle, shape.at + shape.n * (shape.hi / 2));
    double below = 0;
    for (int i = 0; i < kMost; ++i) {
        const Vec3d in = shape.nearest(on);
        on = nearest_of_triangle(triangle, in);
        const Vec3d away = on - in;
        const double size = length(away);
        if (size < 1e-9) return 0;
        const Vec3d d = away * (1 / size);
        double nearest = 1e300;
        for (const Vec3d& corner : triangle)
            nearest = std::min(nearest, dot(d, corner));
        below = std::max(below, nearest - dot(d, shape.farthest(d)));
        if (size - below < kGap_mm) break;
    }
    return below;
}

std::string misfit(const Body& body, const Region& region, double moves_mm,
                   SourceLocation* location) {
    constexpr double kSlack_mm = 1e-3;
    for (const Fit& fit : region.fits) {
        *location = fit.location;
        Shape shape = fit.shape.upper();
        // A dovetail runs out of the part; what counts is its cross-section.
        if (fit.slides) shape.half_length = 0;
        const Vec3d middle = shape.at + shape.n * (shape.hi / 2);
        for (size_t s = 0; s < region.sides.size(); ++s) {
            if (region.cuts[s] == fit.cut) continue;
            const Side& side = region.sides[s];
            const Vec3d outwards = side.front ? side.normal * -1.0 : side.normal;
            const double reach = 0 - side.depth(shape.farthest(outwards));
            if (reach > 0) {
                return fmt::format("{} reaches {:.3g} mm through another cut of piece `{}`",
                                   fit.what, reach, region.name);
            }
        }
        if (!body.holds(middle)) {
            return fmt::format("{} is not inside the part, in piece `{}`", fit.what, region.name);
        }
        const double wanted = fit.skin_mm + moves_mm;
        const Box3d box = shape.box();
        double least = 1e300;
        for (size_t i = 0; i < body.triangles.size(); ++i) {
            const std::array<Vec3d, 3> t = body.triangle(i);
            Box3d of;
            for (const Vec3d& p : t)
                of.add(p);
            const Vec3d grow{wanted, wanted, wanted};
            if (!of.overlaps({box.lo - grow, box.hi + grow})) continue;
            least = std::min(least, distance(shape, t));
        }
        if (least < wanted - kSlack_mm) {
            return least > 0 ? fmt::format(
                                   "{} is {:.3g} mm from the surface of piece `{}`, and {:.3g} mm "
                                   "are asked for",
                                   fit.what, least, region.name, wanted)
                             : fmt::format("{} reaches through the surface of piece `{}`", fit.what,
                                           region.name);
        }
    }
    return {};
}

}  // namespace openfab::pieces
