// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocks of 8 x 8 x 8 voxels. Part of kernel.inl.

/// How many voxels of the block ask.
OPENFAB_INLINE int demanded_voxels(const BlockQuery& q) {
    if (q.demand == nullptr) return kBlockVoxels;
    int count = 0;
    for (int i = 0; i < kBlockVoxels / 8; i += 8) {
        uint64_t rows;
        __builtin_memcpy(&rows, q.demand + i, 8);
        count += __builtin_popcountll(rows);
    }
    return count;
}

/// Bit l: lane l of a packet of that many columns, whose voxels these are, asks. Lanes follow each
/// other as voxels do: along z, x, y.
template <int kColumns>
OPENFAB_INLINE uint32_t demanded_lanes(const uint8_t* demand, const int16_t* voxel) {
    constexpr int kHeight = 8 / kColumns;
    const int lowest = voxel[0] & 7;
    uint32_t lanes = 0;
    for (int c = 0; c < kColumns; ++c) {
        const auto column = static_cast<uint32_t>(demand[voxel[c * kHeight] >> 3] >> lowest);
        lanes |= (column & ((1u << kHeight) - 1)) << c * kHeight;
    }
    return lanes;
}

/// Bit q: a voxel of quarter q of the sub-blocks `subs` asks; in `asked` the lanes of their packets
/// that do.
template <int kColumns>
OPENFAB_INLINE uint32_t demanded_quarters(const KernelInput& in, const uint8_t* demand,
                                          uint32_t subs, uint8_t* asked) {
    uint32_t quarters = 0;
    for (; subs != 0; subs &= subs - 1) {
        const int first = 8 * __builtin_ctz(subs);
        for (int packet = first; packet < first + 8; ++packet) {
            const uint32_t lanes = demanded_lanes<kColumns>(demand, in.shape->voxel + packet * 8);
            asked[packet] = static_cast<uint8_t>(lanes);
            quarters |= (lanes != 0 ? 1u : 0u) << (packet >> 1);
        }
    }
    return quarters;
}
OPENFAB_INLINE uint32_t demanded_quarters(const KernelInput& in, const BlockQuery& q, uint32_t subs,
                                          uint8_t* asked) {
    if (q.demand == nullptr) {
        __builtin_memset(asked, 0xff, 64);
        return quarters_of(subs);
    }
    switch (in.shape->packet_size[2]) {
        case 8:
            return demanded_quarters<1>(in, q.demand, subs, asked);
        case 4:
            return demanded_quarters<2>(in, q.demand, subs, asked);
        case 2:
            return demanded_quarters<4>(in, q.demand, subs, asked);
        default:
            return demanded_quarters<8>(in, q.demand, subs, asked);
    }
}

/// Bit s: one of its quarters is among those.
OPENFAB_INLINE uint32_t sub_blocks_of(uint32_t quarters) {
    uint32_t subs = 0;
    for (int sub = 0; sub < 8; ++sub)
        subs |= (quarters >> 4 * sub & 0xfu) != 0 ? 1u << sub : 0u;
    return subs;
}

/// The voxels of a quarter of a sub-block against what is left for it.
OPENFAB_INLINE void query_quarter(const KernelInput& in, const BlockQuery& q, int quarter,
                                  const uint8_t* asked, float radius2, KernelScratch* scratch,
                                  BlockAnswer* answer) {
    using V = Widest;
    constexpr int kParts = V::kLanes / 8;
    const BlockFeatures& block = scratch->features;
    const uint32_t features = block.near_count[quarter];
    if (features == 0) return;
    part_kinds(block.near.data + static_cast<size_t>(quarter) * block.near_stride, features,
               &scratch->by_kind);
    for (int packet = 2 * quarter; packet < 2 * quarter + 2; packet += kParts) {
        uint32_t lanes = 0;
        for (int h = 0; h < kParts; ++h)
            lanes |= static_cast<uint32_t>(asked[packet + h]) << 8 * h;
        if (lanes == 0) continue;
        const PointsOf<V> p = voxel_centres<V>(in, q.block, packet);
        const FeaturesOfQuarter left{block, scratch->by_kind};
        FeatureBest<V> best = nothing_found<V>();
        take_nearest(left, p, &best);
        if ((bits(best.tied) & lanes) != 0) break_ties(left, p, lanes, &best);
        scratch->counts->triangle_tests += int64_t{features} * kParts;
        const int16_t* voxel = in.shape->voxel + packet * 8;
        each_found(left, best, lanes & found_within(best, splat<V>(radius2)),
                   [&](int l, int32_t, const FeatureAnswer& a, float distance2, float bary1,
                       float bary2) { write_voxel(voxel[l], a, distance2, bary1, bary2, answer); });
    }
}

