// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/displacement_bounds.h"

#include <algorithm>
#include <cmath>

#include "runtime/surface/lattice.h"
#include "runtime/surface/tile_span.h"

namespace openfab::surface {

namespace {

// Bounds and micro-vertices are rounded to float a few times; relative to the largest coordinate.
constexpr double kRounding = 1.0 / (1 << 21);
// Edge points of one piece of a strip: as many as a tile's side.
constexpr int32_t kPieceEdges = kTileEdges;

class DisplacementBounds {
  public:
    DisplacementBounds(const BaseMesh& base, const PatchTable& table)
        : base_(base), table_(table) {}

    GrownPolygon triangle(int32_t t) const {
        GrownPolygon out;
        for (int32_t c = 0; c < 3; ++c)
            out.add(base_.position(3 * t + c));
        out.grow = {{0, 0, 0}, {0, 0, 0}};
        return widened(out);
    }
    GrownPolygon tile(const Patch& patch) const;
    void strip(const Seam& seam, std::vector<GrownPolygon>* out) const;
    GrownPolygon vertex(int32_t vertex) const;

  private:
    bool displaced(int32_t triangle) const {
        return base_.classes[triangle] == TriangleClass::kDisplaced;
    }
    const Patch& tile_patch(int32_t triangle, int32_t tile) const {
        return table_.patches[static_cast<size_t>(table_.first_patch[triangle] + tile)];
    }
    static GrownPolygon widened(GrownPolygon polygon);

    const BaseMesh& base_;
    const PatchTable& table_;
};

/// Grows the piece by more than the rounding of points and bounds.
GrownPolygon DisplacementBounds::widened(GrownPolygon polygon) {
    double largest = 0;
    for (int32_t i = 0; i < polygon.count; ++i) {
        for (int a = 0; a < 3; ++a)
            largest = std::max(largest, std::fabs(polygon.corners[i][a]));
    }
    for (int a = 0; a < 3; ++a) {
        const double slack =
            kRounding * (largest + std::fabs(polygon.grow.lo[a]) + std::fabs(polygon.grow.hi[a]));
        polygon.grow.lo[a] -= slack;
        polygon.grow.hi[a] += slack;
    }
    return polygon;
}

/// The patch's bounds are the box of its undisplaced points with the displacement's interval added
/// to each side, so the interval is what the box of these points is short of.
GrownPolygon DisplacementBounds::tile(const Patch& patch) const {
    const TileSpan span =
        span_tile(base_, patch.triangle,
                  {patch.lattice[0], patch.lattice[1], patch.lattice[2], patch.lattice[3]});
    const Vec3d v0 = base_.position(3 * patch.triangle),
                v1 = base_.position(3 * patch.triangle + 1),
                v2 = base_.position(3 * patch.triangle + 2);
    GrownPolygon out;
    Box3d points, snapped{{0, 0, 0}, {0, 0, 0}};
    for (int32_t i = 0; i < span.points; ++i) {
        const auto k = static_cast<size_t>(i);
        Vec3d p;
        for (int a = 0; a < 3; ++a)
            p[a] = lattice_coordinate(v0[a], v1[a], v2[a], span.wa[k], span.wb[k]);
        points.add(p);
        if (span.corner[k]) {
            out.add(p);
        } else {
            snapped.add(p - out.corners[out.count - 1]);
        }
    }
    const Box3d bounds{vec_cast<double>(patch.bounds.lo), vec_cast<double>(patch.bounds.hi)};
    out.grow.lo = bounds.lo - points.lo + snapped.lo;
    out.grow.hi = bounds.hi - points.hi + snapped.hi;
    return widened(out);
}

/// Each quad spans an edge point, displaced by both sides, and the next one.
void DisplacementBounds::strip(const Seam& seam, std::vector<GrownPolygon>* out) const {
    const int32_t n = base_.factor[seam.side];
    const Vec3d &lo = base_.position(base_.lower_corner(seam.side)),
                &hi = base_.position(base_.upper_corner(seam.side));
    for (int32_t i = seam.i0; i < seam.i1; i += kPieceEdges) {
        const int32_t end = std::min(i + kPieceEdges, seam.i1);
        GrownPolygon piece;
        piece.add(edge_position(lo, hi, i, n));
        piece.add(edge_position(lo, hi, end, n));
        if (seam.folds) piece.grow.add(Vec3d{0, 0, 0});
        for (const int32_t side : {seam.side, base_.partner[seam.side]}) {
            if (!displaced(side / 3)) {
                piece.grow.add(Vec3d{0, 0, 0});
                continue;
            }
            visit_side_tiles(base_, side, i, end, [&](int32_t number) {
                piece.grow.add(tile(tile_patch(side / 3, number)).grow);
            });
        }
        out->push_back(widened(piece));
    }
}

GrownPolygon DisplacementBounds::vertex(int32_t vertex) const {
    GrownPolygon out;
    const auto v = static_cast<size_t>(vertex);
    for (int32_t k = base_.vertex_first[v]; k < base_.vertex_first[v + 1]; ++k) {
        const int32_t corner = base_.vertex_corners[k];
        if (out.count == 0) out.add(base_.position(corner));
        if (displaced(corner / 3)) {
            out.grow.add(tile(tile_patch(corner / 3, corner_tile(base_, corner))).grow);
        } else {
            out.grow.add(Vec3d{0, 0, 0});
        }
    }
    return widened(out);
}

}  // namespace

Box3d tile_displacements(const BaseMesh& base, const PatchTable& table, int32_t patch) {
    return DisplacementBounds(base, table).tile(table.patches[patch]).grow;
}

void add_displacement_bounds(const BaseMesh& base, const PatchTable& table, int32_t patch,
                             std::vector<GrownPolygon>* out) {
    const DisplacementBounds finder(base, table);
    const Patch& p = table.patches[patch];
    switch (p.kind) {
        case PatchKind::kIdentity:
        case PatchKind::kFan:
            out->push_back(finder.triangle(p.triangle));
            return;
        case PatchKind::kLattice:
            out->push_back(finder.tile(p));
            return;
        case PatchKind::kSeam:
            break;
    }
    const Seam& seam = table.seams[static_cast<size_t>(patch - table.first_seam)];
    if (seam.side >= 0) {
        finder.strip(seam, out);
    } else {
        out->push_back(finder.vertex(seam.vertex));
    }
}

}  // namespace openfab::surface
