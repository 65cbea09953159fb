// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blocks near the surface, packet by packet: each against the leaves that may be nearest to its
// quarter by their normal cones (tree/cones.h), or by traversal.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/answers.h"
#include "runtime/nearest/kernel/best.h"
#include "runtime/nearest/kernel/block_frame.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/nodes.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/search.h"
#include "runtime/nearest/kernel/voxel_box.h"
#include "simd/lists.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// A block is near the surface if no voxel is farther from it than this, in half diagonals of a
/// block. It is searched as below if triangles are dense, that is outnumber the active voxels; else
/// testing features for all voxels at once costs less (docs/measurements).
constexpr float kNear = 1.0f;
constexpr float kDense = 4.0f;  ///< half diagonal of a block, in spacings of triangles
/// Maximum size of the nodes where traversal begins, in half diagonals of the block.
constexpr float kSearchFrom = 1.5f;

/// Returns whether triangles are dense in the nodes of the frontier.
OPENFAB_INLINE bool is_dense(const KernelScratch& scratch, float half_diagonal) {
    for (size_t i = 0; i < scratch.frontier.size; ++i) {
        const float spacing = scratch.frontier.data[i].tree->spacing;
        if (spacing > 0) return half_diagonal > kDense * spacing;
    }
    return true;
}

/// Lists the leaves of the frontier with their cones, and for each of the `quarters` the indices of
/// those that may be nearest to a voxel of it.
__attribute__((noinline)) void list_near_leaves(const BlockFrame& frame, uint32_t quarters,
                                                KernelScratch* scratch) {
    using V = simd::WidestFloats;
    constexpr size_t kLanes = V::kLanes;
    const BlockShape& shape = *frame.shape;
    const NodeRef* frontier = scratch->frontier.data;
    const size_t count = scratch->frontier.size;
    NearLeaves& out = scratch->near;
    out.leaves.reserve(count);
    out.stride = count + kLanes;
    out.indices.reserve(kQuarters * out.stride);
    for (uint32_t& n : out.count)
        n = 0;
    const V zero = V(0.0f), reach2 = V(frame.reach * frame.reach);
    for (size_t first = 0; first < count; first += kLanes) {
        const size_t some = count - first < kLanes ? count - first : kLanes;
        const auto boxes = load_boxes<V>(frontier + first, some);
        const auto cones = load_cones<V>(frontier + first, some);
        // The slope is the cone's tangent; no limit where the cone is not known.
        const auto known = cones.sine < V(1.0f);
        const V cosine2 = V(1.0f) - cones.sine * cones.sine;
        const V slope = select(known, cones.sine / sqrt(cosine2), zero);
        const V offset = select(known, cone_offset(cones, frame), V(kInfinity));
        alignas(64) float slope_of[kLanes], offset_of[kLanes];
        store(slope_of, slope);
        store(offset_of, offset);
        for (size_t l = 0; l < some; ++l)
            out.leaves.data[first + l] = {frontier[first + l], slope_of[l], offset_of[l]};
        V of_sub[3][8], of_quarter[3][4], extent[3];
        for (int k = 0; k < 3; ++k) {
            LinearForm<V> s;
            s.center = about_dot(boxes.axis[k], frame.center, zero - boxes.center[k]);
            for (int a = 0; a < 3; ++a)
                s.by[a] = about_dot(boxes.axis[k], frame.step + 3 * a, zero);
            of_sub[k][0] = s.center;
            part_centers<3>(s, shape.sub_axis, shape.sub_half, of_sub[k]);
            of_quarter[k][0] = zero;
            part_centers<2>(s, shape.quarter_axis, shape.quarter_half, of_quarter[k]);
            extent[k] = boxes.half[k] + (deviation(s, shape.quarter_reach) + V(frame.slack));
        }
        const V least_across = about_mul_add(slope, extent[2], offset);
        const uint32_t lanes = (1u << some) - 1;
        for (uint32_t left = quarters; left != 0; left &= left - 1) {
            const int quarter = __builtin_ctz(left);
            V u[3], d[3], sum = zero;
            for (int k = 0; k < 3; ++k) {
                u[k] = absolute(of_sub[k][quarter >> 2] + of_quarter[k][quarter & 3]);
                d[k] = max(u[k] - extent[k], zero);
                sum = about_mul_add(d[k], d[k], sum);
            }
            const V across = about_mul_add(u[2], slope, least_across);
            const uint32_t near = lanes & bits((max(d[0], d[1]) <= across) & (sum <= reach2));
            uint32_t* indices = out.indices.data + static_cast<size_t>(quarter) * out.stride;
            uint32_t& listed = out.count[quarter];
            listed +=
                simd::list_lanes<V::kLanes>(near, static_cast<uint32_t>(first), indices + listed);
        }
    }
}

