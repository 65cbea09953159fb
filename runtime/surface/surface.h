// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The displaced surface of a part, in patches that are diced and displaced on demand (Reyes order).
//
// A base triangle whose displacement interval is exactly zero and whose outputs copy inputs is an
// *identity* triangle: one patch, the base triangle itself. Any other is *displaced*: split on its
// barycentric lattice into patches of at most 32 micro-edges a side. Where the two sides of a base
// edge displace differently a strip joins them, and a fan closes the corner; strips and fans are
// patches too, after all others. Together the patches marked kForCoverage are a closed surface
// wherever the base mesh is closed: every directed micro-edge (of positions, to the bit) has its
// opposite.
//
// Specification of dicing (lattice.h has the formulas; tests/support/reference/dice.h does the
// same, one vertex at a time):
//  - Edge factor: n(e) = max(1, ceil(|e| / s)) in double; more than 65535 on a displaced triangle
//    is refused.
//  - Vertices are welded by position. A triangle with two equal corners is left out.
//  - The lattice of a displaced triangle has N = the largest of its three factors. A lattice point
//    on an edge with n < N is the edge point round(i n / N), counted from the edge's lower end
//    (first in x, y, z order); the triangles of no area that this makes are left out. Tiles are
//    ordered row after row of b; in a tile, cells row after row of b; in a cell, first
//    (a, b) (a+1, b) (a, b+1), then (a+1, b) (a+1, b+1) (a, b+1).
//  - Points between the ends of an edge are interpolated from its two ends, from the lower one;
//    others from corner 0. Positions are double until they are rounded to float, inputs float.
//  - Shared evaluation: corners of displaced triangles at one vertex are *alike* if normal, uv and
//    all inputs have equal bits. The lowest alike triangle evaluates a corner for all; the points
//    between the ends of an edge are evaluated by the lowest displaced triangle on the edge that is
//    alike at both ends. Gradients, ng, dpdu and dpdv are the evaluator's. Identity triangles are
//    not evaluated: their points do not move.
//  - An edge is *divided* if a displaced triangle is on it. An identity triangle with divided sides
//    (of n > 1) is a fan over the edge points for the voxeliser, from the opposite corner
//    where one side is divided, else from the centroid; queries see the base triangle.
//  - Sides are paired along an edge: the k-th that runs up with the k-th that runs down, in order
//    of triangles. Between points i and i + 1 of the up side T and the down side U a strip has
//    (T[i+1], T[i], U[i]) and (T[i+1], U[i], U[i+1]). Ints of a strip come from the lower triangle
//    of the pair (computed ones from its point i).
//  - A strip is folded at the points that strip_fold.h names: it goes through E[i], the edge point
//    before displacement. Where both i and i + 1 are folded it has (T[i+1], T[i], E[i]),
//    (T[i+1], E[i], E[i+1]), (E[i+1], E[i], U[i]), (E[i+1], U[i], U[i+1]); where only i is,
//    (T[i+1], T[i], E[i]), (T[i+1], E[i], U[i+1]), (U[i+1], E[i], U[i]); where only i + 1 is,
//    (T[i+1], T[i], E[i+1]), (E[i+1], T[i], U[i]), (E[i+1], U[i], U[i+1]). Before them comes
//    (T, U, E) if the edge's first point is folded, after them (U, T, E) if its last is. A triangle
//    with points of one side has that side's attributes and ints (at i), others T's at E.
//  - At a vertex, for each side that leaves it, in order of corners: (position in the first
//    triangle of all at the vertex, position in the partner's triangle, position in the side's
//    own). Ints come from the first.
//  - Order of patches: base triangles (an identity before its fans), strips by their lowest side,
//    vertices by their first corner.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "base/vec.h"
#include "pieces/region.h"
#include "runtime/part/part.h"
#include "runtime/segments/printf_log.h"

