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

/// How a block is cut for its pitch: 8 sub-blocks of 64 voxels, each 8 packets of 8, as near to
/// cubes in millimetres as halving gives. Lane l of packet p is voxel `voxel[p * 8 + l]` of the
/// block; the packets of sub-block s are 8s to 8s+7.
struct BlockShape {
    int32_t sub_size[3];
    int32_t sub_origin[8][3];
    int32_t packet_origin[64][3];         ///< in the block
    alignas(32) float lane_offset[3][8];  ///< from the packet's origin, in voxels
    int16_t voxel[512];                   ///< number (y * 8 + x) * 8 + z
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
struct TriangleRef {
    const TriangleFrame* frame;
    const TriangleDetail* detail;
};
struct alignas(32) Lanes {
    float v[8];
};

/// Where displaced patches come from: called from the kernel when a patch's box survives.
struct PatchSource {
    const TreeView* (*fetch)(void* context, int32_t patch) = nullptr;
    void* context = nullptr;
};

struct KernelInput {
    TreeView root;
    const float* frame = nullptr;  ///< OPENFAB_FRAME_COUNT values
    const BlockShape* shape = nullptr;
    float largest_coordinate = 0;
};

/// Surface points near the last block: they only start the next search well.
struct alignas(32) WarmStart {
    float point[3][8];
    int32_t count = 0;
};

struct KernelScratch {
    Growing<Entry> stack;
    Growing<Entry> list;
    Growing<Lanes> list_distance2;
    Growing<float> list_least;  ///< cube: least distance to each node of the list, mm
    Growing<TriangleRef> triangles;
    Growing<Lanes> bounds;  ///< of each triangle, for the packet at hand
    Growing<Lanes> framed;  ///< 4 a triangle: plane and edge line distances
    WarmStart warm;
    WarmStart warm_points;  ///< of points, which are elsewhere than blocks
    PatchSource patches;
    QueryCounts* counts = nullptr;
};

struct KernelTable {
    void (*query)(const KernelInput& input, const BlockQuery& query, KernelScratch* scratch,
                  BlockAnswer* answer);
    void (*points)(const KernelInput& input, const PointGroup* groups, size_t count, float radius,
                   KernelScratch* scratch, PointAnswer* answers);
    /// Leaves in scratch->list the nodes of the root hierarchy, none below another, that may hold
    /// the nearest point of a voxel centre of the cube, and in scratch->list_least a lower bound of
    /// the distance to each. Patches are judged by their boxes; none is diced. Returns an upper
    /// bound of the distance for every voxel centre.
    float (*cube)(const KernelInput& input, const Vec3i& lowest, int32_t size,
                  KernelScratch* scratch);
};

namespace avx2 {
extern const KernelTable kKernels;
}
namespace sse41 {
extern const KernelTable kKernels;
}

}  // namespace openfab::nearest
