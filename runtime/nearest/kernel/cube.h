// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds over whole cubes of voxels.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/nodes.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Returns the squared distance from each point to the farthest point of the node's box.
OPENFAB_INLINE Floats8 max_distance2(const Node& n, const Points& p) {
    Floats8 sum;
    for (int k = 0; k < 3; ++k) {
        const Floats8 u = dot3(Floats8(n.axis[k][0]), Floats8(n.axis[k][1]), Floats8(n.axis[k][2]),
                               p.x, p.y, p.z);
        const Floats8 d = absolute(u - Floats8(n.center[k])) + Floats8(n.half[k]);
        sum = k == 0 ? d * d : sum + d * d;
    }
    return sum;
}

/// Upper bounds of the squared distance at the corners, without dicing: exact for triangles; for
/// patches, the farthest point of their boxes.
struct CubeUpper {
    Floats8 distance2;
    const Node* node[8];  ///< the patch box it is from; null if it is from a triangle
};

inline void find_upper_bounds(const KernelInput& in, const Points& p, KernelScratch* scratch,
                              Witnesses* w, CubeUpper* upper) {
    scratch->stack.size = 0;
    scratch->stack.push({&in.root, 0});
    for (auto& node : upper->node)
        node = nullptr;
    while (scratch->stack.size != 0) {
        const NodeRef e = scratch->stack.data[--scratch->stack.size];
        const Node& node = e.tree->nodes[e.node];
        if (bits(node_distance2(node, p) < upper->distance2 - w->tolerance2) == 0) continue;
        if (!node.is_leaf()) {
            const Floats8 bar = upper->distance2 - w->tolerance2;
            Floats8 of_child[kMaxChildren];
            const uint32_t near = test_children(*e.tree, node, p, bar, of_child);
            const uint32_t child = node.child(), nearest = nearest_child(of_child);
            each_other_child(near, nearest, [&](uint32_t i) OPENFAB_INLINE_LAMBDA {
                scratch->stack.push({e.tree, child + i});
            });
            if ((near >> nearest & 1u) != 0) scratch->stack.push({e.tree, child + nearest});
            continue;
        }
        if (is_treelet(scratch->patches, node)) {
            const TreeView* treelet = scratch->patches.fetch(scratch->patches.context,
                                                             static_cast<int32_t>(node.first()));
            if (treelet->nodes != nullptr) scratch->stack.push({treelet, 0});
            continue;
        }
        if (node.count() == 0) {
            const Floats8 far2 = max_distance2(node, p);
            const Mask8 closer = far2 < upper->distance2;
            upper->distance2 = select(closer, far2, upper->distance2);
            const uint32_t mask = bits(closer);
            for (int l = 0; l < 8; ++l) {
                if ((mask >> l & 1u) != 0) upper->node[l] = &node;
            }
            continue;
        }
        for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
            update_witness_triangle(e.tree->frames[i], e.tree->details[i], p, w);
        }
        const Mask8 closer = w->distance2 < upper->distance2;
        upper->distance2 = select(closer, w->distance2, upper->distance2);
        const uint32_t mask = bits(closer);
        for (int l = 0; l < 8; ++l) {
            if ((mask >> l & 1u) != 0) upper->node[l] = nullptr;
        }
    }
}

/// Lower bounds of the squared distances of a node of the frontier: of its triangles if it is a
/// leaf, as the box of a large slanted triangle is loose.
struct NodeDistance {
    float center2, corner2;
    bool prunable;
};

NodeDistance node_distance(const NodeRef& e, const Points& center, const Points& corner,
                           PruneBounds* bounds) {
    const Node& node = e.tree->nodes[e.node];
    NodeDistance d{kInfinity, kInfinity, true};
    if (!node.is_leaf() || node.count() == 0) {
        return {least_lane(node_distance2(node, center)), least_lane(node_distance2(node, corner)),
                false};
    }
    for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
        const TriangleFrame& t = e.tree->frames[i];
        if (can_prune(lower_bound(to_frame(t, corner)), bounds)) continue;
        d.prunable = false;
        const float center2 = least_lane(lower_bound(to_frame(t, center)));
        const float corner2 = least_lane(lower_bound(to_frame(t, corner)));
        d.center2 = center2 < d.center2 ? center2 : d.center2;
        d.corner2 = corner2 < d.corner2 ? corner2 : d.corner2;
    }
    return d;
}

