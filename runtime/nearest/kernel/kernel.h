// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interface between the block engine (plain C++) and its inner loops, which are compiled from
// kernel_table.h once per instruction set. Only plain data crosses it, so that no library code is
// compiled for the wrong set.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/tree/hierarchy.h"

namespace openfab::nearest {

constexpr int kQuarters = 32;  ///< quarters of a block, 4 per sub-block

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
    /// [c][s]: distance from corner c of the block (bits 0 to 2: upper end of x, y, z) to the
    /// farthest voxel center of sub-block s, mm.
    float farthest[8][8];
    float half_diagonal;  ///< of the block, corner to corner, mm
    /// Axis of bit k of a sub-block's number, and by how many voxels the bit moves the sub-block's
    /// center from the block's, up if it is set, else down.
    int32_t sub_axis[3];
    float sub_half[3];
    float sub_reach[3];       ///< from its center to its outer voxel centers, x, y, z, voxels
    int32_t quarter_axis[2];  ///< the same for quarters of a sub-block
    float quarter_half[2];
    float quarter_reach[3];
};
/// Cuts a block of this pitch.
BlockShape make_block_shape(const Vec3f& pitch_mm);

/// An array that never shrinks; a thread's scratch consists of these.
template <typename T>
struct ScratchVector {
    T* data = nullptr;
    size_t size = 0;
    size_t capacity = 0;

    ScratchVector() = default;
    ScratchVector(const ScratchVector&) = delete;
    ScratchVector& operator=(const ScratchVector&) = delete;
    ~ScratchVector() { std::free(data); }
    __attribute__((always_inline)) inline void push(const T& value) {
        if (__builtin_expect(size == capacity, 0)) grow();
        data[size++] = value;
    }
    __attribute__((always_inline)) inline void reserve(size_t count) {
        while (__builtin_expect(capacity < count, 0))
            grow();
    }
    /// Doubles the capacity. Defined in block_engine.cpp, for the types instantiated there only: it
    /// must not be compiled with the kernel's flags.
    void grow();
};

/// A node of a tree.
struct NodeRef {
    const TreeView* tree;
    uint32_t node;
};
/// The answer where a feature wins: barycentrics bary1 + bary1_x x and bary2 + bary2_y y, with x
/// and y a point's distances inwards of the face's edges 2 and 0, or its parameter on the edge.
struct FeatureAnswer {
    float bary1, bary1_x, bary2, bary2_y;
    int32_t patch, triangle;
    int32_t order;  ///< rank in the triangle: face, edges, vertices
};
/// Faces, edges or vertices.
constexpr int kFeatureKinds = 3;
/// Indices of features, by kind.
struct FeaturesByKind {
    ScratchVector<uint32_t> indices[kFeatureKinds];
};
/// A vector of a leaf's features: for each kind the index in the tree that lane 0 would have.
struct LeafLanes {
    const TreeView* tree;
    uint32_t first[kFeatureKinds];
};
/// The candidate features of a block, by index. Indices count leaf by leaf, within a leaf in the
/// order of its half-spaces (tree/leaf_features.h); entries of pruned features are unused.
struct BlockFeatures {
    ScratchVector<LeafLanes> lanes;                ///< one per vector of indices
    ScratchVector<const float*> values;            ///< the features, as floats
    ScratchVector<const TriangleDetail*> details;  ///< their owners
    ScratchVector<FeatureAnswer> answers;
    ScratchVector<float> margins;        ///< of faces
    ScratchVector<uint32_t> candidates;  ///< indices in use, tagged with their kinds
    /// Tagged indices of the features that may be nearest to a voxel of a quarter:
    /// in_quarter[quarter * quarter_stride ..][quarter_count[quarter]].
    ScratchVector<uint32_t> in_quarter;
    size_t quarter_stride = 0;
    uint32_t quarter_count[kQuarters];
};

/// Storage of one vector.
struct alignas(64) Lanes {
    float v[16];
};

/// Boxes of patches with consecutive ids, each with its state (engine/patch_boxes.h).
struct BoxPage {
    static constexpr size_t kSize = 256;
    static constexpr uint8_t kEmpty = 0, kBeingWritten = 1, kReady = 2;
    Node box[kSize];
    uint8_t state[kSize] = {};
};

/// Callback that provides trees of displaced patches and of treelets; called when a box survives
/// pruning.
struct PatchSource {
    const TreeView* (*fetch)(void* context, int32_t id) = nullptr;
    void* context = nullptr;
    const BoxPage* const* pages = nullptr;  ///< by patch id; pages without a box are null
    int32_t first_treelet = 0;              ///< ids from here on are no patches
};

