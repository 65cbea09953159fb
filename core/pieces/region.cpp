// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "pieces/region.h"

#include <algorithm>
#include <cmath>

#include "base/polar.h"

namespace openfab::pieces {

namespace {

double squared(double x) {
    return x * x;
}

/// Returns the squared distance of a point from a stroke.
double from_stroke(const std::array<double, 4>& s, double u, double v) {
    const double du = s[2] - s[0], dv = s[3] - s[1];
    const double length = du * du + dv * dv;
    double t = length > 0 ? ((u - s[0]) * du + (v - s[1]) * dv) / length : 0;
    t = std::clamp(t, 0.0, 1.0);
    return squared(u - s[0] - t * du) + squared(v - s[1] - t * dv);
}

}  // namespace

bool Shape::contains(const Vec3d& p) const {
    const Vec3d d = p - at;
    const double along = dot(d, n);
    if (!(along >= lo && along <= hi)) return false;
    const double x = dot(d, u), y = dot(d, v);
    switch (kind) {
        case Kind::kCylinder:
            return x * x + y * y <= radius * radius;
        case Kind::kDovetail:
            return std::fabs(y) <= half_length &&
                   std::fabs(x) <= half_width + slope * std::max(along, 0.0);
        case Kind::kStrokes:
            return std::any_of(strokes.begin(), strokes.end(), [&](const auto& stroke) {
                return from_stroke(stroke, x, y) <= radius * radius;
            });
    }
    return false;
}

/// Returns the box of the strokes: lowest u and v, highest u and v.
std::array<double, 4> Shape::flat_box() const {
    std::array<double, 4> box{1e30, 1e30, -1e30, -1e30};
    for (const auto& s : strokes) {
        box[0] = std::min({box[0], s[0] - radius, s[2] - radius});
        box[1] = std::min({box[1], s[1] - radius, s[3] - radius});
        box[2] = std::max({box[2], s[0] + radius, s[2] + radius});
        box[3] = std::max({box[3], s[1] + radius, s[3] + radius});
    }
    return box;
}

Vec3d Shape::farthest(const Vec3d& direction) const {
    const double x = dot(direction, u), y = dot(direction, v), z = dot(direction, n);
    double along = z > 0 ? hi : lo;
    switch (kind) {
        case Kind::kCylinder: {
            const double flat = std::sqrt(x * x + y * y);
            const double by = flat > 0 ? radius / flat : 0;
            return at + u * (x * by) + v * (y * by) + n * along;
        }
        case Kind::kDovetail: {
            const double side = x > 0 ? 1 : -1;
            const auto corner = [&](double to) { return side * (half_width + slope * to); };
            if (x * corner(lo) + z * lo > x * corner(hi) + z * hi) {
                along = lo;
            } else {
                along = hi;
            }
            return at + u * corner(along) + v * (y > 0 ? half_length : 0 - half_length) + n * along;
        }
        case Kind::kStrokes: {
            const std::array<double, 4> box = flat_box();
            return at + u * (x > 0 ? box[2] : box[0]) + v * (y > 0 ? box[3] : box[1]) + n * along;
        }
    }
    return at;
}

Vec3d Shape::nearest(const Vec3d& p) const {
    const Vec3d d = p - at;
    double x = dot(d, u), y = dot(d, v), z = dot(d, n);
    if (kind == Kind::kCylinder) {
        const double flat = std::sqrt(x * x + y * y);
        if (flat > radius) x *= radius / flat, y *= radius / flat;
        z = std::clamp(z, lo, hi);
    } else {
        y = std::clamp(y, 0 - half_length, half_length);
        // The cross-section is a convex polygon: inside, or the nearest point of its edges.
        const double w0 = half_width + slope * lo, w1 = half_width + slope * hi;
        if (!(z >= lo && z <= hi && std::fabs(x) <= half_width + slope * z)) {
            const double corners[4][2] = {{0 - w0, lo}, {w0, lo}, {w1, hi}, {0 - w1, hi}};
            double best = 1e300, bx = x, bz = z;
            for (size_t i = 0; i < 4; ++i) {
                const double* a = corners[i];
                const double* b = corners[(i + 1) % 4];
                const double dx = b[0] - a[0], dz = b[1] - a[1];
                const double length = dx * dx + dz * dz;
                double t = length > 0 ? ((x - a[0]) * dx + (z - a[1]) * dz) / length : 0;
                t = std::clamp(t, 0.0, 1.0);
                const double at_x = a[0] + t * dx, at_z = a[1] + t * dz;
                const double distance = squared(x - at_x) + squared(z - at_z);
                if (distance < best) best = distance, bx = at_x, bz = at_z;
            }
            x = bx, z = bz;
        }
    }
    return at + u * x + v * y + n * z;
}

Box3d Shape::box() const {
    Box3d out;
    // A dovetail is as wide below as at 0, so its corners are those of the upper part and below.
    Shape part = *this;
    for (const double from : {std::max(lo, 0.0), std::min(lo, 0.0)}) {
        part.lo = from;
        if (from < 0) part.slope = 0;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d direction;
            direction[axis] = 1;
            out.add(part.farthest(direction));
            direction[axis] = -1;
            out.add(part.farthest(direction));
        }
    }
    return out;
}

