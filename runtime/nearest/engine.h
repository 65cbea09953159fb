// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exact nearest-surface queries for blocks of 8 x 8 x 8 voxels, and for points anywhere. Two
// implementations stand behind this interface: the block-coherent engine and its brute-force twin.
//
// The answer for a point is the closest point over all query micropolygons, distances compared as
// the float squared distance that `closest_point` (nearest/triangle.h) evaluates; equal bits go to
// the lowest (patch, triangle). It does not depend on block order, threads, caches or on which
// other voxels are asked.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Voxel (z, x, y) of a block is number (y * 8 + x) * 8 + z in every array of 512.
constexpr int32_t kBlockVoxels = 512;

struct BlockQuery {
    Vec3i block;  ///< part-relative voxel index of its lowest corner
    const uint8_t* demand =
        nullptr;  ///< 64 bytes: bit z of byte y * 8 + x is set where a voxel asks
    float radius_mm = std::numeric_limits<float>::infinity();  ///< nothing farther is looked for
};

/// Where there is no surface within the radius: distance2 is +inf and patch -1.
struct BlockAnswer {
    alignas(32) float distance2[kBlockVoxels];  ///< mm²
    alignas(32) int32_t patch[kBlockVoxels];
    alignas(32) int32_t triangle[kBlockVoxels];  ///< in the patch's MicroMesh
    alignas(32) float bary1[kBlockVoxels];       ///< weight of the triangle's corner 1
    alignas(32) float bary2[kBlockVoxels];       ///< and of corner 2
};

/// A coordinate of this size or more is as good as infinite: squared distances stay in float.
constexpr float kFarthestPoint = 0x1p60f;

/// Eight points anywhere, part-local mm; lane l asks where bit l of `mask` is set.
struct alignas(32) PointGroup {
    float p[3][8] = {};
    uint32_t mask = 0xff;
};

/// Lanes that did not ask, whose point has a coordinate that is NaN or beyond kFarthestPoint, or
/// that have no surface within the radius: distance2 is +inf, patch -1 and the rest 0.
struct alignas(32) PointAnswer {
    float distance2[8];  ///< mm²
    int32_t patch[8];
    int32_t triangle[8];
    float bary1[8];
    float bary2[8];
};

/// How far the nearest surface is from each point, in part-local mm. Where there is none, both
/// distances are infinite.
struct alignas(32) PointBounds {
    float low[8];       ///< no surface point is closer
    float high[8];      ///< one is no farther
    float point[3][8];  ///< this one; NaN where only distances are known
};

/// How an engine cuts blocks for their bounds: into pieces of `size` voxels a side, by the lowest
/// voxel of each in the block.
struct BlockPieces {
    Vec3i size;
    std::array<Vec3i, 32> lowest;
};

/// No voxel centre of a piece is closer to the surface than its `low`, none farther than its
/// `high`, mm. Where there is no surface, both are infinite.
struct alignas(64) BlockBounds {
    float low[32];
    float high[32];
};

/// One way in which the nearest point of a voxel in a cube may come out: it lies on a patch of this
/// kind, no closer than `distance_lo`. Patches are of one kind where their flat (int) @nearest
/// components agree, so that a front and a back stay apart, each with its own distance: together,
/// "on the front" and "near" would both be possible almost anywhere.
struct NearestCase {
    float distance_lo = 0;                  ///< mm, unsigned
    std::vector<float> float_lo, float_hi;  ///< ranges of the float @nearest components
    std::vector<int32_t> int_lo, int_hi;
};

/// Conservative knowledge about a cube of voxels, for volume_bounds: every voxel falls under one of
/// the cases.
struct BoxBounds {
    /// More kinds than these share the last case.
    static constexpr int32_t kMostCases = 4;

    float distance_hi =
        0;  ///< unsigned distance of any voxel centre to the surface, mm; one for all cases
    int32_t count = 0;  ///< of cases; 0 where there is no surface at all
    std::array<NearestCase, kMostCases> cases;

    /// Empties the list; memory is kept.
    void clear() { count = 0; }
    /// Adds what one patch or group of patches may give.
    void add(float distance_lo, std::span<const float> float_lo, std::span<const float> float_hi,
             std::span<const int32_t> int_lo, std::span<const int32_t> int_hi);
};

/// Counters, added up over threads at the end.
struct QueryCounts {
    int64_t asked = 0, skipped = 0, triangle_tests = 0, node_tests = 0;