/// Arguments that one engine passes to every call of a kernel.
struct KernelInput {
    TreeView root;
    const float* frame = nullptr;  ///< OPENFAB_FRAME_COUNT values
    const BlockShape* shape = nullptr;
    float largest_coordinate = 0;
    /// Search blocks near the surface by traversal, packet by packet. Set if most of the surface is
    /// diced: half of a patch's leaves lie at its border, where normal cones are not known.
    bool traverse_per_packet = false;
    uint64_t engine = 0;  ///< serial number of the engine, from 1
};

/// Surface points near the previous block or packet; they only speed up the next search.
struct alignas(32) WarmStart {
    float point[3][8];
    int32_t count = 0;
};

/// The search result of one block corner. Blocks share corners, so recent ones are cached.
struct CornerEntry {
    uint64_t engine = 0;  ///< serial number; 0: an empty entry
    int32_t voxel[3];     ///< the corner is this voxel's lowest
    float point[3];       ///< a surface point, nearly the nearest
    float lower;          ///< no surface point is closer, mm
    float reach;          ///< search radius, mm; infinite if a point was found
};
constexpr size_t kCornerEntries = 8192;

/// The 8 corners of a block; bits 0 to 2 of the index: upper end of x, y, z.
struct BlockCorners {
    alignas(32) float point[3][8];  ///< a surface point near each
    float lower[8];                 ///< no surface point is closer to it, mm
    uint32_t found;                 ///< bit c: a point was found for corner c
};

/// A leaf and the space its normal cones fill: a point at distance w from its box along the box's
/// last axis is at most slope w + offset from it across that axis, mm.
struct NearLeaf {
    NodeRef entry;
    float slope, offset;
};
/// The candidate leaves of a block near the surface.
struct NearLeaves {
    ScratchVector<NearLeaf> leaves;
    /// Indices of the leaves that may be nearest to a voxel of a quarter:
    /// indices[quarter * stride ..][count[quarter]].
    ScratchVector<uint32_t> indices;
    size_t stride = 0;
    uint32_t count[kQuarters];
};

/// Scratch memory of one thread.
struct KernelScratch {
    ScratchVector<NodeRef> stack;
    ScratchVector<NodeRef> frontier;       ///< nodes that survived, none below another
    ScratchVector<uint8_t> frontier_subs;  ///< block: bit s: the node matters in sub-block s
    /// Search: distances of the nodes on the stack. Block: of the frontier to corners of
    /// sub-blocks.
    ScratchVector<Lanes> frontier_distance2;
    ScratchVector<float> frontier_least;  ///< cube: lower bound of the distance to each node, mm
    ScratchVector<NodeRef> leaves;        ///< search: leaves whose features were compared
    BlockFeatures features;
    FeaturesByKind by_kind;               ///< the features just partitioned
    CornerEntry* corner_cache = nullptr;  ///< kCornerEntries entries
    NearLeaves near;
    WarmStart warm;
    WarmStart warm_points;  ///< of points; those of blocks lie elsewhere
    PatchSource patches;
    QueryCounts* counts = nullptr;
};

/// The kernel's entry points, compiled for one instruction set.
struct KernelTable {
    void (*query)(const KernelInput& input, const BlockQuery& query, KernelScratch* scratch,
                  BlockAnswer* answer);
    void (*prepare)(const KernelInput& input, const Vec3i* blocks, size_t count,
                    KernelScratch* scratch);
    void (*query_points)(const KernelInput& input, const PointPacket* packets, size_t count,
                         float radius, KernelScratch* scratch, PointAnswer* answers);
    void (*bound_points)(const KernelInput& input, const PointPacket* packets,
                         const PointPacket* hints, size_t count, float tolerance_mm,
                         KernelScratch* scratch, PointBounds* bounds);
    void (*bound_blocks)(const KernelInput& input, const Vec3i* blocks, size_t count,
                         KernelScratch* scratch, BlockBounds* bounds);
    /// Puts into scratch->frontier the nodes of the root tree and of treelets that may hold the
    /// nearest point of a voxel center of the cube, none below another, and into
    /// scratch->frontier_least a lower bound of the distance to each. Patches count as their boxes;
    /// none is diced. Returns an upper bound of the distance of every voxel center.
    float (*bound_cube)(const KernelInput& input, const Vec3i& lowest, int32_t size,
                        KernelScratch* scratch);
};

namespace avx512 {
extern const KernelTable kKernels;
}
namespace avx2_fma {
extern const KernelTable kKernels;
}
namespace sse41 {
extern const KernelTable kKernels;
}

}  // namespace openfab::nearest
