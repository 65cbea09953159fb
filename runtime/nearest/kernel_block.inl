// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocks of 8 x 8 x 8 voxels. Part of kernel.inl.

OPENFAB_INLINE Points voxel_centres(const KernelInput& in, const Vec3i& block,
                                    const int32_t* origin) {
    const float* f = in.frame;
    const BlockShape& s = *in.shape;
    const F8 half = set1(0.5f);
    const F8 x = set1(static_cast<float>(block.x + origin[0])) + load(s.lane_offset[0]) + half;
    const F8 y = set1(static_cast<float>(block.y + origin[1])) + load(s.lane_offset[1]) + half;
    const F8 z = set1(static_cast<float>(block.z + origin[2])) + load(s.lane_offset[2]) + half;
    F8 c[3];
    for (int a = 0; a < 3; ++a) {
        c[a] = dot3(x, y, z, set1(f[OPENFAB_FRAME_STEP_I + a]), set1(f[OPENFAB_FRAME_STEP_J + a]),
                    set1(f[OPENFAB_FRAME_STEP_K + a])) +
               set1(f[OPENFAB_FRAME_ORIGIN + a]);
    }
    return {c[0], c[1], c[2]};
}

OPENFAB_INLINE uint32_t demanded(const uint8_t* demand, const int16_t* voxel) {
    if (demand == nullptr) return 0xff;
    uint32_t mask = 0;
    for (int l = 0; l < 8; ++l) {
        mask |= (static_cast<uint32_t>(demand[voxel[l] >> 3]) >> (voxel[l] & 7) & 1u) << l;
    }
    return mask;
}

OPENFAB_INLINE void write_packet(const PacketBest& best, uint32_t asked, float radius2,
                                 const int16_t* voxel, BlockAnswer* answer) {
    alignas(32) float d2[8], b1[8], b2[8];
    alignas(32) int32_t patch[8], triangle[8];
    store(d2, best.distance2);
    store(b1, best.bary1);
    store(b2, best.bary2);
    store_bits(patch, best.patch);
    store_bits(triangle, best.triangle);
    for (int l = 0; l < 8; ++l) {
        if ((asked >> l & 1u) == 0 || !(d2[l] <= radius2) || d2[l] == kInfinity) continue;
        const int v = voxel[l];
        answer->distance2[v] = d2[l];
        answer->patch[v] = patch[l];
        answer->triangle[v] = triangle[l];
        answer->bary1[v] = b1[l];
        answer->bary2[v] = b2[l];
    }
}

void query_packets(const KernelInput& in, const BlockQuery& q, int sub, float delta,
                   KernelScratch* scratch, BlockAnswer* answer) {
    const BlockShape& shape = *in.shape;
    const TriangleRef* refs = scratch->triangles.data;
    const size_t count = scratch->triangles.size;
    // A lane starts from the radius: what is farther cannot be the answer.
    const float start = q.radius_mm < kInfinity ? q.radius_mm * q.radius_mm : kInfinity;
    // Three more bounds, so that they can be read by fours.
    scratch->framed.reserve(4 * count);
    scratch->bounds.reserve(count + 3);
    for (size_t i = count; i < count + 3; ++i)
        store(scratch->bounds.data[i].v, set1(kInfinity));
    for (int packet = sub * 8; packet < sub * 8 + 8; ++packet) {
        const int16_t* voxel = shape.voxel + packet * 8;
        const uint32_t asked = demanded(q.demand, voxel);
        if (asked == 0) continue;
        const Points p = voxel_centres(in, q.block, shape.packet_origin[packet]);
        PacketBest best = empty_packet(asked, set1(start), set1(delta));
        query_packet(refs, count, p, asked, delta, scratch, &best);
        scratch->counts->triangle_tests += static_cast<int64_t>(count);
        write_packet(best, asked, start, voxel, answer);
    }
}

bool any_demanded(const KernelInput& in, const BlockQuery& q, int sub) {
    if (q.demand == nullptr) return true;
    for (int packet = sub * 8; packet < sub * 8 + 8; ++packet) {
        if (demanded(q.demand, in.shape->voxel + packet * 8) != 0) return true;
    }
    return false;
}

