// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocks of 8 x 8 x 8 voxels. Part of kernel.inl.

/// Of packet `packet` and, where V is wide, the next.
template <typename V>
OPENFAB_INLINE PointsOf<V> voxel_centres(const KernelInput& in, const Vec3i& block, int packet) {
    const float* f = in.frame;
    const BlockShape& s = *in.shape;
    V at[3];
    for (int a = 0; a < 3; ++a) {
        F8 parts[V::kLanes / 8];
        for (int h = 0; h < V::kLanes / 8; ++h) {
            parts[h] = set1(static_cast<float>(block[a] + s.packet_origin[packet + h][a])) +
                       load(s.lane_offset[a]) + set1(0.5f);
        }
        at[a] = Width<V>::join(parts);
    }
    V c[3];
    for (int a = 0; a < 3; ++a) {
        const float step[3] = {f[OPENFAB_FRAME_STEP_I + a], f[OPENFAB_FRAME_STEP_J + a],
                               f[OPENFAB_FRAME_STEP_K + a]};
        c[a] = dot_with(step, at[0], at[1], at[2]) + splat<V>(f[OPENFAB_FRAME_ORIGIN + a]);
    }
    return {c[0], c[1], c[2]};
}

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

/// Bit q: a voxel of quarter q of the sub-blocks `subs` asks; in `asked` the lanes of their packets
/// that do.
OPENFAB_INLINE uint32_t demanded_quarters(const KernelInput& in, const BlockQuery& q, uint32_t subs,
                                          uint8_t* asked) {
    uint32_t quarters = 0;
    for (; subs != 0; subs &= subs - 1) {
        const int first = 8 * __builtin_ctz(subs);
        for (int packet = first; packet < first + 8; ++packet) {
            uint32_t lanes = q.demand == nullptr ? 0xff : 0;
            const int16_t* voxel = in.shape->voxel + packet * 8;
            for (int l = 0; q.demand != nullptr && l < 8; ++l) {
                const int v = voxel[l];
                lanes |= (static_cast<uint32_t>(q.demand[v >> 3]) >> (v & 7) & 1u) << l;
            }
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
        FeatureBest<V> best = nearest_feature(*scratch, quarter, p);
        if ((bits(best.tied) & lanes) != 0) break_ties(*scratch, quarter, p, &best);
        scratch->counts->triangle_tests += int64_t{features} * kParts;
        write_packet(scratch->answers.data, best, lanes, radius2, in.shape->voxel + packet * 8,
                     answer);
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

/// The box of the sub-blocks in `subs`.
inline BoxOfPoints box_around(const KernelInput& in, const Vec3i& block, uint32_t subs) {
    int32_t low[3] = {8, 8, 8}, high[3] = {0, 0, 0};
    for (uint32_t left = subs; left != 0; left &= left - 1) {
        const int32_t* origin = in.shape->sub_origin[__builtin_ctz(left)];
        for (int a = 0; a < 3; ++a) {
            const int32_t end = origin[a] + in.shape->sub_size[a];
            low[a] = origin[a] < low[a] ? origin[a] : low[a];
            high[a] = high[a] < end ? end : high[a];
        }
    }
    const int32_t lowest[3] = {block.x + low[0], block.y + low[1], block.z + low[2]};
    const int32_t size[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
    return make_box(in, lowest, size);
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
    // Four corners of the eight tell nearly as much; where the last block was left with many leaves,
    // the others are worth their tests, too.
    constexpr uint32_t kFour = 1u << 0 | 1u << 3 | 1u << 5 | 1u << 6;
    constexpr size_t kManyLeaves = 128;
    const bool enough = (corners.found & kFour) == kFour && scratch->list.size < kManyLeaves;
    for (uint32_t c = enough ? kFour : corners.found; c != 0; c &= c - 1) {
        const int i = __builtin_ctz(c);
        add_point_row(box, corners.x[i], corners.y[i], corners.z[i], &rows);
    }
    add_radius_row(box, q.radius_mm, &rows);
    const float farthest2 = farthest_row2(rows);
    scratch->list.size = 0;
    collect({&in.root, 0}, box.corner, 0.0f, true, &rows, scratch);
    const BlockPlace place = make_place(in, q.block, farthest2, box.delta);
    collect_features(place, subs, scratch);
    if (scratch->answers.size == 0) return;
    list_near_features(place, quarters, scratch);
    query_quarters(in, q, quarters, asked, scratch, answer);
}
