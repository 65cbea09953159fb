// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exact nearest-surface queries for blocks of 8 x 8 x 8 voxels, and for points anywhere. The
// block-coherent engine implements this interface, and so does its brute-force twin for tests
// (tests/support/reference/brute_force.h).
//
// The answer for a point is the closest point over all query micropolygons, distances compared as
// the float squared distance that `closest_point` (nearest/triangle.h) evaluates; equal bits go to
// the lowest (patch, triangle). It does not depend on block order, threads, caches or on which
// other voxels are active.

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/infinity.h"
#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"
#include "simd/isa.h"

namespace openfab::nearest {

/// Voxel (z, x, y) of a block is number (y * 8 + x) * 8 + z in every array of 512.
constexpr int32_t kBlockVoxels = 512;

struct BlockQuery {
    Vec3i block;  ///< part-relative voxel index of its lowest corner
    /// 64 bytes: bit z of byte y * 8 + x is set where a voxel is active; null: all are.
    const uint8_t* active = nullptr;
    float radius_mm = kInfinity;  ///< surface beyond it is ignored
};

/// Nearest surface points: how far, on which item of the solid (a patch, a beam, a body), and by what attributes are
/// interpolated there, which only the solid reads. Without surface within the radius distance2 is +inf and item is
/// -1.
template <int32_t kCount>
struct Answer {
    struct InPatch {
        alignas(32) int32_t triangle[kCount];  ///< of the patch's MicroMesh
        alignas(32) float bary1[kCount];       ///< weight of the triangle's corner 1
        alignas(32) float bary2[kCount];       ///< and of corner 2
    };
    alignas(32) float distance2[kCount];  ///< mm²
    alignas(32) int32_t item[kCount];
    union {
        InPatch in_patch;
        float point[3][kCount];  ///< of beams and bodies: part-local mm
    };

    void set_point(size_t lane, const Vec3f& p) {
        for (size_t a = 0; a < 3; ++a)
            point[a][lane] = p[static_cast<int>(a)];
    }
    Vec3f point_at(size_t lane) const { return {point[0][lane], point[1][lane], point[2][lane]}; }
};

/// Those of the voxels of a block.
using BlockAnswer = Answer<kBlockVoxels>;

/// Limit of a coordinate's magnitude, mm; larger ones count as infinite, so that squared distances
/// fit a float.
constexpr float kMaxCoordinate = 0x1p60f;

/// Eight arbitrary points, part-local mm; lane l is active where bit l of `mask` is set.
struct alignas(32) PointPacket {
    float p[3][8] = {};
    uint32_t mask = 0xff;

    Vec3f point(size_t lane) const { return {p[0][lane], p[1][lane], p[2][lane]}; }
    /// Returns whether a lane is active, with coordinates that have an answer.
    bool asks(size_t lane) const {
        bool fine = (mask >> lane & 1) != 0;
        for (const auto& axis : p)
            fine = fine && std::fabs(axis[lane]) <= kMaxCoordinate;
        return fine;
    }
};

/// The nearest surface point of each lane; none, and the rest 0, in lanes that are inactive or have a coordinate that
/// is NaN or beyond kMaxCoordinate.
using PointAnswer = Answer<8>;

/// Bounds of the distance from each point to the surface, part-local mm; both are infinite if there
/// is no surface.
struct alignas(32) PointBounds {
    float low[8];       ///< no surface point is closer
    float high[8];      ///< some surface point is no farther
    float point[3][8];  ///< that surface point; NaN if only the distances are known
};

/// The pieces into which an engine cuts a block to bound it: `size` voxels along each axis, and the
/// lowest voxel of each piece, relative to the block.
struct BlockPieces {
    Vec3i size;
    std::array<Vec3i, 32> lowest;
};

/// Bounds of the distances of a block's pieces, mm: every voxel center of a piece is at least `low`
/// and at most `high` from the surface. Both are infinite if there is no surface.
struct alignas(64) BlockBounds {
    float low[32];
    float high[32];
};

/// One possible outcome of the query of a voxel in a cube: the nearest point lies on a patch of
/// this kind, no closer than `distance_lo`. Patches are of one kind where their flat (int) @nearest
/// components agree, so that a front and a back stay apart, each with its own distance: together,
/// "on the front" and "near" would both be possible almost anywhere.
struct NearestCase {
    float distance_lo = 0;                  ///< mm, unsigned
    std::vector<float> float_lo, float_hi;  ///< ranges of the float @nearest components
    std::vector<int32_t> int_lo, int_hi;
};

/// Conservative bounds over a cube of voxels, for volume_bounds: every voxel falls under one of the
/// cases.
struct BoxBounds {
    /// Maximum number of cases; further kinds share the last one.
    static constexpr int32_t kMaxCases = 4;

    float distance_hi = 0;  ///< upper bound of the unsigned distance of any voxel center, mm
    int32_t count = 0;      ///< number of cases; 0 if there is no surface
    std::array<NearestCase, kMaxCases> cases;

    /// Removes all cases; keeps their memory.
    void clear() { count = 0; }
    /// Adds the case of one patch or node of patches.
    void add(float distance_lo, std::span<const float> float_lo, std::span<const float> float_hi,
             std::span<const int32_t> int_lo, std::span<const int32_t> int_hi);
};

/// Query statistics; each thread has its own, summed at the end.
struct QueryCounts {
    int64_t queried = 0, skipped = 0, triangle_tests = 0, node_tests = 0;