__attribute__((noinline)) void query_sub_block(const KernelInput& in, const BlockQuery& q, int sub,
                                               const WarmStart& near, KernelScratch* scratch,
                                               BlockAnswer* answer) {
    const int32_t* origin = in.shape->sub_origin[sub];
    const int32_t lowest[3] = {q.block.x + origin[0], q.block.y + origin[1], q.block.z + origin[2]};
    const BoxOfPoints box = make_box(in, lowest, in.shape->sub_size);
    Witnesses w{set1(kInfinity), set1(0), set1(0), set1(0), 0, witness_tolerance(box)};
    for (int i = 0; i < near.count; ++i)
        offer_point(near.point[0][i], near.point[1][i], near.point[2][i], box.corner, &w);
    const size_t entries = scratch->list.size;
    scratch->list_distance2.reserve(entries);
    Lanes* distance2 = scratch->list_distance2.data;
    F8 least = set1(kInfinity), promising = set1_bits(0);
    for (size_t i = 0; i < entries; ++i) {
        const Entry& e = scratch->list.data[i];
        const F8 d2 = node_distance2(e.tree->nodes[e.node], box.corner);
        store(distance2[i].v, d2);
        promising = select(d2 < least, set1_bits(static_cast<int32_t>(i)), promising);
        least = min(least, d2);
    }
    alignas(32) int32_t first[8];
    store_bits(first, promising);
    for (int l = 0; l < 8; ++l) {
        const auto i = static_cast<size_t>(first[l]);
        if (bits(load(distance2[i].v) < w.distance2 - w.enough) == 0) continue;
        find_witnesses(scratch->list.data[i], box.corner, scratch, &w);
    }
    for (size_t i = 0; i < entries; ++i) {
        if (bits(load(distance2[i].v) < w.distance2 - w.enough) == 0) continue;
        find_witnesses(scratch->list.data[i], box.corner, scratch, &w);
    }
    scratch->counts->node_tests += static_cast<int64_t>(entries);
    Domination rows;
    make_rows(box, w, q.radius_mm, &rows);
    scratch->triangles.size = 0;
    for (size_t i = 0; i < entries; ++i) {
        collect_triangles(scratch->list.data[i], load(distance2[i].v), box.corner, &rows, scratch);
    }
    if (scratch->triangles.size != 0) query_packets(in, q, sub, box.delta, scratch, answer);
}

void keep_warm(const Witnesses& w, WarmStart* warm) {
    alignas(32) float x[8], y[8], z[8];
    store(x, w.x);
    store(y, w.y);
    store(z, w.z);
    warm->count = 0;
    for (int i = 0; i < 8; ++i) {
        if ((w.found >> i & 1u) == 0) continue;
        warm->point[0][warm->count] = x[i];
        warm->point[1][warm->count] = y[i];
        warm->point[2][warm->count] = z[i];
        ++warm->count;
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

void query(const KernelInput& in, const BlockQuery& q, KernelScratch* scratch,
           BlockAnswer* answer) {
    clear(answer);
    if (in.root.nodes == nullptr) return;
    const int32_t lowest[3] = {q.block.x, q.block.y, q.block.z};
    const int32_t size[3] = {8, 8, 8};
    const BoxOfPoints box = make_box(in, lowest, size);
    const float reach = q.radius_mm + 2 * box.half_diagonal;
    Witnesses w{set1(q.radius_mm < kInfinity ? reach * reach : kInfinity),
                set1(0),
                set1(0),
                set1(0),
                0,
                witness_tolerance(box)};
    const WarmStart& warm = scratch->warm;
    for (int i = 0; i < warm.count; ++i)
        offer_point(warm.point[0][i], warm.point[1][i], warm.point[2][i], box.corner, &w);
    const Entry root{&in.root, 0};
    scratch->stack.size = 0;
    find_witnesses(root, box.corner, scratch, &w);
    Domination rows;
    make_rows(box, w, q.radius_mm, &rows);
    scratch->list.size = 0;
    collect(root, box.corner, 0.0f, true, &rows, scratch);
    WarmStart near;
    keep_warm(w, &near);
    if (near.count != 0) scratch->warm = near;
    if (scratch->list.size == 0) return;
    for (int sub = 0; sub < 8; ++sub) {
        if (any_demanded(in, q, sub)) query_sub_block(in, q, sub, near, scratch, answer);
    }
}
