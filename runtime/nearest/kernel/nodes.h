// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tests of nodes against boxes of voxel centers, one node per lane.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/block_frame.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"
#include "simd/shuffles.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// The boxes of several nodes, one per lane, in the layout of Node.
template <typename V>
struct NodeBoxes {
    V axis[3][3], center[3], half[3], link;
};
static_assert(offsetof(Node, center) == 9 * sizeof(float) && sizeof(Node) == 16 * sizeof(float));

/// Loads the boxes of `count` nodes, at most one per lane; further lanes repeat the first.
template <typename V>
OPENFAB_INLINE NodeBoxes<V> load_boxes(const NodeRef* entries, size_t count) {
    const float* nodes[V::kLanes];
    for (size_t l = 0; l < V::kLanes; ++l) {
        const NodeRef& e = entries[l < count ? l : 0];
        nodes[l] = reinterpret_cast<const float*>(e.tree->nodes + e.node);
    }
    NodeBoxes<V> boxes;
    transpose(nodes, 0, &boxes.axis[0][0]);
    return boxes;
}

/// Computes one coordinate of the 8 corners of a box; bits 0 to 2 of the index: upper end of axes.
template <typename V>
OPENFAB_INLINE void corner_coordinates(V center, const V* half, V* at) {
    at[0] = center;
    for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < 1 << a; ++i) {
            at[i + (1 << a)] = at[i] + half[a];
            at[i] = at[i] - half[a];
        }
    }
}

/// Adds the square of how far `at` is outside of the box along its axis k.
template <typename V>
OPENFAB_INLINE void add_outside2(const NodeBoxes<V>& boxes, int k, V at, V* distance2) {
    const V d = max(absolute(at) - boxes.half[k], V(0.0f));
    *distance2 = about_mul_add(d, d, *distance2);
}

/// A box of voxel centers in the axes of nodes: its center relative to theirs, and its half axes.
template <typename V>
struct ProjectedBox {
    V center[3], half[3][3];
};
template <typename V>
OPENFAB_INLINE ProjectedBox<V> project_box(const NodeBoxes<V>& boxes, const VoxelBox& box) {
    ProjectedBox<V> projected;
    for (int k = 0; k < 3; ++k) {
        const V* axis = boxes.axis[k];
        projected.center[k] = about_dot(axis, box.center, V(0.0f) - boxes.center[k]);
        for (int a = 0; a < 3; ++a)
            projected.half[k][a] = about_dot(axis, box.half[a], V(0.0f));
    }
    return projected;
}

/// Computes the squared distances of the node boxes to the corners of a box of voxel centers.
template <typename V>
OPENFAB_INLINE void corner_distances2(const NodeBoxes<V>& boxes, const ProjectedBox<V>& box,
                                      V* distance2) {
    for (int c = 0; c < 8; ++c)
        distance2[c] = V(0.0f);
    for (int k = 0; k < 3; ++k) {
        V at[8];
        corner_coordinates(box.center[k], box.half[k], at);
        for (int c = 0; c < 8; ++c)
            add_outside2(boxes, k, at[c], distance2 + c);
    }
}

/// The normal cones of several nodes, one per lane (tree/cones.h).
template <typename V>
struct NodeCones {
    V sine, offset, offset_by_reach, longest_edge;
};
template <typename V>
OPENFAB_INLINE NodeCones<V> load_cones(const NodeRef* entries, size_t count) {
    alignas(64) float of[4][V::kLanes];
    for (size_t l = 0; l < V::kLanes; ++l) {
        const NodeRef& e = entries[l < count ? l : 0];
        const NodeCone& cone = e.tree->cones[e.node];
        of[0][l] = cone.sine;
        of[1][l] = cone.offset;
        of[2][l] = cone.offset_by_reach;
        of[3][l] = e.tree->longest_edge;
    }
    return {V::load(of[0]), V::load(of[1]), V::load(of[2]), V::load(of[3])};
}

/// Returns how far rounding may put a voxel outside the normal cone of its nearest point: twice
/// what NodeCone says, as the error along a cone is as large as the one across.
template <typename V>
OPENFAB_INLINE V cone_offset(const NodeCones<V>& cones, const BlockFrame& frame) {
    const V rounded = (cones.longest_edge + V(frame.reach)) * V(kRounded);
    const V x = min(V(frame.excess), rounded);
    return about_mul_add(x + x, max(cones.offset, x * cones.offset_by_reach), V(frame.slack));
}

/// Returns the lanes that are out of the block's reach, or whose normal cones miss the box.
template <typename V>
OPENFAB_INLINE uint32_t outside_cone_lanes(const NodeBoxes<V>& boxes, const ProjectedBox<V>& box,
                                           const NodeCones<V>& cones, const BlockFrame& frame) {
    V d[3], sum = V(0.0f);
    for (int k = 0; k < 3; ++k) {
        const V extent = (absolute(box.half[k][0]) + absolute(box.half[k][1])) +
                         (absolute(box.half[k][2]) + boxes.half[k]);
        d[k] = max(absolute(box.center[k]) - extent, V(0.0f));
        sum = about_mul_add(d[k], d[k], sum);
    }
    const V across = about_mul_add(V(frame.reach), cones.sine, cone_offset(cones, frame));
    const float far = frame.reach + frame.slack;
    return bits((across < max(d[0], d[1])) | (V(far * far) < sum));
}

