// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of blocks of 8 x 8 x 8 voxels.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/answers.h"
#include "runtime/nearest/kernel/best.h"
#include "runtime/nearest/kernel/block_frame.h"
#include "runtime/nearest/kernel/corner_cache.h"
#include "runtime/nearest/kernel/features.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/near.h"
#include "runtime/nearest/kernel/nodes.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/sub_blocks.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Counts the active voxels of the block.
OPENFAB_INLINE int count_active_voxels(const BlockQuery& q) {
    if (q.active == nullptr) return kBlockVoxels;
    int count = 0;
    for (int i = 0; i < kBlockVoxels / 8; i += 8) {
        uint64_t columns;
        __builtin_memcpy(&columns, q.active + i, 8);
        count += __builtin_popcountll(columns);
    }
    return count;
}

/// Returns the active lanes of a packet of kColumns columns whose voxels these are. Lanes are in
/// the order of voxels: along z, x, y.
template <int kColumns>
OPENFAB_INLINE uint32_t packet_lanes(const uint8_t* active, const int16_t* voxel) {
    constexpr int kHeight = 8 / kColumns;
    const int lowest = voxel[0] & 7;
    uint32_t lanes = 0;
    for (int c = 0; c < kColumns; ++c) {
        const auto column = static_cast<uint32_t>(active[voxel[c * kHeight] >> 3] >> lowest);
        lanes |= (column & ((1u << kHeight) - 1)) << c * kHeight;
    }
    return lanes;
}

/// Returns the quarters of the sub-blocks `subs` with an active voxel, and in `active_lanes` the
/// active lanes of their packets.
template <int kColumns>
OPENFAB_INLINE uint32_t active_quarters(const KernelInput& in, const uint8_t* active, uint32_t subs,
                                        uint8_t* active_lanes) {
    uint32_t quarters = 0;
    for (; subs != 0; subs &= subs - 1) {
        const int first = 8 * __builtin_ctz(subs);
        for (int packet = first; packet < first + 8; ++packet) {
            const uint32_t lanes = packet_lanes<kColumns>(active, in.shape->voxel + packet * 8);
            active_lanes[packet] = static_cast<uint8_t>(lanes);
            quarters |= (lanes != 0 ? 1u : 0u) << (packet >> 1);
        }
    }
    return quarters;
}
OPENFAB_INLINE uint32_t active_quarters(const KernelInput& in, const BlockQuery& q, uint32_t subs,
                                        uint8_t* active_lanes) {
    if (q.active == nullptr) {
        __builtin_memset(active_lanes, 0xff, 64);
        return quarters_of(subs);
    }
    switch (in.shape->packet_size[2]) {
        case 8:
            return active_quarters<1>(in, q.active, subs, active_lanes);
        case 4:
            return active_quarters<2>(in, q.active, subs, active_lanes);
        case 2:
            return active_quarters<4>(in, q.active, subs, active_lanes);
        default:
            return active_quarters<8>(in, q.active, subs, active_lanes);
    }
}

/// Returns the sub-blocks that have one of these quarters.
OPENFAB_INLINE uint32_t sub_blocks_of(uint32_t quarters) {
    uint32_t subs = 0;
    for (int sub = 0; sub < 8; ++sub)
        subs |= (quarters >> 4 * sub & 0xfu) != 0 ? 1u << sub : 0u;
    return subs;
}

/// Queries the active voxels of a quarter against its candidate features, without a branch.
OPENFAB_INLINE void query_quarter(const KernelInput& in, const BlockQuery& q, int quarter,
                                  const uint8_t* active_lanes, float radius2,
                                  KernelScratch* scratch, BlockAnswer* answer) {
    using V = simd::WidestFloats;
    constexpr int kParts = V::kLanes / 8;
    const BlockFeatures& block = scratch->features;
    const uint32_t features = block.quarter_count[quarter];
    if (features == 0) return;
    partition_by_kind(block.in_quarter.data + static_cast<size_t>(quarter) * block.quarter_stride,
                      features, &scratch->by_kind);
    for (int packet = 2 * quarter; packet < 2 * quarter + 2; packet += kParts) {
        uint32_t lanes = 0;
        for (int h = 0; h < kParts; ++h)
            lanes |= static_cast<uint32_t>(active_lanes[packet + h]) << 8 * h;
        if (lanes == 0) continue;
        const PointsOf<V> p = voxel_centers<V>(in, q.block, packet);
        const FeaturesOfQuarter candidates{block, scratch->by_kind};
        FeatureBest<V> best = nothing_found<V>();
        update_nearest(candidates, p, &best);
        if ((bits(best.tied) & lanes) != 0) break_ties(candidates, p, lanes, &best);
        scratch->counts->triangle_tests += int64_t{features} * kParts;
        const int16_t* voxel = in.shape->voxel + packet * 8;
        each_found(candidates, best, lanes & found_within(best, V(radius2)),
                   [&](int l, int32_t, const FeatureAnswer& a, float distance2, float bary1,
                       float bary2) { write_voxel(voxel[l], a, distance2, bary1, bary2, answer); });
    }
}

