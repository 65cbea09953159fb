// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Boxes in the principal axes of their contents.

#include <array>
#include <cstdint>

#include "base/vec.h"
#include "runtime/nearest/tree/split.h"

namespace openfab::nearest {

/// Weight, first and second moments of a set of points about the origin, and the area vector of
/// their triangles. They are additive, so those of a node are the sum of its children's.
struct Moments {
    double weight = 0;
    Vec3d first;
    double second[6] = {0, 0, 0, 0, 0, 0};  // xx, xy, xz, yy, yz, zz
    Vec3d area;                             // zero where there are no triangles

    void add_point(const Vec3d& p, double w) {
        weight += w;
        first = first + p * w;
        const double s[6] = {p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z};
        for (int i = 0; i < 6; ++i)
            second[i] += w * s[i];
    }
    void add(const Moments& m) {
        weight += m.weight;
        first = first + m.first;
        area = area + m.area;
        for (int i = 0; i < 6; ++i)
            second[i] += m.second[i];
    }
};

/// A box: the points c with lo_k <= axis_k . c <= hi_k, mm.
struct OrientedBox {
    double axis[3][3];
    double lo[3], hi[3];

    /// Returns half its surface area.
    double half_area() const {
        const double s[3] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
        return s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
    }
    std::array<Vec3f, 8> corners() const;
    /// Returns the box, larger by `margin` on every side.
    OrientedBox grown(double margin) const {
        OrientedBox box = *this;
        for (int k = 0; k < 3; ++k) {
            box.lo[k] -= margin;
            box.hi[k] += margin;
        }
        return box;
    }
};

/// The frame of a set of points: origin at their mean, the principal axes of their moments. If
/// their triangles mostly face one way, the last axis is that direction and the others are the
/// principal axes across it. Coordinates are float, as they are small.
class PrincipalFrame {
  public:
    explicit PrincipalFrame(const Moments& moments);
    /// Coordinates of a point in the frame.
    F4 coordinates(const Vec3f& p) const {
        const F4 d = F4{p.x, p.y, p.z, 0} - mean_;
        return x_ * d[0] + y_ * d[1] + z_ * d[2];
    }
    /// Returns a box that holds all points with coordinates in `spread`.
    OrientedBox box(const Range& spread) const;

  private:
    double axes_[3][3];
    F4 x_, y_, z_, mean_;
};

/// Corner c of a box; bits 0 to 2: upper end of x, y, z.
inline Vec3f corner_of(const Box3f& b, int c) {
    return {(c & 1) != 0 ? b.hi.x : b.lo.x, (c & 2) != 0 ? b.hi.y : b.lo.y,
            (c & 4) != 0 ? b.hi.z : b.lo.z};
}

}  // namespace openfab::nearest