/// Returns the lanes whose boxes are farther than `reach2`, squared, from the whole box of voxel
/// centers: their separation along the nodes' axes bounds it.
template <typename V>
OPENFAB_INLINE uint32_t beyond_reach_lanes(const NodeBoxes<V>& boxes, const ProjectedBox<V>& box,
                                           float reach2) {
    V sum = V(0.0f);
    for (int k = 0; k < 3; ++k) {
        const V extent = (absolute(box.half[k][0]) + absolute(box.half[k][1])) +
                         (absolute(box.half[k][2]) + boxes.half[k]);
        const V d = max(absolute(box.center[k]) - extent, V(0.0f));
        sum = about_mul_add(d, d, sum);
    }
    return bits(V(reach2) < sum);
}

/// Returns the lanes whose distances to the corners exceed some bound.
template <typename V>
OPENFAB_INLINE uint32_t prunable_lanes(const V* distance2, const PruneBounds& d) {
    constexpr uint32_t kAll = (1u << V::kLanes) - 1;
    uint32_t lanes = 0;
    for (int i = 0; i < d.count && lanes != kAll; ++i) {
        auto beyond = V(d.bound[i][0]) < distance2[0];
        for (int c = 1; c < 8; ++c)
            beyond = beyond & (V(d.bound[i][c]) < distance2[c]);
        lanes |= bits(beyond);
    }
    return lanes;
}

/// Pushes the children of `e`, or the root of the tree it stands for if `expand`; small nodes and
/// leaves go to the frontier.
OPENFAB_INLINE void expand_node(NodeRef e, bool small, bool expand, const VoxelBox& box,
                                PruneBounds* bounds, KernelScratch* scratch) {
    const Node& node = e.tree->nodes[e.node];
    if (node.is_leaf() && node.count() == 0 && expand) {
        const Node* cached = cached_box(scratch->patches, node);
        if (cached != nullptr && can_prune(node_distance2(*cached, box.corner), bounds)) return;
        const TreeView* patch =
            scratch->patches.fetch(scratch->patches.context, static_cast<int32_t>(node.first()));
        if (patch->nodes != nullptr) scratch->stack.push({patch, 0});
    } else if (node.is_leaf() || small) {
        scratch->frontier.push(e);
        __builtin_prefetch(e.tree->leaves + e.node);
    } else {
        const size_t size = scratch->stack.size;
        scratch->stack.reserve(size + kMaxChildren);
        for (uint32_t i = 0; i < kMaxChildren; ++i) {
            __builtin_prefetch(e.tree->nodes + node.child() + i);
            scratch->stack.data[size + i] = {e.tree, node.child() + i};
        }
        scratch->stack.size = size + node.children();
    }
}

/// Appends to the frontier the surviving nodes below those on the stack: leaves, and nodes no
/// larger than `stop2` (squared half diagonal). Nodes survive if they cannot be pruned; or, if
/// `block` is given, if they are in its reach and a voxel of it is in their normal cones: close to
/// the surface witnesses prune little. Patches are diced if `dice`; else they stay on the frontier
/// themselves, as do treelets no larger than `stop2`. Breadth first, so that there are always many
/// nodes to test while their children are prefetched.
__attribute__((noinline)) void collect_frontier(const VoxelBox& box, float stop2, bool dice,
                                                const BlockFrame* block, PruneBounds* bounds,
                                                KernelScratch* scratch) {
    using V = simd::WidestFloats;
    constexpr size_t kLanes = V::kLanes;
    for (size_t first = 0; first < scratch->stack.size;) {
        const size_t left = scratch->stack.size - first;
        const size_t count = left < kLanes ? left : kLanes;
        const NodeRef* entries = scratch->stack.data + first;
        const auto boxes = load_boxes<V>(entries, count);
        const auto projected = project_box(boxes, box);
        uint32_t kept = (1u << count) - 1;
        if (block != nullptr) {
            kept &= ~outside_cone_lanes(boxes, projected, load_cones<V>(entries, count), *block);
        } else {
            V distance2[8];
            corner_distances2(boxes, projected, distance2);
            kept &= ~prunable_lanes(distance2, *bounds);
            if (bounds->reach2 < kInfinity)
                kept &= ~beyond_reach_lanes(boxes, projected, bounds->reach2);
        }
        const V* half = boxes.half;
        const V size2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
        const uint32_t small = bits(size2 <= V(stop2));
        scratch->counts->node_tests += static_cast<int64_t>(count);
        for (; kept != 0; kept &= kept - 1) {
            const auto l = static_cast<size_t>(__builtin_ctz(kept));
            const NodeRef e = scratch->stack.data[first + l];
            const bool is_small = (small >> l & 1u) != 0;
            const Node& node = e.tree->nodes[e.node];
            const bool expand = dice || (!is_small && is_treelet(scratch->patches, node));
            expand_node(e, is_small, expand, box, bounds, scratch);
        }
        first += count;
    }
    scratch->stack.size = 0;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
