// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam.h"

#include <algorithm>

namespace openfab::solid {

namespace {

/// Returns a unit vector across a unit vector.
Vec3f across(const Vec3f& along) {
    const float ax = std::fabs(along.x), ay = std::fabs(along.y), az = std::fabs(along.z);
    const Vec3f axis = ax <= ay && ax <= az ? Vec3f{1, 0, 0}
                       : ay <= az           ? Vec3f{0, 1, 0}
                                            : Vec3f{0, 0, 1};
    const Vec3f v = cross(along, axis);
    const float len = length(v);
    return len > 0 ? v * (1 / len) : Vec3f{1, 0, 0};
}

}  // namespace

OutlinePoint nearest_outline(const BeamRecord& beam, float y, float x) {
    const float r0 = beam.radius, r1 = beam.radius - beam.slope * beam.length;
    // The slanted side, from (0, r0) to (length, r1).
    const float ey = beam.length, ex = r1 - r0;
    const float u = std::clamp((y * ey + (x - r0) * ex) / (ey * ey + ex * ex), 0.0f, 1.0f);
    OutlinePoint best;
    best.y = u * ey, best.x = r0 + u * ex;
    best.ny = 0.0f - ex, best.nx = ey;
    const float dy = y - best.y, dx = x - best.x;
    best.distance2 = dy * dy + dx * dx;
    best.inside = y >= 0 && y <= beam.length && x < r0 + (y / ey) * ex;
    for (int e = 0; e < 2; ++e) {
        const float end = e == 0 ? 0.0f : beam.length, r = e == 0 ? r0 : r1;
        const float out = e == 0 ? 0.0f - y : y - beam.length;  // beyond this end
        const float sign = e == 0 ? -1.0f : 1.0f;
        if (!beam.dome[static_cast<size_t>(e)]) {
            const float px = std::min(x, r);
            const float d2 = out * out + (x - px) * (x - px);
            if (d2 < best.distance2) {
                best.distance2 = d2;
                best.y = end, best.x = px;
                best.ny = sign, best.nx = 0;
            }
            continue;
        }
        if (out < 0) continue;  // the nearest of the dome is its rim
        const float d = std::sqrt(out * out + x * x), gap = d - r;
        if (gap < 0) best.inside = true;
        if (gap * gap < best.distance2) {
            best.distance2 = gap * gap;
            const float scale = d > 0 ? r / d : 0.0f;
            best.y = d > 0 ? end + sign * out * scale : end + sign * r;
            best.x = x * scale;
            best.ny = d > 0 ? sign * out : sign, best.nx = x;
        }
    }
    return best;
}

BeamSurfacePoint nearest_of_beam(const BeamRecord& beam, const Vec3f& p) {
    const Vec3f from = p - beam.at;
    const BeamPoint at = in_beam(beam, p.x, p.y, p.z);
    const float x = std::sqrt(at.x2);
    const bool ball = !(beam.length > 0);
    const Vec3f out =
        x > 0 ? (from - beam.along * at.y) * (1 / x) : across(ball ? Vec3f{0, 0, 1} : beam.along);
    float y, nx, ny, place;
    BeamSurfacePoint found;
    if (beam.round) {
        const float s = nearest_ball(beam, at), ahead = at.y - s;
        const float d = std::sqrt(at.x2 + ahead * ahead), r = beam.radius - beam.slope * s;
        const float c = std::sqrt(std::max(0.0f, 1 - beam.slope * beam.slope));
        ny = d > 0 ? ahead / d : ball ? 0.0f : beam.slope;
        nx = d > 0 ? x / d : ball ? 1.0f : c;
        place = s;
        y = s + r * ny;
        found.position = (beam.at + beam.along * y) + out * (r * nx);
    } else {
        const OutlinePoint near = nearest_outline(beam, at.y, x);
        const float len = std::sqrt(near.ny * near.ny + near.nx * near.nx);
        ny = len > 0 ? near.ny / len : 0.0f, nx = len > 0 ? near.nx / len : 1.0f;
        place = std::clamp(near.y, 0.0f, beam.length);
        found.position = (beam.at + beam.along * near.y) + out * near.x;
    }
    found.normal = beam.along * ny + out * nx;
    if (ball) {
        found.normal = x > 0 ? out : Vec3f{1, 0, 0};
        return found;
    }
    found.share = std::min(place / beam.length, 1.0f);
    // Caps have one value. On the side of a round cone the place on the axis runs ahead of the surface.
    if (place > 0 && place < beam.length) {
        const float stretch = beam.round ? 1 / std::max(nx, 1e-3f) : nx;
        found.share_step = (beam.along * nx - out * ny) * (stretch / beam.length);
    }
    return found;
}

BeamRecord make_record(const mesh::Beam& beam, int32_t number, const Vec3d& first,
                       const Vec3d& second, double scale) {
    BeamRecord out;
    out.number = number;
    out.nodes = beam.nodes;
    const double r0 = scale * static_cast<double>(beam.radii[0]);
    const double r1 = scale * static_cast<double>(beam.radii[1]);
    const Vec3d along = second - first;
    const double length = openfab::length(along);
    out.round = beam.ends[0] == mesh::BeamEnd::kBall && beam.ends[1] == mesh::BeamEnd::kBall;
    out.dome = {beam.ends[0] != mesh::BeamEnd::kFlat, beam.ends[1] != mesh::BeamEnd::kFlat};
    out.at = vec_cast<float>(first);
    out.radius = static_cast<float>(r0);
    const double fall = r0 - r1;
    if (out.round && !(std::fabs(fall) < length * (1 - 1e-9))) {
        const size_t larger = fall >= 0 ? 0 : 1;
        out.nodes = {beam.nodes[larger], beam.nodes[larger]};
        if (larger == 1) {
            out.at = vec_cast<float>(second);
            out.radius = static_cast<float>(r1);
        }
        return out;
    }
    if (!(static_cast<float>(length) > 0)) {
        out.round = true;
        return out;
    }
    out.along = vec_cast<float>(along * (1 / length));
    out.length = static_cast<float>(length);
    const double slope = fall / length;
    out.slope = static_cast<float>(slope);
    if (out.round) out.tilt = static_cast<float>(slope / std::sqrt(1 - slope * slope));
    return out;
}

}  // namespace openfab::solid