__attribute__((noinline)) void query_quarters(const KernelInput& in, const BlockQuery& q,
                                              uint32_t quarters, const uint8_t* active_lanes,
                                              KernelScratch* scratch, BlockAnswer* answer) {
    const float radius2 = q.radius_mm < kInfinity ? q.radius_mm * q.radius_mm : kInfinity;
    for (; quarters != 0; quarters &= quarters - 1)
        query_quarter(in, q, __builtin_ctz(quarters), active_lanes, radius2, scratch, answer);
}

void clear(BlockAnswer* answer) {
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->distance2[i] = kInfinity;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->item[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->in_patch.triangle[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->in_patch.bary1[i] = 0;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->in_patch.bary2[i] = 0;
}

/// Replaces the nodes of the frontier by the surviving leaves below them.
OPENFAB_INLINE void expand_to_leaves(const VoxelBox& box, PruneBounds* bounds,
                                     KernelScratch* scratch) {
    for (size_t i = 0; i < scratch->frontier.size; ++i)
        scratch->stack.push(scratch->frontier.data[i]);
    scratch->frontier.size = 0;
    collect_frontier(box, 0.0f, true, nullptr, bounds, scratch);
}

void query(const KernelInput& in, const BlockQuery& q, KernelScratch* scratch,
           BlockAnswer* answer) {
    clear(answer);
    const int active_voxels = count_active_voxels(q);
    scratch->counts->queried += active_voxels;
    scratch->counts->skipped += kBlockVoxels - active_voxels;
    if (active_voxels == 0 || in.root.nodes == nullptr) return;
    scratch->stack.size = 0;
    BlockCorners corners;
    find_corners(in, q.block, q.radius_mm, scratch, &corners);
    uint32_t subs = 0xff;
    if (q.radius_mm < kInfinity) {
        subs = sub_blocks_in_reach(in, corners, q.radius_mm);
        if (subs == 0 || corners.found == 0) return;
    }
    uint8_t active_lanes[64];
    const uint32_t quarters = active_quarters(in, q, subs, active_lanes);
    if (quarters == 0) return;
    subs = sub_blocks_of(quarters);
    const VoxelBox box = box_around_quarters(in, q.block, quarters);
    PruneBounds bounds;
    for (uint32_t c = corners.found; c != 0; c &= c - 1) {
        const int i = __builtin_ctz(c);
        add_point_bound(box, corners.point[0][i], corners.point[1][i], corners.point[2][i],
                        &bounds);
    }
    add_radius_bound(box, q.radius_mm, &bounds);
    const float farthest2 = upper_bound2(bounds), radius2 = q.radius_mm * q.radius_mm;
    BlockFrame frame =
        make_block_frame(in, q.block, farthest2 < radius2 ? farthest2 : radius2, box.delta);
    const float half_diagonal = in.shape->half_diagonal;
    const bool near = frame.reach < kNear * half_diagonal;
    const bool by_cones = near && !in.traverse_per_packet;
    const float stop = near && in.traverse_per_packet ? kSearchFrom * half_diagonal : 0.0f;
    scratch->frontier.size = 0;
    scratch->stack.push({&in.root, 0});
    collect_frontier(box, stop * stop, true, by_cones ? &frame : nullptr, &bounds, scratch);
    if (near && is_dense(*scratch, half_diagonal)) {
        if (in.traverse_per_packet) {
            query_by_traversal(in, q, frame, quarters, active_lanes, box.delta, scratch, answer);
        } else {
            list_near_leaves(frame, quarters, scratch);
            query_near(in, q, frame, quarters, active_lanes, box.delta, scratch, answer);
        }
        return;
    }
    if (stop > 0) expand_to_leaves(box, &bounds, scratch);
    narrow_to_sub_blocks(in, q, subs, scratch);
    collect_features(frame, quarters, scratch);
    query_quarters(in, q, quarters, active_lanes, scratch, answer);
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
