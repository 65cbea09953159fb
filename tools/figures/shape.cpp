// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace openfab::figures {

namespace {

/// Distance to a cone with balls at its ends: the ends' radii are blended along the nearest point
/// of the axis, which is exact for equal radii and close to it for slender cones.
double round_cone(const Part& part, Vec3d p) {
    const Vec3d along = part.b - part.a;
    const Vec3d from = p - part.a;
    const double t = std::clamp(dot(from, along) / dot(along, along), 0.0, 1.0);
    return length(from - along * t) - (part.ra + (part.rb - part.ra) * t);
}

/// Distance to an ellipsoid to first order (value over length of the gradient).
double ellipsoid(const Part& part, Vec3d p) {
    const Vec3d from = p - part.a;
    const Vec3d axis = part.axis * (1 / length(part.axis));
    const Vec3d local{dot(from, axis), from.y, from.z * axis.x - from.x * axis.z};
    const Vec3d scaled{local.x / part.b.x, local.y / part.b.y, local.z / part.b.z};
    const Vec3d twice{scaled.x / part.b.x, scaled.y / part.b.y, scaled.z / part.b.z};
    const double inner = length(scaled);
    const double slope = length(twice);
    if (slope < 1e-9) return -std::min({part.b.x, part.b.y, part.b.z});
    return inner * (inner - 1) / slope;
}

/// A disc about the z axis with a rounded edge: b = (radius, half height, radius of the edge).
double disc(const Part& part, Vec3d p) {
    const Vec3d from = p - part.a;
    const double edge = part.b.z;
    const double x = std::sqrt(from.x * from.x + from.y * from.y) - (part.b.x - edge);
    const double z = std::abs(from.z) - (part.b.y - edge);
    const double outside =
        std::sqrt(std::max(x, 0.0) * std::max(x, 0.0) + std::max(z, 0.0) * std::max(z, 0.0));
    return outside + std::min(std::max(x, z), 0.0) - edge;
}

double distance_to(const Part& part, Vec3d p) {
    switch (part.kind) {
        case Part::Kind::kRoundCone:
            return round_cone(part, p);
        case Part::Kind::kEllipsoid:
            return ellipsoid(part, p);
        case Part::Kind::kDisc:
            return disc(part, p);
        case Part::Kind::kAbove:
            break;
    }
    return p.z - part.a.z;
}

double smooth_min(double a, double b, double width) {
    if (width <= 0) return std::min(a, b);
    const double h = std::max(width - std::abs(a - b), 0.0) / width;
    return std::min(a, b) - h * h * width * 0.25;
}

void set_bounds(Part* part) {
    part->center = part->a;
    switch (part->kind) {
        case Part::Kind::kRoundCone:
            part->center = (part->a + part->b) * 0.5;
            part->reach = length(part->a - part->b) * 0.5 + std::max(part->ra, part->rb);
            break;
        case Part::Kind::kEllipsoid:
            part->reach = std::max({part->b.x, part->b.y, part->b.z});
            break;
        case Part::Kind::kDisc:
            part->reach = part->b.x + part->b.y;
            break;
        case Part::Kind::kAbove:
            part->reach = 1e9;
            break;
    }
}

Vec3d mirrored(Vec3d v) {
    return {v.x, -v.y, v.z};
}

}  // namespace

Shape& Shape::cone(double blend, Vec3d a, double ra, Vec3d b, double rb) {
    parts_.push_back({Part::Kind::kRoundCone, Join::kAdd, blend, a, b, ra, rb, {1, 0, 0}});
    set_bounds(&parts_.back());
    return *this;
}

Shape& Shape::ball(double blend, Vec3d center, Vec3d radii, Vec3d axis) {
    parts_.push_back({Part::Kind::kEllipsoid, Join::kAdd, blend, center, radii, 0, 0, axis});
    set_bounds(&parts_.back());
    return *this;
}

Shape& Shape::disc(double blend, Vec3d center, double radius, double half_height, double edge) {
    parts_.push_back(
        {Part::Kind::kDisc, Join::kAdd, blend, center, {radius, half_height, edge}, 0, 0, {}});
    set_bounds(&parts_.back());
    return *this;
}

Shape& Shape::cut_ball(double blend, Vec3d center, Vec3d radii, Vec3d axis) {
    ball(blend, center, radii, axis);
    parts_.back().join = Join::kCut;
    return *this;
}

Shape& Shape::cut_cone(double blend, Vec3d a, double ra, Vec3d b, double rb) {
    cone(blend, a, ra, b, rb);
    parts_.back().join = Join::kCut;
    return *this;
}

Shape& Shape::above(double height, double blend) {
    // Cut off the part below the plane: the part's own value is positive above.
    parts_.push_back({Part::Kind::kAbove, Join::kCut, blend, {0, 0, height}, {}, 0, 0, {1, 0, 0}});
    set_bounds(&parts_.back());
    return *this;
}

Shape& Shape::mirror(int count) {
    const size_t first = parts_.size() - static_cast<size_t>(count);
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
        Part part = parts_[first + i];
        part.a = mirrored(part.a);
        if (part.kind == Part::Kind::kRoundCone) part.b = mirrored(part.b);
        set_bounds(&part);
        parts_.push_back(part);
    }
    return *this;
}

double Shape::value(Vec3d p) const {
    double value = 1e6;
    for (const Part& part : parts_) {
        // A part that is too far away to matter costs one distance. A cut matters where it is
        // nearer than the surface.
        const double least = length(p - part.center) - part.reach;
        if (least > (part.join == Join::kAdd ? value : -value) + 2 * part.blend_mm + 0.1) continue;
        const double d = distance_to(part, p);
        value = part.join == Join::kAdd ? smooth_min(value, d, part.blend_mm)
                                        : -smooth_min(-value, d, part.blend_mm);
    }
    return value;
}

Vec3d Shape::gradient(Vec3d p) const {
    constexpr double kStep = 1.0 / 256;
    const Vec3d difference{value({p.x + kStep, p.y, p.z}) - value({p.x - kStep, p.y, p.z}),
                           value({p.x, p.y + kStep, p.z}) - value({p.x, p.y - kStep, p.z}),
                           value({p.x, p.y, p.z + kStep}) - value({p.x, p.y, p.z - kStep})};
    return difference * (0.5 / kStep);
}

}  // namespace openfab::figures