/// Returns the squared distance between the node's box and the box of the corners in the node's
/// axes. Exact for a large flat node beside a flat cube, where the distance of the center less half
/// the diagonal is loose.
float separation2(const Node& n, const Points& corner) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) {
        const Floats8 u = dot3(Floats8(n.axis[k][0]), Floats8(n.axis[k][1]), Floats8(n.axis[k][2]),
                               corner.x, corner.y, corner.z) -
                          Floats8(n.center[k]);
        const float above = least_lane(u) - n.half[k];
        const float below = least_lane(Floats8(0.0f) - u) - n.half[k];
        const float gap = larger(larger(above, below), 0.0f);
        sum += gap * gap;
    }
    return sum;
}

/// See KernelTable::bound_cube.
float bound_cube(const KernelInput& in, const Vec3i& lowest, int32_t size, KernelScratch* scratch) {
    scratch->frontier.size = 0;
    scratch->frontier_least.size = 0;
    if (in.root.nodes == nullptr) return kInfinity;
    const int32_t low[3] = {lowest.x, lowest.y, lowest.z};
    const int32_t sizes[3] = {size, size, size};
    const VoxelBox box = make_box(in, low, sizes);
    Witnesses w{Floats8(kInfinity), Floats8(0), Floats8(0), Floats8(0), 0, witness_tolerance(box)};
    CubeUpper upper{Floats8(kInfinity), {}};
    find_upper_bounds(in, box.corner, scratch, &w, &upper);

    PruneBounds bounds;
    make_prune_bounds(box, w, &bounds);
    float hi2 = kInfinity;
    for (int i = 0; i < bounds.count; ++i) {
        const float far2 = largest_lane(Floats8::load(bounds.bound[i]));
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    // Any point of a patch's box may be the one on the surface: the bound is the farthest one at
    // each corner.
    for (int l = 0; l < 8; ++l) {
        bool fresh = upper.node[l] != nullptr;
        for (int j = 0; j < l; ++j)
            fresh = fresh && upper.node[j] != upper.node[l];
        if (!fresh) continue;
        const Floats8 bound = with_slack(max_distance2(*upper.node[l], box.corner), box.delta);
        store(bounds.bound[bounds.count++], bound);
        const float far2 = largest_lane(bound);
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    const float stop = 0.5f * box.half_diagonal;
    scratch->stack.push({&in.root, 0});
    collect_frontier(box, stop * stop, false, nullptr, &bounds, scratch);

    alignas(32) float center[3];
    center[0] =
        largest_lane(box.corner.x) * 0.5f - largest_lane(Floats8(0.0f) - box.corner.x) * 0.5f;
    center[1] =
        largest_lane(box.corner.y) * 0.5f - largest_lane(Floats8(0.0f) - box.corner.y) * 0.5f;
    center[2] =
        largest_lane(box.corner.z) * 0.5f - largest_lane(Floats8(0.0f) - box.corner.z) * 0.5f;
    const Points center_point{Floats8(center[0]), Floats8(center[1]), Floats8(center[2])};
    size_t kept = 0;
    for (size_t i = 0; i < scratch->frontier.size; ++i) {
        const NodeRef e = scratch->frontier.data[i];
        const NodeDistance d = node_distance(e, center_point, box.corner, &bounds);
        if (d.prunable) continue;
        scratch->frontier.data[kept++] = e;
        // No voxel is farther from the center than half the diagonal, and each has a corner within
        // that.
        const float least2 = larger(d.center2, d.corner2);
        const float ball = __builtin_sqrtf(least2) * (1.0f - 0x1p-18f) - box.half_diagonal;
        const float gap =
            __builtin_sqrtf(separation2(e.tree->nodes[e.node], box.corner)) * (1.0f - 0x1p-18f);
        scratch->frontier_least.push(larger(larger(ball, gap) - 2 * box.delta, 0.0f));
    }
    scratch->frontier.size = kept;
    return __builtin_sqrtf(hi2) * kSlack + box.delta;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
