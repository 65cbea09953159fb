// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Animals as implicit surfaces: round cones and ellipsoids, blended by a smooth minimum. All of it
// is + - * / and square roots, so that a figure has the same vertices on every machine. Lengths are
// millimetres; x points where the animal looks, z up.

#include <vector>

#include "base/vec.h"

namespace openfab::figures {

/// The operation that joins a part with the previous ones.
enum class Join { kAdd, kCut };

struct Part {
    enum class Kind { kRoundCone, kEllipsoid, kDisc, kAbove };
    Kind kind = Kind::kEllipsoid;
    Join join = Join::kAdd;
    double blend_mm = 0;  ///< width of the smooth join; 0 keeps a sharp edge
    Vec3d a;              ///< cone: first end; ellipsoid, disc: centre; above: (0, 0, height)
    Vec3d b;              ///< cone: second end; ellipsoid: radii; disc: (radius, half height, edge)
    double ra = 0;        ///< cone: radius at a
    double rb = 0;        ///< cone: radius at b
    Vec3d axis{1, 0, 0};  ///< ellipsoid: direction of its first radius, in the plane of x and z
    Vec3d center{};       ///< with reach: a ball that holds the part; set by Shape
    double reach = 0;
};

/// A solid: negative inside. Values are distances near the surface, to within a factor of about 2.
class Shape {
  public:
    Shape& cone(double blend, Vec3d a, double ra, Vec3d b, double rb);
    Shape& ball(double blend, Vec3d center, Vec3d radii, Vec3d axis = {1, 0, 0});
    Shape& disc(double blend, Vec3d center, double radius, double half_height, double edge);
    Shape& cut_ball(double blend, Vec3d center, Vec3d radii, Vec3d axis = {1, 0, 0});
    Shape& cut_cone(double blend, Vec3d a, double ra, Vec3d b, double rb);
    /// Keeps the part above z = height.
    Shape& above(double height, double blend);
    /// Adds mirror images of the last `count` parts in the plane y = 0.
    Shape& mirror(int count);

    double value(Vec3d p) const;
    /// Returns central differences over 1/256 mm; of about unit length at the surface.
    Vec3d gradient(Vec3d p) const;

  private:
    std::vector<Part> parts_;
};

}  // namespace openfab::figures