    void add(const QueryCounts& c) {
        asked += c.asked;
        skipped += c.skipped;
        triangle_tests += c.triangle_tests;
        node_tests += c.node_tests;
    }
};

class Engine {
  public:
    virtual ~Engine() = default;
    /// Scratch memory for one thread; holds the warm start, which never changes an answer.
    class Scratch {
      public:
        virtual ~Scratch() = default;
        QueryCounts counts;
    };
    virtual std::unique_ptr<Scratch> make_scratch() const = 0;
    /// Finds for blocks what their queries without a radius would each search, which is cheaper for
    /// many that are side by side. It changes no answer.
    virtual void prepare(std::span<const Vec3i> blocks, Scratch* scratch) const;
    virtual void query(const BlockQuery& query, Scratch* scratch, BlockAnswer* answer) const = 0;
    /// The same answers at any points: one PointAnswer for each group. Points that are close to the
    /// ones asked before, in the group and from group to group, cost less.
    virtual void query_points(std::span<const PointGroup> groups, float radius_mm, Scratch* scratch,
                              PointAnswer* answers) const = 0;
    /// How far points are from the surface, to about `off_mm`: a surface point that is farther than
    /// the nearest will do, which costs less to find. What is asked before decides how close bounds
    /// are, and so do points of the surface `near` each, one group of them for each group or none
    /// at all; infinite where none is known. Points must be finite; all eight are bounded. An
    /// engine without a way of its own queries them.
    virtual void bound_points(std::span<const PointGroup> groups, std::span<const PointGroup> near,
                              float off_mm, Scratch* scratch, PointBounds* bounds) const;
    /// Into which `bound_blocks` cuts; the same for all blocks.
    virtual const BlockPieces& pieces() const;
    /// Bounds of the distances in blocks, for what `prepare` finds and little more. An engine
    /// without a way of its own queries them.
    virtual void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                              BlockBounds* bounds) const;
    /// `size` is 8, 16, 32 or 64 voxels a side; `lowest` the part-relative index of the lowest
    /// voxel.
    virtual void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                        BoxBounds* out) const = 0;
};

enum class InstructionSet { kSse41, kAvx2, kAvx512 };

/// Keeps the small trees of displaced patches. One may serve many surfaces, of which not all are
/// near what is printed just now.
class PatchCache;
std::shared_ptr<PatchCache> make_patch_cache(size_t budget_bytes);
/// What a scratch keeps of displaced patches from block to block, beside the cache's budget.
constexpr size_t kHeldPatchBytes = 2u << 20;
/// What a thread holds of them at once, unless told: a block that needs more is searched in parts.
/// One near a surface needs 10 MB or less.
constexpr size_t kMostPinnedBytes = 32u << 20;
/// While one thread alone uses it.
void set_budget(PatchCache* cache, size_t bytes);
void set_most_pinned(PatchCache* cache, size_t bytes);

struct BlockEngineOptions {
    std::shared_ptr<PatchCache> cache;  ///< null: one of its own
    size_t cache_bytes = 128u << 20;    ///< budget of that; one block's trees are always held
    /// The widest instruction set that may be used where it exists; the bits are the same.
    InstructionSet widest = InstructionSet::kAvx512;
};

/// What the block engines of one surface share wherever it stands: its trees, and the cache of
/// those of displaced patches. Scratch made by one of them serves all.
class BlockIndex;
/// The surface must outlive it. Set-up reads every identity patch once. `along` is
/// surface::along_curve of its patches, which is found here where it is not given.
std::shared_ptr<const BlockIndex> make_block_index(const surface::Surface& surface,
                                                   const BlockEngineOptions& options = {},
                                                   std::span<const uint64_t> along = {});
/// What trees over whole triangles, which are made when a query first comes near, will hold once
/// all are there, less what they hold now: rather more than that. `vertices` are the base mesh's.
size_t bytes_to_come(const BlockIndex& index, size_t vertices);

/// `frame` as of scene::make_frame. Takes about 3 kB.
std::unique_ptr<Engine> make_block_engine(std::shared_ptr<const BlockIndex> index,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame);
/// With an index of its own; the surface must outlive the engine.
std::unique_ptr<Engine> make_block_engine(const surface::Surface& surface,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                                          const BlockEngineOptions& options = {});
/// Plain loops over every micropolygon: the reference of tests, far too slow for anything else.
std::unique_ptr<Engine> make_brute_force_engine(
    const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame);

}  // namespace openfab::nearest
