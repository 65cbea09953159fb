// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lists of leaves for the sub-blocks of a deep block. Part of kernel.inl.
//
// Corners of the whole block tell little of what is nearest in the middle of its sides: half of
// what they leave is in reach of no voxel. So each sub-block gets witnesses of its own, from what
// the block's list holds.

/// Lists no longer than that are not narrowed: it costs what it saves (docs/measurements).
constexpr size_t kFewLeaves = 56;
/// Of the corners of a box, four tell nearly as much as eight.
constexpr int kFour[4] = {0, 3, 5, 6};
constexpr uint32_t kFourCorners = 1u << kFour[0] | 1u << kFour[1] | 1u << kFour[2] | 1u << kFour[3];

/// The nearest leaves of the list to four corners of sub-blocks, each lane those that it has seen.
template <typename V>
struct NearestLeaves {
    V distance2[8][4], place[8][4];  ///< places in the list, as bits
};

/// Squared distances of the list's leaves to the corners of the sub-blocks in `subs`, a leaf a
/// lane: list_distance2[(vector * 8 + sub) * 8 + corner].
template <typename V>
OPENFAB_INLINE void measure_leaves(const BoxOfPoints* sub_box, uint32_t subs,
                                   KernelScratch* scratch, NearestLeaves<V>* nearest) {
    constexpr size_t kLanes = V::kLanes;
    const size_t count = scratch->list.size;
    scratch->list_distance2.reserve((count + kLanes) / kLanes * 64);
    for (int sub = 0; sub < 8; ++sub) {
        for (int i = 0; i < 4; ++i) {
            nearest->distance2[sub][i] = splat<V>(kInfinity);
            nearest->place[sub][i] = Width<V>::splat_bits(0);
        }
    }
    alignas(64) int32_t places_of[kLanes];
    for (size_t first = 0; first < count; first += kLanes) {
        for (size_t l = 0; l < kLanes; ++l)
            places_of[l] = static_cast<int32_t>(first + l < count ? first + l : first);
        const V place = Width<V>::load(reinterpret_cast<const float*>(places_of));
        const auto boxes = load_boxes<V>(scratch->list.data + first, count - first);
        Lanes* out = scratch->list_distance2.data + first / kLanes * 64;
        for (uint32_t left = subs; left != 0; left &= left - 1) {
            const int sub = __builtin_ctz(left);
            V distance2[8];
            corner_distances2(boxes, box_along(boxes, sub_box[sub]), distance2);
            for (int c = 0; c < 8; ++c)
                store(out[sub * 8 + c].v, distance2[c]);
            for (int i = 0; i < 4; ++i) {
                V& least = nearest->distance2[sub][i];
                const V d2 = distance2[kFour[i]];
                const auto closer = d2 < least;
                least = min(d2, least);
                nearest->place[sub][i] = select(closer, place, nearest->place[sub][i]);
            }
        }
    }
}

/// What `of` holds, as bits, in the lane with the least value.
template <typename V>
OPENFAB_INLINE int32_t at_least_lane(V value, V of) {
    alignas(64) float v[V::kLanes];
    alignas(64) int32_t o[V::kLanes];
    store(v, value);
    store_bits(o, of);
    for (int half = V::kLanes / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; ++l) {
            o[l] = v[l + half] < v[l] ? o[l + half] : o[l];
            v[l] = v[l + half] < v[l] ? v[l + half] : v[l];
        }
    }
    return o[0];
}

/// A triangle's corners are witnesses enough where triangles are small beside the box.
OPENFAB_INLINE void offer_corners(const TriangleFrame& t, const TriangleDetail& d, const Points& p,
                                  Witnesses* w) {
    offer_point(t.v0[0], t.v0[1], t.v0[2], p, w);
    offer_point(d.v1[0], d.v1[1], d.v1[2], p, w);
    offer_point(d.v2[0], d.v2[1], d.v2[2], p, w);
}

/// Rows for sub-block `sub`, whose box is `box`, from the leaves nearest to its corners.
template <typename V>
OPENFAB_INLINE void make_sub_rows(const BoxOfPoints& box, int sub, float radius,
                                  const NearestLeaves<V>& nearest, KernelScratch* scratch,
                                  Domination* rows) {
    Witnesses w{set1(kInfinity), set1(0), set1(0), set1(0), 0, set1(0)};
    int32_t leaf[4];
    for (int i = 0; i < 4; ++i) {
        leaf[i] = at_least_lane(nearest.distance2[sub][i], nearest.place[sub][i]);
        bool seen = false;
        for (int j = 0; j < i; ++j)
            seen |= leaf[j] == leaf[i];
        if (seen) continue;
        const Entry& e = scratch->list.data[leaf[i]];
        const Node& node = e.tree->nodes[e.node];
        for (uint32_t t = node.first(); t < node.first() + node.count(); ++t)
            offer_corners(e.tree->frames[t], e.tree->details[t], box.corner, &w);
    }
    w.found &= kFourCorners;
    make_rows(box, w, rows);
    add_radius_row(box, radius, rows);
}

/// Keeps on the list what may be nearest to a voxel of a sub-block in `subs`; list_subs says of
/// which.
__attribute__((noinline)) void narrow_to_sub_blocks(const KernelInput& in, const BlockQuery& q,
                                                    uint32_t subs, KernelScratch* scratch) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes;
    const size_t count = scratch->list.size;
    scratch->list_subs.reserve(count + 32);
    uint8_t* const mask = scratch->list_subs.data;
    if (count < kFewLeaves) {
        for (size_t i = 0; i < count; ++i)
            mask[i] = static_cast<uint8_t>(subs);
        return;
    }
    BoxOfPoints sub_box[8];
    for (uint32_t left = subs; left != 0; left &= left - 1)
        sub_box[__builtin_ctz(left)] = box_around(in, q.block, left & (0u - left));
    NearestLeaves<V> nearest;
    measure_leaves(sub_box, subs, scratch, &nearest);
    for (size_t i = 0; i < count + 32; ++i)
        mask[i] = 0;
    for (uint32_t left = subs; left != 0; left &= left - 1) {
        const int sub = __builtin_ctz(left);
        Domination rows;
        make_sub_rows(sub_box[sub], sub, q.radius_mm, nearest, scratch, &rows);
        for (size_t first = 0; first < count; first += kLanes) {
            const Lanes* in = scratch->list_distance2.data + first / kLanes * 64 + sub * 8;
            V distance2[8];
            for (int c = 0; c < 8; ++c)
                distance2[c] = Width<V>::load(in[c].v);
            const uint32_t kept = ~dominated_lanes(distance2, rows);
            add_bit<V>(kept, sub, mask + first);
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        scratch->list.data[kept] = scratch->list.data[i];
        mask[kept] = mask[i];
        kept += mask[i] != 0 ? 1 : 0;
    }
    scratch->list.size = kept;
}
