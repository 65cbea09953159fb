// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A beam as it is asked for its distance: the exact signed distance of a point to a round cone, which is
// the hull of two balls, or to a cone cut across with flat or domed ends. Both are bodies of revolution,
// so that a point has two coordinates: y along the axis, x across.
//
// Of a round cone, the point of the axis whose ball is nearest is y - x k / sqrt(1 - k²) from the first
// end, kept within the beam, with k = (r0 - r1) / length: the distance to balls of the axis is a convex
// function of their place. All operations are in float, in one order, so that every caller gets equal
// bits; sums of squares of three do not cancel, which keeps rule 16 far from the axis, too.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/infinity.h"
#include "base/vec.h"
#include "mesh/model/beams.h"

namespace openfab::solid {

struct BeamRecord {
    Vec3f at;     ///< of the first end, part-local mm
    Vec3f along;  ///< unit; 0 of a ball
    float length = 0;
    float radius = 0;  ///< of the first end
    float slope = 0;   ///< how fast the radius falls along the axis
    float tilt = 0;    ///< slope / sqrt(1 - slope²) of a round cone
    std::array<int32_t, 2> nodes{};
    int32_t number = 0;  ///< among the beams; ties go to the lowest
    bool round = true;
    std::array<bool, 2> dome{};  ///< of a cone cut across: half a ball is on this end
};

/// A point in the coordinates of a beam.
struct BeamPoint {
    float y = 0, x2 = 0;  ///< along the axis; square of the distance from it
};

inline BeamPoint in_beam(const BeamRecord& beam, float px, float py, float pz) {
    const float dx = px - beam.at.x, dy = py - beam.at.y, dz = pz - beam.at.z;
    const float y = (dx * beam.along.x + dy * beam.along.y) + dz * beam.along.z;
    const float vx = dx - y * beam.along.x, vy = dy - y * beam.along.y, vz = dz - y * beam.along.z;
    return {y, (vx * vx + vy * vy) + vz * vz};
}

/// Returns the place on the axis of a round cone whose ball is nearest to a point.
inline float nearest_ball(const BeamRecord& beam, const BeamPoint& p) {
    float s = p.y - std::sqrt(p.x2) * beam.tilt;
    s = s < 0.0f ? 0.0f : s;
    return s > beam.length ? beam.length : s;
}

inline float round_distance(const BeamRecord& beam, float px, float py, float pz) {
    const BeamPoint p = in_beam(beam, px, py, pz);
    const float s = nearest_ball(beam, p), ahead = p.y - s;
    return std::sqrt(p.x2 + ahead * ahead) - (beam.radius - beam.slope * s);
}

/// The nearest point of the outline of a cone cut across.
struct OutlinePoint {
    float distance2 = 0;
    float y = 0, x = 0;    ///< of the point
    float ny = 0, nx = 0;  ///< outward normal there, not of unit length
    bool inside = false;   ///< the one asked about
};

OutlinePoint nearest_outline(const BeamRecord& beam, float y, float x);

inline float cut_distance(const BeamRecord& beam, float px, float py, float pz) {
    const BeamPoint p = in_beam(beam, px, py, pz);
    const OutlinePoint near = nearest_outline(beam, p.y, std::sqrt(p.x2));
    const float d = std::sqrt(near.distance2);
    return near.inside ? 0.0f - d : d;
}

/// Returns the signed distance of a point, negative inside.
inline float beam_distance(const BeamRecord& beam, const Vec3f& p) {
    return beam.round ? round_distance(beam, p.x, p.y, p.z) : cut_distance(beam, p.x, p.y, p.z);
}

/// The point of a beam's surface that is nearest to another point.
struct BeamSurfacePoint {
    Vec3f position;
    Vec3f normal;      ///< unit, outward
    float share = 0;   ///< of the second node in attributes, 0 to 1
    Vec3f share_step;  ///< how the share changes along the surface, per mm
};

/// Finds it; `p` may be such a point itself.
BeamSurfacePoint nearest_of_beam(const BeamRecord& beam, const Vec3f& p);

/// Makes the record of a beam whose ends are these points, part-local mm. A round cone whose one ball
/// holds the other is that ball.
BeamRecord make_record(const mesh::Beam& beam, int32_t number, const Vec3d& first,
                       const Vec3d& second, double scale);

/// Returns the signed distance of a point to a box: nothing in the box has a lesser one.
inline float box_distance(const Box3f& box, const Vec3f& p) {
    float outside2 = 0, inside = -kInfinity;
    for (int a = 0; a < 3; ++a) {
        const float d = std::max(box.lo[a] - p[a], p[a] - box.hi[a]);
        inside = std::max(inside, d);
        const float out = std::max(d, 0.0f);
        outside2 += out * out;
    }
    return outside2 > 0 ? std::sqrt(outside2) : inside;
}

}  // namespace openfab::solid