namespace openfab::surface {

enum PatchUse : uint8_t {
    kForQuery = 1,     ///< nearest-point queries see it
    kForCoverage = 2,  ///< the voxeliser sees it
};

enum class PatchKind : uint8_t {
    kIdentity,  ///< the whole base triangle, not displaced
    kLattice,   ///< part of a displaced base triangle
    kFan,       ///< coverage only: an identity triangle diced to meet displaced neighbours
    kSeam,      ///< strips and corner fans
};

/// A unit of dicing. Patch ids are indices into Surface::patches(), ordered by (base triangle,
/// tile), seams last, so ties of nearest queries go to the lowest (patch id, triangle in patch).
struct Patch {
    PatchKind kind = PatchKind::kIdentity;
    uint8_t use = kForQuery | kForCoverage;
    uint16_t factor = 0;    ///< kLattice: N of the base triangle
    int32_t triangle = -1;  ///< base triangle; -1 for seams
    /// kLattice: first a, first b, last a, last b (vertices); kFan: first and end of the fan's
    /// triangles in [0] and [2]
    std::array<int32_t, 4> lattice{};
    Box3f bounds;  ///< conservative box of all displaced points, part-local mm
};

/// The micropolygons of one patch. Triangles of no area (equal corner indices or equal positions)
/// are left out. Attributes are those of the fablet's @nearest inputs, in their order; kFan patches
/// have none.
struct MicroMesh {
    std::vector<Vec3f> positions;                   ///< part-local mm
    std::vector<std::array<int32_t, 3>> triangles;  ///< counter-clockwise from outside
    /// Positions have the same bits on both sides of a corner or edge that two patches share.
    std::vector<float>
        vertex_attributes;  ///< [vertex][float component], float nearest inputs flattened
    std::vector<uint32_t>
        triangle_attributes;  ///< [triangle][int component], other nearest inputs flattened
    size_t bytes() const;
};

/// Conservative ranges of the @nearest inputs over each patch: lo and hi per flattened component,
/// floats and ints apart.
struct PatchRanges {
    std::vector<float> float_lo, float_hi;  ///< [patch][float component]
    std::vector<int32_t> int_lo, int_hi;    ///< [patch][int component]
    int32_t float_components = 0;
    int32_t int_components = 0;
};

struct SurfaceOptions {
    double micro_edge_mm = 0.1;       ///< s: the geometric mean of the print's pitches
    size_t cache_bytes = 256u << 20;  ///< budget of the micropolygon cache
    openfab_isa isa = OPENFAB_ISA_AVX2;
    bool infer_identity = true;  ///< off: every triangle is diced
    /// Once set, dicing and bounding stop and patches come back empty, so that callers finish
    /// early. It must stay set, and outlive the surface or be replaced by set_stop.
    const std::atomic<bool>* stop = nullptr;
    bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

struct SurfaceCounts {
    int64_t micro_triangles = 0;  ///< diced, those diced again after eviction included
    int64_t not_finite = 0;       ///< displacements that were NaN or infinite, taken as 0
    int64_t cut_to_bound = 0;
    int64_t cache_hits = 0, cache_misses = 0, cache_evictions = 0;
    int64_t cache_peak_bytes = 0;
};

/// Returns a message for each way in which displacements of the part were changed.
std::vector<std::string> displacement_warnings(const part::Part& part, const SurfaceCounts& counts);

/// A flat convex polygon grown by a box: all p + d with p in the hull of the corners and d in
/// `grow`. Part-local mm.
struct GrownPolygon {
    int32_t count = 0;
    std::array<Vec3d, 5> corners;
    Box3d grow;

    void add(const Vec3d& corner) { corners[static_cast<size_t>(count++)] = corner; }
};

/// The displaced surface of one part.
class Surface {
  public:
    /// Sets up patches and bounds (surface_bounds kernel). The part must outlive the surface.
    static Result<std::unique_ptr<Surface>> create(const part::Part& part,
                                                   const SurfaceOptions& options);
    virtual ~Surface() = default;

    virtual const std::vector<Patch>& patches() const = 0;
    virtual const PatchRanges& ranges() const = 0;
    /// Returns whether no patch is displaced: queries can use the base mesh.
    virtual bool identity() const = 0;

    /// Returns the patch's micropolygons, diced if they are not cached. From any thread; the handle
    /// pins them.
    virtual std::shared_ptr<const MicroMesh> micro(int32_t patch) const = 0;

    /// Gets the corners of an identity patch's triangle, with the bits of micro(); false if it has
    /// no triangle. For reading all of a large mesh: allocates and counts nothing.
    virtual bool identity_corners(int32_t patch, std::array<Vec3f, 3>* out) const = 0;

    /// Appends pieces that together hold every micropolygon of the patch, without dicing it: the
    /// base surface grown by its displacement bounds, in pieces of about a tile. Tighter than
    /// `bounds` if the base surface is slanted.
    virtual void displacement_bounds(int32_t patch, std::vector<GrownPolygon>* out) const = 0;

    /// Returns the exact box of all coverage micro-vertices under an affine map, by branch and
    /// bound over patches.
    virtual Box3d exact_box(const Affine3d& local_to_other) const = 0;
    /// Returns the same of what of the micropolygons is on all these sides, part-local; a surface may
    /// give that of all.
    virtual Box3d box_on_sides(const Affine3d& local_to_other,
                               std::span<const pieces::Side> /*sides*/) const {
        return exact_box(local_to_other);
    }
    virtual SurfaceCounts counts() const = 0;
    /// Appends what the surface stage prints, which is nothing if no printf or assert was compiled:
    /// at each vertex of the lattices of displaced triangles once, by triangle, then b, then a, as
    /// its evaluator sees it. On a surface with infer_identity off these are all triangles.
    virtual void log(segments::PrintfLog* /*log*/) const {}
    /// Changes the budget of the micropolygon cache, if any; call while no other thread uses it.
    virtual void set_cache_bytes(size_t /*bytes*/) const {}
    /// Replaces SurfaceOptions::stop for dicing; call while no other thread uses it. Trees and
    /// crossings that were made of empty patches stay in their caches: a caller that goes on after a
    /// stop sets none (null).
    virtual void set_stop(const std::atomic<bool>* /*stop*/) const {}
    /// Returns an error once a surface kernel has failed; the patch it ran for came back empty. To
    /// be checked after each slab.
    virtual Result<void> status() const { return {}; }
};

}  // namespace openfab::surface
