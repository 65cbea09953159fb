// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "base/infinity.h"
#include "runtime/solid/mesh/mesh_tops.h"
#include "runtime/surface/transform_box.h"
#include "runtime/voxel/crossings.h"
#include "runtime/voxel/snapping.h"

namespace openfab::solid {

namespace {

using surface::GrownPolygon;

// Slack in 1/256 voxel: snapping moves a point by half a unit, the infinitesimals of a sample are
// negligible; the rest far exceeds the rounding of double.
constexpr double kSlack = 1;
// Steeper planes give no better bound than the polygon's own height.
constexpr double kSteepest = 1e4;

double sample(int32_t voxel) {
    return 256.0 * voxel + 128;
}
/// Return the first voxel whose sample is at or above x, and the last at or below.
double first_at(double x) {
    return std::ceil((x - 128) / 256);
}
double last_at(double x) {
    return std::floor((x - 128) / 256);
}

/// A GrownPolygon in 1/256 voxel.
struct Piece {
    int32_t count = 0;
    std::array<Vec3d, 5> corners;
    Box3d box;     ///< of the corners
    Vec3d lo, hi;  ///< grow
    bool has_slope = false;
    double slope_x = 0, slope_y = 0;

    Piece(const Affine3d& map, const GrownPolygon& polygon) : count(polygon.count) {
        for (int32_t i = 0; i < count; ++i) {
            const auto k = static_cast<size_t>(i);
            corners[k] = map.apply(polygon.corners[k]);
            box.add(corners[k]);
        }
        for (int row = 0; row < 3; ++row) {
            for (int axis = 0; axis < 3; ++axis) {
                const double m = map.m[static_cast<size_t>(3 * row + axis)];
                const double a = m * polygon.grow.lo[axis], b = m * polygon.grow.hi[axis];
                lo[row] += std::min(a, b);
                hi[row] += std::max(a, b);
            }
            lo[row] -= kSlack;
            hi[row] += kSlack;
        }
        find_slope();
    }

    void find_slope() {
        Vec3d best;
        for (int32_t i = 1; i < count; ++i) {
            for (int32_t j = i + 1; j < count; ++j) {
                const Vec3d n = openfab::cross(corners[i] - corners[0], corners[j] - corners[0]);
                if (std::fabs(n.z) > std::fabs(best.z)) best = n;
            }
        }
        if (!(std::fabs(best.z) * kSteepest > std::fabs(best.x)) ||
            !(std::fabs(best.z) * kSteepest > std::fabs(best.y)))
            return;
        has_slope = true;
        slope_x = -best.x / best.z;
        slope_y = -best.y / best.z;
    }
};

/// Part of a piece's polygon between two values of y: its extent in x, and its height.
struct Slab {
    double x0 = kInfinity, x1 = -kInfinity, z = -kInfinity;

    void add(double x, double height) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        z = std::max(z, height);
    }
};

Slab slab_of(const Piece& piece, double y0, double y1) {
    Slab slab;
    for (int32_t i = 0; i < piece.count; ++i) {
        const Vec3d& a = piece.corners[i];
        if (a.y >= y0 && a.y <= y1) slab.add(a.x, a.z);
        // All pairs of corners; those that are not sides lie inside.
        for (int32_t j = i + 1; j < piece.count; ++j) {
            const Vec3d& b = piece.corners[j];
            for (const double y : {y0, y1}) {
                if ((a.y < y) == (b.y < y) || a.y == b.y) continue;
                const double t = (y - a.y) / (b.y - a.y);
                slab.add(a.x + t * (b.x - a.x), a.z + t * (b.z - a.z));
            }
        }
    }
    return slab;
}

void raise_to_piece(const Piece& piece, const part::Grid& grid, const Columns& columns,
                    TopRows* rows) {
    const double y_first = std::max<double>(first_at(piece.box.lo.y + piece.lo.y), columns.y0);
    const double y_last = std::min<double>(last_at(piece.box.hi.y + piece.hi.y), columns.y1 - 1);
    const double highest = grid.size.z - 1;
    for (double row = y_first; row <= y_last; ++row) {
        const auto y = static_cast<int32_t>(row);
        const double at_y = sample(y);
        const Slab slab = slab_of(piece, at_y - piece.hi.y, at_y - piece.lo.y);
        const double x_first = std::max<double>(first_at(slab.x0 + piece.lo.x), columns.x0);
        const double x_last = std::min<double>(last_at(slab.x1 + piece.hi.x), columns.x1 - 1);
        if (!(x_first <= x_last)) continue;
        const double top = slab.z + piece.hi.z;
        const auto raise = [&](int32_t x, double height) {
            rows->raise(x, y, static_cast<int32_t>(std::clamp(last_at(height), 0.0, highest)));
        };
        const auto x0 = static_cast<int32_t>(x_first), x1 = static_cast<int32_t>(x_last);
        if (!piece.has_slope) {
            for (int32_t x = x0; x <= x1; ++x)
                raise(x, top);
            continue;
        }
        // Returns the plane's maximum over the points that the box moves to the sample.
        const Vec3d& c = piece.corners[0];
        const double middle = c.z + piece.slope_y * (at_y - (piece.lo.y + piece.hi.y) / 2 - c.y) +
                              std::fabs(piece.slope_y) * (piece.hi.y - piece.lo.y) / 2 +
                              std::fabs(piece.slope_x) * (piece.hi.x - piece.lo.x) / 2 + piece.hi.z;
        const double from = (piece.lo.x + piece.hi.x) / 2 + c.x;
        for (int32_t x = x0; x <= x1; ++x)
            raise(x, std::min(top, middle + piece.slope_x * (sample(x) - from)));
    }
}

}  // namespace

void raise_to_bounds(const GridSurface& on, const Columns& columns, TopRows* rows) {
    const voxel::Snapping snapping(on.part, on.grid, false);
    const Box3d wanted{{sample(columns.x0) - 2 * kSlack, sample(columns.y0) - 2 * kSlack, 0},
                       {sample(columns.x1) + 2 * kSlack, sample(columns.y1) + 2 * kSlack, 0}};
    std::vector<GrownPolygon> pieces;
    // Boxes of patches contain their micropolygons, and nothing else needs support.
    const auto meets = [&](const Box3f& bounds) {
        const Box3d b = surface::transform_box(snapping.map(), bounds);
        return b.lo.x <= wanted.hi.x && b.hi.x >= wanted.lo.x && b.lo.y <= wanted.hi.y &&
               b.hi.y >= wanted.lo.y;
    };
    on.patches.find(meets, [&](int32_t patch) {
        pieces.clear();
        on.surface.displacement_bounds(patch, &pieces);
        for (const GrownPolygon& polygon : pieces)
            raise_to_piece(Piece(snapping.map(), polygon), on.grid, columns, rows);
    });
}

}  // namespace openfab::solid
