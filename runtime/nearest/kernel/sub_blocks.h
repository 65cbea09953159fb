// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Narrows the frontier of a deep block to its sub-blocks.
//
// Corners of the whole block prune little near the centers of its faces: half of the leaves they
// keep matter to no voxel. So each sub-block gets witnesses of its own, from the leaves of the
// block's frontier.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/nodes.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"
#include "simd/lists.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Shorter frontiers are not narrowed: it would cost what it saves (docs/measurements).
constexpr size_t kMinLeaves = 56;
/// Alternating corners of a box; they prune nearly as much as all eight.
constexpr int kAlternating[4] = {0, 3, 5, 6};
constexpr uint32_t kFourCorners =
    1u << kAlternating[0] | 1u << kAlternating[1] | 1u << kAlternating[2] | 1u << kAlternating[3];

/// The nearest leaves to four corners of each sub-block, each lane among those it has seen.
template <typename V>
struct NearestLeaves {
    V distance2[8][4];
    typename V::Ints index[8][4];  ///< in the frontier
};

/// Computes the squared distances of the frontier's leaves to the corners of the sub-blocks in
/// `subs`, one leaf per lane: frontier_distance2[(vector * 8 + sub) * 8 + corner].
template <typename V>
OPENFAB_INLINE void measure_leaves(const VoxelBox* sub_box, uint32_t subs, KernelScratch* scratch,
                                   NearestLeaves<V>* nearest) {
    constexpr size_t kLanes = V::kLanes;
    const size_t count = scratch->frontier.size;
    scratch->frontier_distance2.reserve((count + kLanes) / kLanes * 64);
    for (int sub = 0; sub < 8; ++sub) {
        for (int i = 0; i < 4; ++i) {
            nearest->distance2[sub][i] = V(kInfinity);
            nearest->index[sub][i] = 0;
        }
    }
    alignas(64) int32_t indices_of[kLanes];
    for (size_t first = 0; first < count; first += kLanes) {
        for (size_t l = 0; l < kLanes; ++l)
            indices_of[l] = static_cast<int32_t>(first + l < count ? first + l : first);
        const auto index = V::Ints::load(indices_of);
        const auto boxes = load_boxes<V>(scratch->frontier.data + first, count - first);
        Lanes* out = scratch->frontier_distance2.data + first / kLanes * 64;
        for (uint32_t left = subs; left != 0; left &= left - 1) {
            const int sub = __builtin_ctz(left);
            V distance2[8];
            corner_distances2(boxes, project_box(boxes, sub_box[sub]), distance2);
            for (int c = 0; c < 8; ++c)
                store(out[sub * 8 + c].v, distance2[c]);
            for (int i = 0; i < 4; ++i) {
                V& least = nearest->distance2[sub][i];
                const V d2 = distance2[kAlternating[i]];
                const auto closer = d2 < least;
                least = min(d2, least);
                nearest->index[sub][i] = select(closer, index, nearest->index[sub][i]);
            }
        }
    }
}

/// Returns `of` in the lane with the least value.
template <typename V>
OPENFAB_INLINE int32_t at_least_lane(V value, typename V::Ints of) {
    alignas(64) float v[V::kLanes];
    alignas(64) int32_t o[V::kLanes];
    store(v, value);
    store(o, of);
    for (int half = V::kLanes / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; ++l) {
            o[l] = v[l + half] < v[l] ? o[l + half] : o[l];
            v[l] = v[l + half] < v[l] ? v[l + half] : v[l];
        }
    }
    return o[0];
}

/// Updates witnesses with a triangle's corners; enough if triangles are small relative to the box.
OPENFAB_INLINE void update_witness_corners(const TriangleFrame& t, const TriangleDetail& d,
                                           const Points& p, Witnesses* w) {
    update_witness_point(t.v0[0], t.v0[1], t.v0[2], p, w);
    update_witness_point(d.v1[0], d.v1[1], d.v1[2], p, w);
    update_witness_point(d.v2[0], d.v2[1], d.v2[2], p, w);
}

/// Makes the prune bounds of sub-block `sub`, whose box is `box`, from the leaves nearest to its
/// corners.
template <typename V>
OPENFAB_INLINE void make_sub_block_bounds(const VoxelBox& box, int sub, float radius,
                                          const NearestLeaves<V>& nearest, KernelScratch* scratch,
                                          PruneBounds* bounds) {
    Witnesses w{Floats8(kInfinity), Floats8(0), Floats8(0), Floats8(0), 0, Floats8(0)};
    int32_t leaf[4];
    for (int i = 0; i < 4; ++i) {
        leaf[i] = at_least_lane(nearest.distance2[sub][i], nearest.index[sub][i]);
        bool seen = false;
        for (int j = 0; j < i; ++j)
            seen |= leaf[j] == leaf[i];
        if (seen) continue;
        const NodeRef& e = scratch->frontier.data[leaf[i]];
        const Node& node = e.tree->nodes[e.node];
        for (uint32_t t = node.first(); t < node.first() + node.count(); ++t)
            update_witness_corners(e.tree->frames[t], e.tree->details[t], box.corner, &w);
    }
    w.found &= kFourCorners;
    make_prune_bounds(box, w, bounds);
    add_radius_bound(box, radius, bounds);
}

/// Keeps the leaves of the frontier that may be nearest to a voxel of a sub-block in `subs`;
/// frontier_subs tells of which.
__attribute__((noinline)) void narrow_to_sub_blocks(const KernelInput& in, const BlockQuery& q,
                                                    uint32_t subs, KernelScratch* scratch) {
    using V = simd::WidestFloats;
    constexpr size_t kLanes = V::kLanes;
    const size_t count = scratch->frontier.size;
    scratch->frontier_subs.reserve(count + 32);
    uint8_t* const mask = scratch->frontier_subs.data;
    if (count < kMinLeaves) {
        for (size_t i = 0; i < count; ++i)
            mask[i] = static_cast<uint8_t>(subs);
        return;
    }
    VoxelBox sub_box[8];
    for (uint32_t left = subs; left != 0; left &= left - 1)
        sub_box[__builtin_ctz(left)] = box_around(in, q.block, left & (0u - left));
    NearestLeaves<V> nearest;
    measure_leaves(sub_box, subs, scratch, &nearest);
    for (size_t i = 0; i < count + 32; ++i)
        mask[i] = 0;
    for (uint32_t left = subs; left != 0; left &= left - 1) {
        const int sub = __builtin_ctz(left);
        PruneBounds bounds;
        make_sub_block_bounds(sub_box[sub], sub, q.radius_mm, nearest, scratch, &bounds);
        for (size_t first = 0; first < count; first += kLanes) {
            const Lanes* in = scratch->frontier_distance2.data + first / kLanes * 64 + sub * 8;
            V distance2[8];
            for (int c = 0; c < 8; ++c)
                distance2[c] = V::load(in[c].v);
            const uint32_t kept = ~prunable_lanes(distance2, bounds);
            simd::add_bit<V::kLanes>(kept, sub, mask + first);
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        scratch->frontier.data[kept] = scratch->frontier.data[i];
        mask[kept] = mask[i];
        kept += mask[i] != 0 ? 1 : 0;
    }
    scratch->frontier.size = kept;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