__attribute__((noinline)) void query_quarters(const KernelInput& in, const BlockQuery& q,
                                              uint32_t quarters, const uint8_t* asked,
                                              KernelScratch* scratch, BlockAnswer* answer) {
    const float radius2 = q.radius_mm < kInfinity ? q.radius_mm * q.radius_mm : kInfinity;
    for (; quarters != 0; quarters &= quarters - 1)
        query_quarter(in, q, __builtin_ctz(quarters), asked, radius2, scratch, answer);
}

void clear(BlockAnswer* answer) {
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->distance2[i] = kInfinity;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->patch[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->triangle[i] = -1;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->bary1[i] = 0;
    for (int i = 0; i < kBlockVoxels; ++i)
        answer->bary2[i] = 0;
}

/// Puts the leaves below the entries of the list in their place.
OPENFAB_INLINE void open_list(const BoxOfPoints& box, Domination* rows, KernelScratch* scratch) {
    for (size_t i = 0; i < scratch->list.size; ++i)
        scratch->stack.push(scratch->list.data[i]);
    scratch->list.size = 0;
    collect(box, 0.0f, true, nullptr, rows, scratch);
}

void query(const KernelInput& in, const BlockQuery& q, KernelScratch* scratch,
           BlockAnswer* answer) {
    clear(answer);
    const int demanded = demanded_voxels(q);
    scratch->counts->asked += demanded;
    scratch->counts->skipped += kBlockVoxels - demanded;
    if (demanded == 0 || in.root.nodes == nullptr) return;
    scratch->stack.size = 0;
    BlockCorners corners;
    find_corners(in, q.block, q.radius_mm, scratch, &corners);
    uint32_t subs = 0xff;
    if (q.radius_mm < kInfinity) {
        subs = sub_blocks_in_reach(in, corners, q.radius_mm);
        if (subs == 0 || corners.found == 0) return;
    }
    uint8_t asked[64];
    const uint32_t quarters = demanded_quarters(in, q, subs, asked);
    if (quarters == 0) return;
    subs = sub_blocks_of(quarters);
    const BoxOfPoints box = box_around(in, q.block, subs);
    Domination rows;
    for (uint32_t c = corners.found; c != 0; c &= c - 1) {
        const int i = __builtin_ctz(c);
        add_point_row(box, corners.point[0][i], corners.point[1][i], corners.point[2][i], &rows);
    }
    add_radius_row(box, q.radius_mm, &rows);
    const float farthest2 = farthest_row2(rows), radius2 = q.radius_mm * q.radius_mm;
    BlockPlace place =
        make_place(in, q.block, farthest2 < radius2 ? farthest2 : radius2, box.delta);
    const float half_diagonal = in.shape->half_diagonal;
    const bool near = place.reach < kNear * half_diagonal;
    const bool by_cones = near && !in.walks;
    const float stop = near && in.walks ? kSearchFrom * half_diagonal : 0.0f;
    scratch->list.size = 0;
    scratch->stack.push({&in.root, 0});
    collect(box, stop * stop, true, by_cones ? &place : nullptr, &rows, scratch);
    if (near && is_dense(*scratch, half_diagonal)) {
        if (in.walks) {
            query_walks(in, q, place, quarters, asked, box.delta, scratch, answer);
        } else {
            list_near_leaves(place, quarters, scratch);
            query_near(in, q, place, quarters, asked, box.delta, scratch, answer);
        }
        return;
    }
    if (stop > 0) open_list(box, &rows, scratch);
    narrow_to_sub_blocks(in, q, subs, scratch);
    collect_features(place, quarters, scratch);
    query_quarters(in, q, quarters, asked, scratch, answer);
}
