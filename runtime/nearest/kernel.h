// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Between the block engine (plain C++) and its inner loops, which are compiled once for each
// instruction set from kernel.inl. Everything that crosses is plain data, so that no library code
// is compiled for the wrong set.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/hierarchy.h"

namespace openfab::nearest {

constexpr int kQuarters = 32;  ///< of all sub-blocks of a block

/// How a block is cut for its pitch: 8 sub-blocks of 64 voxels, each 8 packets of 8, of which two
/// side by side are a quarter of the sub-block; all as near to cubes in millimetres as halving
/// gives. Lane l of packet p is voxel `voxel[p * 8 + l]` of the block; the packets of sub-block s
/// are 8s to 8s+7.
struct BlockShape {
    int32_t sub_size[3];
    int32_t sub_origin[8][3];
    int32_t packet_size[3];
    int32_t packet_origin[64][3];         ///< in the block
    alignas(32) float lane_offset[3][8];  ///< from the packet's origin, in voxels
    int16_t voxel[512];                   ///< number (y * 8 + x) * 8 + z
    /// From corner c of the block, bits 0 to 2 the upper end of x, y, z, to the farthest centre of
    /// sub-block s, mm: [c][s].
    float farthest[8][8];
    float half_diagonal;  ///< of the block, corner to corner, mm
    /// Bit k of a sub-block's number says on which side it is along this axis; so its middle is
    /// that of the block plus or minus this many voxels.
    int32_t sub_axis[3];
    float sub_half[3];
    float sub_reach[3];       ///< from its middle to its outer centres along x, y, z, voxels
    int32_t quarter_axis[2];  ///< the same for quarters of a sub-block
    float quarter_half[2];
    float quarter_reach[3];
};
BlockShape make_block_shape(const Vec3f& pitch_mm);

/// An array that only grows; what a thread's scratch is made of.
template <typename T>
struct Growing {
    T* data = nullptr;
    size_t size = 0;
    size_t capacity = 0;

