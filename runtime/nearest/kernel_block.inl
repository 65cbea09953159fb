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

/// Bit l: lane l of the packet asks. Lanes follow each other as voxels do: along z, x, y.
OPENFAB_INLINE uint32_t demanded_lanes(const KernelInput& in, const BlockQuery& q, int packet) {
    const int32_t* origin = in.shape->packet_origin[packet];
    const int32_t* size = in.shape->packet_size;
    const uint32_t column = (1u << size[2]) - 1;
    uint32_t lanes = 0;
    int l = 0;
    for (int32_t y = origin[1]; y < origin[1] + size[1]; ++y) {
        for (int32_t x = origin[0]; x < origin[0] + size[0]; ++x, l += size[2])
            lanes |= (static_cast<uint32_t>(q.demand[y * 8 + x]) >> origin[2] & column) << l;
    }
    return lanes;
}

/// Bit q: a voxel of quarter q of the sub-blocks `subs` asks; in `asked` the lanes of their packets
/// that do.
OPENFAB_INLINE uint32_t demanded_quarters(const KernelInput& in, const BlockQuery& q, uint32_t subs,
                                          uint8_t* asked) {
    uint32_t quarters = 0;
    for (; subs != 0; subs &= subs - 1) {
        const int first = 8 * __builtin_ctz(subs);
        for (int packet = first; packet < first + 8; ++packet) {
            const uint32_t lanes = q.demand == nullptr ? 0xff : demanded_lanes(in, q, packet);
            asked[packet] = static_cast<uint8_t>(lanes);
            if (lanes != 0) quarters |= 1u << (packet >> 1);
        }
    }
    return quarters;
}

/// Bit s: one of its quarters is among those.
OPENFAB_INLINE uint32_t sub_blocks_of(uint32_t quarters) {
    uint32_t subs = 0;
    for (int sub = 0; sub < 8; ++sub)
        subs |= (quarters >> 4 * sub & 0xfu) != 0 ? 1u << sub : 0u;
    return subs;
}

OPENFAB_INLINE void write_voxel(int v, const FeatureAnswer& a, float distance2, float bary1,
                                float bary2, BlockAnswer* answer) {
    answer->distance2[v] = distance2;
    answer->patch[v] = a.patch;
    answer->triangle[v] = a.triangle;
    answer->bary1[v] = bary1;
    answer->bary2[v] = bary2;
}

