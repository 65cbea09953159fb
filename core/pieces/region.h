// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What belongs to one piece of a part: half-spaces, and closed forms that are added (pegs) or taken
// away (holes, numbers). No mesh is cut: a region is asked beside the winding number, so that a
// fablet sees the uncut part.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::pieces {

/// One side of a plane: where dot(normal, p) is above `offset`, or elsewhere. Both sides of a cut have
/// the same bits, so that together they are everything.
struct Side {
    Vec3d normal;
    double offset = 0;
    bool front = false;

    /// Returns how far a point is on this side, if the normal has length 1.
    double depth(const Vec3d& p) const {
        const double above = dot(normal, p) - offset;
        return front ? above : 0 - above;
    }
};

/// A cylinder along n, a dovetail that widens along n and runs along v, or strokes in the plane of u
/// and v, as thick as n goes. u, v and n are unit vectors at right angles.
struct Shape {
    enum class Kind : uint8_t { kCylinder, kDovetail, kStrokes };
    Kind kind = Kind::kCylinder;
    Vec3d at, u{1, 0, 0}, v{0, 1, 0}, n{0, 0, 1};
    double radius = 0;       ///< of a cylinder, of a stroke's ends
    double lo = 0, hi = 0;   ///< along n
    double half_width = 0;   ///< of a dovetail, along u at n = 0; it is as wide below
    double slope = 0;        ///< by which that grows along n
    double half_length = 0;  ///< of a dovetail, along v
    std::vector<std::array<double, 4>> strokes;  ///< from (u, v) to (u, v)
    double clearance = 0;                        ///< by which `mapped` grows it, in mm of the print

    bool contains(const Vec3d& p) const;
    /// Returns the point of it that is farthest along a direction; `lo` is at least 0. Of strokes: of
    /// the box that holds them.
    Vec3d farthest(const Vec3d& direction) const;
    /// Returns the nearest point of it; not of strokes, and `lo` is at least 0.
    Vec3d nearest(const Vec3d& p) const;
    Box3d box() const;
    /// Returns it larger on all sides by `by`.
    Shape grown(double by) const;
    /// Returns what is above n = 0.
    Shape upper() const;

  private:
    std::array<double, 4> flat_box() const;
};

/// A hole or a peg that must lie within the piece and away from the skin.
struct Fit {
    Shape shape;              ///< above its cut
    double skin_mm = 0;       ///< least distance from the part's surface
    bool slides = false;      ///< a dovetail, which leaves the part at an end
    int32_t cut = 0;          ///< of the sides, by number: the one that it stands on
    std::string what;         ///< in messages: "the hole of peg 2"
    SourceLocation location;  ///< of the connector
};

/// What is of another material than the part.
struct Filled {
    Shape shape;
    std::string material;
};

struct Region {
    std::string name;
    bool shapes_only = false;   ///< a dowel: nothing but what is added
    std::vector<Side> sides;    ///< of a dowel those of both pieces that it joins
    std::vector<int32_t> cuts;  ///< of the sides: number of the cut
    std::vector<Shape> added;   ///< first
    std::vector<Shape> removed;
    std::vector<Filled> filled;
    std::vector<Fit> fits;

    /// Returns whether a point belongs to it; of points on a cut the back has all.
    bool contains(const Vec3d& p) const;
};

/// Returns how far the piece moves, so that there are `gap_mm` at each cut.
Vec3d apart(const Region& region, double gap_mm);

/// Returns the least scale of a stretch if it is the same in all directions (1e-6), else 0.
double uniform_scale(const std::array<double, 9>& stretch);

/// Returns the region in the space p -> stretch p - center, of lengths there. Shapes that are not
/// scaled alike in all directions make no sense: `stretch` must have a uniform_scale if there are any.
/// Clearances stay what they are, in mm.
Region mapped(const Region& region, const std::array<double, 9>& stretch, const Vec3d& center);

}  // namespace openfab::pieces