    Growing() = default;
    Growing(const Growing&) = delete;
    Growing& operator=(const Growing&) = delete;
    ~Growing() { std::free(data); }
    __attribute__((always_inline)) inline void push(const T& value) {
        if (__builtin_expect(size == capacity, 0)) grow();
        data[size++] = value;
    }
    __attribute__((always_inline)) inline void reserve(size_t count) {
        while (__builtin_expect(capacity < count, 0))
            grow();
    }
    /// Defined in block_engine.cpp for the types below alone: it must not be compiled with the
    /// kernel's flags.
    void grow();
};

struct Entry {
    const TreeView* tree;
    uint32_t node;
};
/// What wins where a feature does: barycentrics bary1 + bary1_x x and bary2 + bary2_y y, where x
/// and y are a point's distances inwards of the face's edges 2 and 0, or its place along the edge.
struct FeatureAnswer {
    float bary1, bary1_x, bary2, bary2_y;
    int32_t patch, triangle;
    int32_t order;  ///< in the triangle: face, edges, vertices
};
/// Faces, edges or vertices.
constexpr int kFeatureKinds = 3;
/// Features by kind.
struct KindLists {
    Growing<uint32_t> places[kFeatureKinds];
};
/// As many features of a leaf as a vector has lanes: the places in their tree of what would be in
/// lane 0, of each kind.
struct LeafLanes {
    const TreeView* tree;
    uint32_t first[kFeatureKinds];
};
/// The features that are left for a block, by place. Places count leaf by leaf, those of one in
/// the order of its half-spaces (nearest/leaf_features.h); what is not left has an empty place.
struct BlockFeatures {
    Growing<LeafLanes> lanes;                ///< of as many places as a vector has lanes
    Growing<const float*> rows;              ///< the features, as floats
    Growing<const TriangleDetail*> details;  ///< of their owners
    Growing<FeatureAnswer> answers;
    Growing<float> margins;  ///< of faces
    Growing<uint32_t> left;  ///< places that are not empty, with their kinds
    /// For each quarter of a sub-block, places and kinds of what may be nearest to its voxels:
    /// near[quarter * near_stride ..][near_count[quarter]].
    Growing<uint32_t> near;
    size_t near_stride = 0;
    uint32_t near_count[kQuarters];
};

struct alignas(64) Lanes {
    float v[16];
};

/// Boxes of patches whose ids follow each other, where they are known (nearest/patch_boxes.h).
struct BoxPage {
    static constexpr size_t kSize = 256;
    static constexpr uint8_t kUnknown = 0, kBeingWritten = 1, kKnown = 2;
    Node box[kSize];
    uint8_t state[kSize] = {};
};

/// Where trees of displaced patches and of chunks come from: called from the kernel when a box
/// survives.
struct PatchSource {
    const TreeView* (*fetch)(void* context, int32_t id) = nullptr;
    void* context = nullptr;
    const BoxPage* const* pages = nullptr;  ///< by patch id; null pages where none is known
    int32_t first_chunk = 0;                ///< ids from here on are chunks of whole triangles
};

struct KernelInput {
    TreeView root;
    const float* frame = nullptr;  ///< OPENFAB_FRAME_COUNT values
    const BlockShape* shape = nullptr;
    float largest_coordinate = 0;
    /// Most of the surface is diced: half of a patch's leaves lie at its border, where normal cones
    /// are not known, so blocks near it are searched by walks.
    bool walks = false;
    uint64_t engine = 0;  ///< serial number, from 1
};

/// Surface points near the last block: they only start the next search well.
struct alignas(32) WarmStart {
    float point[3][8];
    int32_t count = 0;
};

/// What was found at a corner of blocks. Blocks share their corners, so those of the last ones are
/// kept.
struct LatticeEntry {
    uint64_t engine = 0;  ///< serial number; 0 where there is nothing
    int32_t voxel[3];     ///< the corner is this voxel's lowest
    float point[3];       ///< a surface point about as near as any
    float lower;          ///< no surface point is closer, mm
    float reach;          ///< how far was searched, mm; infinite where a point was found
};
constexpr size_t kLatticeEntries = 8192;

/// The 8 corners of a block, bits 0 to 2 the upper end of x, y, z.
struct BlockCorners {
    alignas(32) float point[3][8];  ///< a surface point near each
    float lower[8];                 ///< no surface point is closer to it, mm
    uint32_t found;                 ///< bit c: there is one within reach
};

/// A leaf and the space that its normal cones fill: what is off its box along the box's last axis
/// by w is off it across that axis by lean w + stray at most, mm.
struct NearLeaf {
    Entry entry;
    float lean, stray;
};
/// The leaves near a block.
struct NearLeaves {
    Growing<NearLeaf> leaves;
    /// For each quarter of a sub-block, places among them of what may be nearest to its voxels:
    /// places[quarter * stride ..][count[quarter]].
    Growing<uint32_t> places;
    size_t stride = 0;
    uint32_t count[kQuarters];
};

struct KernelScratch {
    Growing<Entry> stack;
    Growing<Entry> list;
    Growing<uint8_t> list_subs;  ///< block: bit s: matters in sub-block s
    /// Search: of the nodes that wait. Block: of the list to corners of sub-blocks.
    Growing<Lanes> list_distance2;
    Growing<float> list_least;  ///< cube: least distance to each node of the list, mm
    Growing<Entry> leaves;      ///< search: whose features were compared
    BlockFeatures features;
    KindLists by_kind;                ///< of those in hand
    LatticeEntry* lattice = nullptr;  ///< kLatticeEntries of them
    NearLeaves near;
    WarmStart warm;
    WarmStart warm_points;  ///< of points, which are elsewhere than blocks
    PatchSource patches;
    QueryCounts* counts = nullptr;
};

struct KernelTable {
    void (*query)(const KernelInput& input, const BlockQuery& query, KernelScratch* scratch,
                  BlockAnswer* answer);
    void (*prepare)(const KernelInput& input, const Vec3i* blocks, size_t count,
                    KernelScratch* scratch);
    void (*points)(const KernelInput& input, const PointGroup* groups, size_t count, float radius,
                   KernelScratch* scratch, PointAnswer* answers);
    void (*bound_points)(const KernelInput& input, const PointGroup* groups, const PointGroup* near,
                         size_t count, float off_mm, KernelScratch* scratch, PointBounds* bounds);
    void (*bound_blocks)(const KernelInput& input, const Vec3i* blocks, size_t count,
                         KernelScratch* scratch, BlockBounds* bounds);
    /// Leaves in scratch->list the nodes of the root hierarchy and of chunks, none below another,
    /// that may hold the nearest point of a voxel centre of the cube, and in scratch->list_least a
    /// lower bound of the distance to each. Patches are judged by their boxes; none is diced.
    /// Returns an upper bound of the distance for every voxel centre.
    float (*cube)(const KernelInput& input, const Vec3i& lowest, int32_t size,
                  KernelScratch* scratch);
};

namespace avx512 {
extern const KernelTable kKernels;
}
namespace avx2 {
extern const KernelTable kKernels;
}
namespace sse41 {
extern const KernelTable kKernels;
}

}  // namespace openfab::nearest
