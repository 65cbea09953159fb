// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The displaced surface of a part, in patches that are diced and displaced on demand (Reyes order).
//
// A base triangle whose displacement interval is exactly zero and whose outputs copy inputs is an *identity* triangle:
// one patch, the base triangle itself. Any other is split on its barycentric lattice into patches of at most 32 micro-edges
// a side. Where the two sides of a base edge displace differently a strip joins them, and a fan closes the corner; strips
// and fans are patches too, after all others. Together the patches marked kForCoverage are a closed surface wherever the
// base mesh is closed.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/abi/fablet_table.h"
#include "runtime/base/result.h"
#include "runtime/base/vec.h"
#include "runtime/scene/part.h"

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

/// Patch ids are places in Surface::patches(); they rise with (base triangle, place on the lattice), seams last, so the
/// tie rule of nearest queries is: lowest (patch id, triangle in patch).
struct Patch {
    PatchKind kind = PatchKind::kIdentity;
    uint8_t use = kForQuery | kForCoverage;
    int32_t triangle = -1;                 ///< base triangle; -1 for seams
    std::array<int32_t, 4> lattice{};      ///< kLattice: first a, first b, end a, end b
    Box3f bounds;                          ///< part-local mm, holds every displaced point: conservative
};

/// The micropolygons of one patch. Triangles of no area (equal corner indices or equal positions) are left out.
/// Attributes are those that the fablet's @nearest inputs read, in that order.
struct MicroMesh {
    std::vector<Vec3f> positions;                     ///< part-local mm
    std::vector<std::array<int32_t, 3>> triangles;    ///< counter-clockwise from outside
    /// Where two patches share a corner or an edge, positions have the same bits on both sides.
    std::vector<float> vertex_attributes;             ///< [vertex][float component], float nearest inputs flattened
    std::vector<uint32_t> triangle_attributes;        ///< [triangle][int component], other nearest inputs flattened
    size_t bytes() const;
};

/// Ranges of the @nearest inputs over a patch, conservative: lo/hi per flattened component, floats then ints apart.
struct PatchRanges {
    std::vector<float> float_lo, float_hi;      ///< [patch][float component]
    std::vector<int32_t> int_lo, int_hi;        ///< [patch][int component]
    int32_t float_components = 0;
    int32_t int_components = 0;
};

struct SurfaceOptions {
    double micro_edge_mm = 0.1;        ///< s: the geometric mean of the print's pitches
    size_t cache_bytes = 256u << 20;   ///< budget of the micropolygon cache
    openfab_isa isa = OPENFAB_ISA_AVX2;
    bool infer_identity = true;        ///< off: every triangle is diced
};

struct SurfaceCounts {
    int64_t micro_triangles = 0;   ///< made, counting again what was evicted
    int64_t not_finite = 0;        ///< displacements that were NaN or infinite, taken as 0
    int64_t cut_to_bound = 0;
    int64_t cache_hits = 0, cache_misses = 0, cache_evictions = 0;
    int64_t cache_peak_bytes = 0;
};

class Surface {
  public:
    /// Sets up patches and bounds (surface_bounds kernel). The part must outlive the surface.
    static Result<std::unique_ptr<Surface>> create(const scene::Part& part, const SurfaceOptions& options);
    virtual ~Surface() = default;

    virtual const std::vector<Patch>& patches() const = 0;
    virtual const PatchRanges& ranges() const = 0;
    /// True where no patch is displaced: queries can use the base mesh.
    virtual bool identity() const = 0;

    /// The patch's micropolygons, made if they are not in the cache. Any thread; the handle pins them.
    virtual std::shared_ptr<const MicroMesh> micro(int32_t patch) const = 0;

    /// The exact box of all coverage micro-vertices under an affine map, by branch and bound over patches.
    virtual Box3d exact_box(const Affine3d& local_to_other) const = 0;
    virtual SurfaceCounts counts() const = 0;
};

}  // namespace openfab::surface