/// Returns the squared distance of each point to the leaf's box; infinite outside its normal cone.
template <typename V>
OPENFAB_INLINE V near_distance2(const NearLeaf& leaf, const PointsOf<V>& p) {
    const Node& n = leaf.entry.tree->nodes[leaf.entry.node];
    V u[3], d[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = along_axis(n, k, p);
        d[k] = max(u[k] - V(n.half[k]), V(0.0f));
    }
    const V across = about_mul_add(u[2] + V(n.half[2]), V(leaf.slope), V(leaf.offset));
    const V distance2 = about_mul_add(d[2], d[2], about_mul_add(d[1], d[1], d[0] * d[0]));
    return select(max(d[0], d[1]) <= across, distance2, V(kInfinity));
}

/// Queries the active voxels of `quarters`; calls find(quarter, &search) for each packet.
template <typename V, typename Find>
OPENFAB_INLINE void query_packets(const KernelInput& in, const BlockQuery& q,
                                  const BlockFrame& frame, uint32_t quarters,
                                  const uint8_t* active_lanes, float delta, KernelScratch* scratch,
                                  BlockAnswer* answer, const Find& find) {
    constexpr int kParts = V::kLanes / 8;
    const V radius2 = V(q.radius_mm * q.radius_mm);
    const V reach2 = V(frame.reach * frame.reach);
    WarmStart warm = scratch->warm;
    for (; quarters != 0; quarters &= quarters - 1) {
        const int quarter = __builtin_ctz(quarters);
        for (int packet = 2 * quarter; packet < 2 * quarter + 2; packet += kParts) {
            uint32_t lanes = 0;
            for (int h = 0; h < kParts; ++h)
                lanes |= static_cast<uint32_t>(active_lanes[packet + h]) << 8 * h;
            if (lanes == 0) continue;
            SearchOf<V> s;
            s.p = voxel_centers<V>(in, q.block, packet);
            begin_search(lanes, warm_distance2(warm, s.p, reach2), V(delta), scratch, &s);
            find(quarter, &s);
            const uint32_t found = lanes & found_within(s.best, radius2);
            if (found == 0) continue;
            const FeaturesOfLeaves leaves{*scratch};
            if ((bits(s.best.tied) & found) != 0) break_ties(leaves, s.p, found, &s.best);
            warm.count = 0;
            const int16_t* voxel = in.shape->voxel + packet * 8;
            each_found(leaves, s.best, found,
                       [&](int l, int32_t index, const FeatureAnswer& a, float distance2,
                           float bary1, float bary2) {
                           write_voxel(voxel[l], a, distance2, bary1, bary2, answer);
                           // Every other lane of a wide packet.
                           if (l % kParts == 0)
                               keep_point(leaves.feature(index), bary1, bary2, &warm);
                       });
        }
    }
}

/// Queries each packet against the leaves listed for its quarter.
__attribute__((noinline)) void query_near(const KernelInput& in, const BlockQuery& q,
                                          const BlockFrame& frame, uint32_t quarters,
                                          const uint8_t* active_lanes, float delta,
                                          KernelScratch* scratch, BlockAnswer* answer) {
    using V = simd::WidestFloats;
    const NearLeaves& near = scratch->near;
    query_packets<V>(in, q, frame, quarters, active_lanes, delta, scratch, answer,
                     [&](int quarter, SearchOf<V>* s) OPENFAB_INLINE_LAMBDA {
                         const uint32_t* indices =
                             near.indices.data + static_cast<size_t>(quarter) * near.stride;
                         const uint32_t count = near.count[quarter];
                         PrefetchedLeaf<V> pending;
                         for (uint32_t i = 0; i < count; ++i) {
                             const NearLeaf& leaf = near.leaves.data[indices[i]];
                             const V distance2 = near_distance2(leaf, s->p);
                             if (any(distance2 <= s->limit))
                                 pending.prefetch(leaf.entry, distance2, scratch, s);
                         }
                         pending.flush(scratch, s);
                         scratch->counts->node_tests += int64_t{count} * V::kLanes / 8;
                     });
}

/// Queries each packet by traversal below the nodes of the frontier.
__attribute__((noinline)) void query_by_traversal(const KernelInput& in, const BlockQuery& q,
                                                  const BlockFrame& frame, uint32_t quarters,
                                                  const uint8_t* active_lanes, float delta,
                                                  KernelScratch* scratch, BlockAnswer* answer) {
    using V = simd::WidestFloats;
    query_packets<V>(in, q, frame, quarters, active_lanes, delta, scratch, answer,
                     [&](int, SearchOf<V>* s) OPENFAB_INLINE_LAMBDA {
                         search(scratch->frontier.data, scratch->frontier.size, scratch, s);
                     });
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