    void add(const QueryCounts& c) {
        queried += c.queried;
        skipped += c.skipped;
        triangle_tests += c.triangle_tests;
        node_tests += c.node_tests;
    }
};

/// Answers nearest-surface queries of one surface in one frame. Threads share it, each with a
/// Scratch of its own.
class Engine {
  public:
    virtual ~Engine() = default;
    /// Scratch memory of one thread. It holds the warm start, which never changes an answer.
    class Scratch {
      public:
        virtual ~Scratch() = default;
        QueryCounts counts;
        /// Once set, `query_points` ends early, and its answers are of no use; null: never.
        const std::atomic<bool>* stop = nullptr;
        bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
    };
    /// Makes the scratch memory of one thread.
    virtual std::unique_ptr<Scratch> make_scratch() const = 0;
    /// Searches the shared corners of many blocks at once, ahead of their queries without a radius;
    /// cheaper than block by block where blocks are adjacent. Does not change any answer.
    virtual void prepare(std::span<const Vec3i> blocks, Scratch* scratch) const;
    /// Finds the nearest surface point of each active voxel of a block.
    virtual void query(const BlockQuery& query, Scratch* scratch, BlockAnswer* answer) const = 0;
    /// Finds the nearest surface point of arbitrary points: one PointAnswer per packet. Points
    /// close to those before them, within a packet and from packet to packet, cost less.
    virtual void query_points(std::span<const PointPacket> packets, float radius_mm,
                              Scratch* scratch, PointAnswer* answers) const = 0;
    /// Bounds the distances of points to the surface, to about `tolerance_mm`: cheaper than a
    /// query, as a surface point slightly farther than the nearest is enough. `hints` are known
    /// surface points, one packet per packet or none at all, infinite in lanes without one. How
    /// tight bounds are depends on the hints and on earlier calls. Points must be finite; all eight
    /// lanes are bounded. The default queries the points.
    virtual void bound_points(std::span<const PointPacket> packets,
                              std::span<const PointPacket> hints, float tolerance_mm,
                              Scratch* scratch, PointBounds* bounds) const;
    /// Returns the pieces that `bound_blocks` bounds, the same for all blocks.
    virtual const BlockPieces& pieces() const;
    /// Bounds the distances of blocks piece by piece, for little more than the cost of `prepare`.
    /// The default queries the blocks.
    virtual void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                              BlockBounds* bounds) const;
    /// Bounds the distances of whole blocks, maybe no tighter than `bound_blocks` does; the default is what that says.
    virtual void bound_whole_blocks(std::span<const Vec3i> blocks, Scratch* scratch, float* low,
                                    float* high) const;
    /// Bounds the answers over a cube of `size` (8, 16, 32 or 64) voxels a side; `lowest` is the
    /// part-relative index of its lowest voxel.
    virtual void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                        BoxBounds* out) const = 0;
};

/// Caches the small trees of displaced patches under one byte budget, for any number of surfaces.
class PatchCache;
/// Makes an empty cache of patch trees.
std::shared_ptr<PatchCache> make_patch_cache(size_t budget_bytes);
/// Bytes of patch trees a scratch keeps pinned from call to call, on top of the cache's budget.
constexpr size_t kHeldPatchBytes = 2u << 20;
/// Default limit of the bytes of patch trees one thread pins at once; a block that needs more is
/// searched in parts. A block near the surface needs 10 MB or less.
constexpr size_t kMaxPinnedBytes = 32u << 20;
/// Changes the byte budget; call while no other thread uses the cache.
void set_budget(PatchCache* cache, size_t bytes);
/// Returns the bytes of all trees that were built so far, evicted or not.
int64_t built_bytes(const PatchCache& cache);
/// Changes the limit of pinned bytes per thread; call while no other thread uses the cache.
void set_max_pinned(PatchCache* cache, size_t bytes);

/// Options of a block index and its engines.
struct BlockEngineOptions {
    std::shared_ptr<PatchCache> cache;  ///< null: the index makes its own
    size_t cache_bytes = 128u << 20;    ///< budget of that one; trees of one block always fit
    /// The widest instruction set to use where the processor has it; results have the same bits.
    simd::Isa widest = simd::Isa::kAvx512;
};

/// The trees over one surface and the cache of its patch trees, shared by the block engines of all
/// placements of the surface. Scratch made by one of these engines serves all of them.
class BlockIndex;
/// Builds the index; reads every identity patch once. The surface must outlive it. `morton` is
/// surface::morton_order of its patches, computed here if empty.
std::shared_ptr<const BlockIndex> make_block_index(const surface::Surface& surface,
                                                   const BlockEngineOptions& options = {},
                                                   std::span<const uint64_t> morton = {});
/// Estimates the bytes that lazily built trees will still take once all exist; errs on the high
/// side. `vertices` is the number of vertices of the base mesh.
size_t estimated_bytes(const BlockIndex& index, size_t vertices);

/// Makes an engine that shares `index`; it takes about 3 kB. `frame` is from part::make_frame.
std::unique_ptr<Engine> make_block_engine(std::shared_ptr<const BlockIndex> index,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame);
/// Makes an engine with an index of its own; the surface must outlive it.
std::unique_ptr<Engine> make_block_engine(const surface::Surface& surface,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                                          const BlockEngineOptions& options = {});

}  // namespace openfab::nearest