/// The voxels of a quarter of a sub-block against what is left for it.
OPENFAB_INLINE void query_quarter(const KernelInput& in, const BlockQuery& q, int quarter,
                                  const uint8_t* asked, float radius2, KernelScratch* scratch,
                                  BlockAnswer* answer) {
    using V = Widest;
    constexpr int kParts = V::kLanes / 8;
    const uint32_t features = scratch->faces.near_count[quarter] +
                              scratch->edges.near_count[quarter] +
                              scratch->vertices.near_count[quarter];
    if (features == 0) return;
    for (int packet = 2 * quarter; packet < 2 * quarter + 2; packet += kParts) {
        uint32_t lanes = 0;
        for (int h = 0; h < kParts; ++h)
            lanes |= static_cast<uint32_t>(asked[packet + h]) << 8 * h;
        if (lanes == 0) continue;
        const PointsOf<V> p = voxel_centres<V>(in, q.block, packet);
        const FeaturesOfQuarter left{*scratch, quarter};
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

/// A block is searched quarter by quarter where triangles are small beside it, and near: there its
/// triangles outnumber the voxels that ask. Else taking their features apart for all of them at
/// once costs less (bench/README.md).
constexpr float kDense = 4.7f;  ///< half diagonals of a block in spacings of triangles
constexpr float kNear = 0.8f;   ///< the farthest answer in half diagonals
/// Nodes no larger than this, in half diagonals of the block, are where the walks begin.
constexpr float kSearchFrom = 1.5f;

/// Whether triangles are dense where the list's entries are.
OPENFAB_INLINE bool is_dense(const KernelScratch& scratch, float half_diagonal) {
    for (size_t i = 0; i < scratch.list.size; ++i) {
        const float spacing = scratch.list.data[i].tree->spacing;
        if (spacing > 0) return half_diagonal > kDense * spacing;
    }
    return true;
}

/// Voxels quarter by quarter, each a walk below the entries of the list.
__attribute__((noinline)) void search_quarters(const KernelInput& in, const BlockQuery& q,
                                               uint32_t quarters, const uint8_t* asked, float delta,
                                               KernelScratch* scratch, BlockAnswer* answer) {
    using V = Widest;
    constexpr int kParts = V::kLanes / 8;
    const V radius2 = splat<V>(q.radius_mm < kInfinity ? q.radius_mm * q.radius_mm : kInfinity);
    WarmStart warm = scratch->warm;
    for (; quarters != 0; quarters &= quarters - 1) {
        const int quarter = __builtin_ctz(quarters);
        for (int packet = 2 * quarter; packet < 2 * quarter + 2; packet += kParts) {
            uint32_t lanes = 0;
            for (int h = 0; h < kParts; ++h)
                lanes |= static_cast<uint32_t>(asked[packet + h]) << 8 * h;
            if (lanes == 0) continue;
            SearchOf<V> s;
            s.p = voxel_centres<V>(in, q.block, packet);
            begin_search(lanes, warm_distance2(warm, s.p, radius2), splat<V>(delta), scratch, &s);
            search(scratch->list.data, scratch->list.size, scratch, &s);
            const uint32_t found = lanes & found_within(s.best, radius2);
            if (found == 0) continue;
            const FeaturesOfLeaves leaves{*scratch};
            if ((bits(s.best.tied) & found) != 0) break_ties(leaves, s.p, found, &s.best);
            warm.count = 0;
            const int16_t* voxel = in.shape->voxel + packet * 8;
            each_found(leaves, s.best, found,
                       [&](int l, int32_t place, const FeatureAnswer& a, float distance2,
                           float bary1, float bary2) {
                           write_voxel(voxel[l], a, distance2, bary1, bary2, answer);
                           // Of a wide packet every other.
                           if (l % kParts == 0)
                               keep_point(leaves.feature(place), bary1, bary2, &warm);
                       });
        }
    }
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

/// What is left below the entries of the list, as leaves.
OPENFAB_INLINE void open_list(const BoxOfPoints& box, Domination* rows, KernelScratch* scratch) {
    for (size_t i = 0; i < scratch->list.size; ++i)
        scratch->stack.push(scratch->list.data[i]);
    scratch->list.size = 0;
    collect(box, 0.0f, true, rows, scratch);
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
    find_corners(in, q, scratch, &corners);
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
        add_point_row(box, corners.x[i], corners.y[i], corners.z[i], &rows);
    }
    add_radius_row(box, q.radius_mm, &rows);
    const float farthest2 = farthest_row2(rows);
    scratch->list.size = 0;
    const float half_diagonal = in.shape->half_diagonal;
    const float reach2 =
        farthest2 < q.radius_mm * q.radius_mm ? farthest2 : q.radius_mm * q.radius_mm;
    const bool near = reach2 < (kNear * half_diagonal) * (kNear * half_diagonal);
    const float stop = near ? kSearchFrom * half_diagonal : 0.0f;
    scratch->stack.push({&in.root, 0});
    collect(box, stop * stop, true, &rows, scratch);
    if (near && is_dense(*scratch, half_diagonal)) {
        search_quarters(in, q, quarters, asked, box.delta, scratch, answer);
        return;
    }
    if (near) open_list(box, &rows, scratch);
    const BlockPlace place = make_place(in, q.block, farthest2, box.delta);
    narrow_to_sub_blocks(in, q, subs, scratch);
    collect_features(place, subs, scratch);
    if (scratch->answers.size == 0) return;
    list_near_features(place, quarters, scratch);
    query_quarters(in, q, quarters, asked, scratch, answer);
}
