// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocks near the surface, packet by packet: against the leaves that may be nearest to its quarter
// of a sub-block by their normal cones (nearest/cones.h), or by a walk. Part of kernel.inl.

/// Blocks are near where what is nearest to them is no farther than this, in half diagonals of a
/// block, and searched as below where their triangles are dense: there they outnumber the voxels
/// that ask. Else taking triangles apart for all of those at once costs less (docs/measurements).
constexpr float kNear = 1.0f;
constexpr float kDense = 4.0f;  ///< half diagonals of a block in spacings of triangles
/// Nodes no larger than this, in half diagonals of the block, are where walks begin.
constexpr float kSearchFrom = 1.5f;

/// Whether triangles are dense where the list's entries are.
OPENFAB_INLINE bool is_dense(const KernelScratch& scratch, float half_diagonal) {
    for (size_t i = 0; i < scratch.list.size; ++i) {
        const float spacing = scratch.list.data[i].tree->spacing;
        if (spacing > 0) return half_diagonal > kDense * spacing;
    }
    return true;
}

/// Lists the leaves of the list once more with their cones, and for each of the `quarters` the
/// places there of what may be nearest to a voxel of it.
__attribute__((noinline)) void list_near_leaves(const BlockPlace& place, uint32_t quarters,
                                                KernelScratch* scratch) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes;
    const BlockShape& shape = *place.shape;
    const Entry* list = scratch->list.data;
    const size_t count = scratch->list.size;
    NearLeaves& out = scratch->near;
    out.leaves.reserve(count);
    out.stride = count + kLanes;
    out.places.reserve(kQuarters * out.stride);
    for (uint32_t& n : out.count)
        n = 0;
    const V zero = splat<V>(0.0f), reach2 = splat<V>(place.reach * place.reach);
    for (size_t first = 0; first < count; first += kLanes) {
        const size_t some = count - first < kLanes ? count - first : kLanes;
        const auto boxes = load_boxes<V>(list + first, some);
        const auto cones = load_cones<V>(list + first, some);
        // The tangent; where nothing is known, no limit.
        const auto known = cones.sine < splat<V>(1.0f);
        const V cosine2 = splat<V>(1.0f) - cones.sine * cones.sine;
        const V lean = select(known, cones.sine / sqrt(cosine2), zero);
        const V stray = select(known, stray_of(cones, place), splat<V>(kInfinity));
        alignas(64) float lean_of[kLanes], stray_of_lane[kLanes];
        store(lean_of, lean);
        store(stray_of_lane, stray);
        for (size_t l = 0; l < some; ++l)
            out.leaves.data[first + l] = {list[first + l], lean_of[l], stray_of_lane[l]};
        V of_sub[3][8], of_quarter[3][4], extent[3];
        for (int k = 0; k < 3; ++k) {
            Slope<V> s;
            s.middle = about_dot(boxes.axis[k], place.middle, zero - boxes.center[k]);
            for (int a = 0; a < 3; ++a)
                s.by[a] = about_dot(boxes.axis[k], place.step + 3 * a, zero);
            of_sub[k][0] = s.middle;
            middles_of<3>(s, shape.sub_axis, shape.sub_half, of_sub[k]);
            of_quarter[k][0] = zero;
            middles_of<2>(s, shape.quarter_axis, shape.quarter_half, of_quarter[k]);
            extent[k] = boxes.half[k] + (reach_of(s, shape.quarter_reach) + splat<V>(place.slack));
        }
        const V least_across = about_mul_add(lean, extent[2], stray);
        const uint32_t lanes = (1u << some) - 1;
        for (uint32_t left = quarters; left != 0; left &= left - 1) {
            const int quarter = __builtin_ctz(left);
            V u[3], d[3], sum = zero;
            for (int k = 0; k < 3; ++k) {
                u[k] = absolute(of_sub[k][quarter >> 2] + of_quarter[k][quarter & 3]);
                d[k] = max(u[k] - extent[k], zero);
                sum = about_mul_add(d[k], d[k], sum);
            }
            const V across = about_mul_add(u[2], lean, least_across);
            const uint32_t near = lanes & bits((max(d[0], d[1]) <= across) & (sum <= reach2));
            uint32_t* places = out.places.data + static_cast<size_t>(quarter) * out.stride;
            uint32_t& listed = out.count[quarter];
            listed += list_lanes<V>(near, static_cast<uint32_t>(first), places + listed);
        }
    }
}

/// Squared distance of each point to the leaf's box; infinite where it is in no normal cone.
template <typename V>
OPENFAB_INLINE V near_distance2(const NearLeaf& leaf, const PointsOf<V>& p) {
    const Node& n = leaf.entry.tree->nodes[leaf.entry.node];
    V u[3], d[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = along_axis(n, k, p);
        d[k] = max(u[k] - splat<V>(n.half[k]), splat<V>(0.0f));
    }
    const V across =
        about_mul_add(u[2] + splat<V>(n.half[2]), splat<V>(leaf.lean), splat<V>(leaf.stray));
    const V distance2 = about_mul_add(d[2], d[2], about_mul_add(d[1], d[1], d[0] * d[0]));
    return select(max(d[0], d[1]) <= across, distance2, splat<V>(kInfinity));
}

/// The voxels of `quarters` that ask: find(quarter, &search) for each of their packets.
template <typename V, typename Find>
OPENFAB_INLINE void query_packets(const KernelInput& in, const BlockQuery& q,
                                  const BlockPlace& place, uint32_t quarters, const uint8_t* asked,
                                  float delta, KernelScratch* scratch, BlockAnswer* answer,
                                  const Find& find) {
    constexpr int kParts = V::kLanes / 8;
    const V radius2 = splat<V>(q.radius_mm * q.radius_mm);
    const V reach2 = splat<V>(place.reach * place.reach);
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
            begin_search(lanes, warm_distance2(warm, s.p, reach2), splat<V>(delta), scratch, &s);
            find(quarter, &s);
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

/// Each packet against what is listed for its quarter.
__attribute__((noinline)) void query_near(const KernelInput& in, const BlockQuery& q,
                                          const BlockPlace& place, uint32_t quarters,
                                          const uint8_t* asked, float delta, KernelScratch* scratch,
                                          BlockAnswer* answer) {
    using V = Widest;
    const NearLeaves& near = scratch->near;
    query_packets<V>(
        in, q, place, quarters, asked, delta, scratch,
        answer, [&](int quarter, SearchOf<V>* s) __attribute__((always_inline)) {
            const uint32_t* places = near.places.data + static_cast<size_t>(quarter) * near.stride;
            const uint32_t count = near.count[quarter];
            ComingLeaf<V> coming;
            for (uint32_t i = 0; i < count; ++i) {
                const NearLeaf& leaf = near.leaves.data[places[i]];
                const V distance2 = near_distance2(leaf, s->p);
                if (any(distance2 <= s->limit)) coming.follow(leaf.entry, distance2, scratch, s);
            }
            coming.offer(scratch, s);
            scratch->counts->node_tests += int64_t{count} * V::kLanes / 8;
        });
}

/// Each packet by a walk below the entries of the list.
__attribute__((noinline)) void query_walks(const KernelInput& in, const BlockQuery& q,
                                           const BlockPlace& place, uint32_t quarters,
                                           const uint8_t* asked, float delta,
                                           KernelScratch* scratch, BlockAnswer* answer) {
    using V = Widest;
    query_packets<V>(
        in, q, place, quarters, asked, delta, scratch,
        answer, [&](int, SearchOf<V>* s) __attribute__((always_inline)) {
            search(scratch->list.data, scratch->list.size, scratch, s);
        });
}