Shape Shape::grown(double by) const {
    Shape out = *this;
    out.lo = lo - by;
    out.hi = hi + by;
    out.radius = radius + by;
    // The slanted side moves by `by` at a right angle.
    out.half_width = half_width + by * std::sqrt(1 + slope * slope);
    out.half_length = half_length + by;
    return out;
}

Shape Shape::upper() const {
    Shape out = *this;
    out.lo = std::max(lo, 0.0);
    return out;
}

bool Region::contains(const Vec3d& p) const {
    const auto holds = [&](const Shape& shape) { return shape.contains(p); };
    bool in = !shapes_only && std::all_of(sides.begin(), sides.end(), [&](const Side& side) {
        return (dot(side.normal, p) > side.offset) == side.front;
    });
    in = in || std::any_of(added.begin(), added.end(), holds);
    return in && std::none_of(removed.begin(), removed.end(), holds);
}

Vec3d apart(const Region& region, double gap_mm) {
    Vec3d out;
    const double way = region.shapes_only ? gap_mm / 4 : gap_mm / 2;
    for (const Side& side : region.sides)
        out = out + side.normal * (side.front ? way : 0 - way);
    return out;
}

double uniform_scale(const std::array<double, 9>& stretch) {
    const double scale = stretch[0];
    for (size_t i = 0; i < 9; ++i) {
        const double want = i % 4 == 0 ? scale : 0;
        if (!(std::fabs(stretch[i] - want) <= 1e-6 * scale)) return 0;
    }
    return scale;
}

Region mapped(const Region& region, const std::array<double, 9>& stretch, const Vec3d& center) {
    Region out = region;
    const Affine3d normals{inverse_transposed(stretch), {}};
    for (Side& side : out.sides) {
        const Vec3d normal = normals.apply_vector(side.normal);
        const double size = length(normal);
        side.normal = normal * (1 / size);
        side.offset = side.offset / size - dot(side.normal, center);
    }
    const double scale = stretch[0];
    const auto map = [&](Shape* shape) {
        shape->at = Affine3d{stretch, {}}.apply_vector(shape->at) - center;
        for (double* size :
             {&shape->radius, &shape->lo, &shape->hi, &shape->half_width, &shape->half_length})
            *size *= scale;
        for (auto& stroke : shape->strokes) {
            for (double& x : stroke)
                x *= scale;
        }
        *shape = shape->grown(shape->clearance);
        shape->clearance = 0;
    };
    for (Shape& shape : out.added)
        map(&shape);
    for (Shape& shape : out.removed)
        map(&shape);
    for (Filled& filled : out.filled)
        map(&filled.shape);
    for (Fit& fit : out.fits)
        map(&fit.shape);
    return out;
}

}  // namespace openfab::pieces
