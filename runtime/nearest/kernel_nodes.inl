// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Nodes against boxes of points, a node a lane. Part of kernel.inl.

/// The boxes of nodes, float by float as Node has them.
template <typename V>
struct BoxesOf {
    V axis[3][3], center[3], half[3], link;
};
static_assert(offsetof(Node, center) == 9 * sizeof(float) && sizeof(Node) == 16 * sizeof(float));

/// The nodes of `count` entries, no more than lanes; those that are over repeat the first.
template <typename V>
OPENFAB_INLINE BoxesOf<V> load_boxes(const Entry* entries, size_t count) {
    const float* rows[V::kLanes];
    for (size_t l = 0; l < V::kLanes; ++l) {
        const Entry& e = entries[l < count ? l : 0];
        rows[l] = reinterpret_cast<const float*>(e.tree->nodes + e.node);
    }
    BoxesOf<V> boxes;
    transpose(rows, 0, &boxes.axis[0][0]);
    return boxes;
}

/// From the middle of a box to its corners, bits 0 to 2 the upper end of its axes.
template <typename V>
OPENFAB_INLINE void corners_of(V middle, const V* half, V* at) {
    at[0] = middle;
    for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < 1 << a; ++i) {
            at[i + (1 << a)] = at[i] + half[a];
            at[i] = at[i] - half[a];
        }
    }
}

/// Adds the square of how far `at` is outside of the box along its axis k.
template <typename V>
OPENFAB_INLINE void add_outside2(const BoxesOf<V>& boxes, int k, V at, V* distance2) {
    const V d = max(absolute(at) - boxes.half[k], splat<V>(0.0f));
    *distance2 = about_mul_add(d, d, *distance2);
}

/// Squared distances of each box of `boxes` to the corners of a box of points.
template <typename V>
OPENFAB_INLINE void corner_distances2(const BoxesOf<V>& boxes, const BoxOfPoints& box,
                                      V* distance2) {
    for (int c = 0; c < 8; ++c)
        distance2[c] = splat<V>(0.0f);
    for (int k = 0; k < 3; ++k) {
        const V* axis = boxes.axis[k];
        V half[3], at[8];
        for (int a = 0; a < 3; ++a)
            half[a] = about_dot(axis, box.half[a], splat<V>(0.0f));
        corners_of(about_dot(axis, box.middle, splat<V>(0.0f) - boxes.center[k]), half, at);
        for (int c = 0; c < 8; ++c)
            add_outside2(boxes, k, at[c], distance2 + c);
    }
}

/// Lanes whose distances to the corners are dominated.
template <typename V>
OPENFAB_INLINE uint32_t dominated_lanes(const V* distance2, const Domination& d) {
    constexpr uint32_t kAll = (1u << V::kLanes) - 1;
    uint32_t lanes = 0;
    for (int i = 0; i < d.rows && lanes != kAll; ++i) {
        auto beyond = splat<V>(d.row[i][0]) < distance2[0];
        for (int c = 1; c < 8; ++c)
            beyond = beyond & (splat<V>(d.row[i][c]) < distance2[c]);
        lanes |= bits(beyond);
    }
    return lanes;
}

/// Puts the children of what `e` stands for behind the stack, or `e` itself on the list: nodes that
/// are small enough, and leaves; a patch's or a chunk's only where it is not `open`ed.
OPENFAB_INLINE void open_node(Entry e, bool small, bool open, const BoxOfPoints& box,
                              Domination* rows, KernelScratch* scratch) {
    const Node& node = e.tree->nodes[e.node];
    if (node.is_leaf() && node.count() == 0 && open) {
        const Node* known = known_box(scratch->patches, node);
        if (known != nullptr && dominated(node_distance2(*known, box.corner), rows)) return;
        const TreeView* patch =
            scratch->patches.fetch(scratch->patches.context, static_cast<int32_t>(node.first()));
        if (patch->nodes != nullptr) scratch->stack.push({patch, 0});
    } else if (node.is_leaf() || small) {
        scratch->list.push(e);
    } else {
        const size_t size = scratch->stack.size;
        scratch->stack.reserve(size + kMaxChildren);
        for (uint32_t i = 0; i < kMaxChildren; ++i) {
            __builtin_prefetch(e.tree->nodes + node.child() + i);
            scratch->stack.data[size + i] = {e.tree, node.child() + i};
        }
        scratch->stack.size = size + node.children();
    }
}

/// Appends to the list what is not dominated below the entries on the stack: nodes no larger than
/// `stop2` (squared half diagonal) and leaves. Patches are diced, or stand for themselves, as
/// chunks that are no larger then do. Breadth first, so that there are always many to test, and
/// their children are on their way from memory meanwhile.
__attribute__((noinline)) void collect(const BoxOfPoints& box, float stop2, bool dice,
                                       Domination* rows, KernelScratch* scratch) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes;
    for (size_t first = 0; first < scratch->stack.size;) {
        const size_t left = scratch->stack.size - first;
        const size_t count = left < kLanes ? left : kLanes;
        const auto boxes = load_boxes<V>(scratch->stack.data + first, count);
        V distance2[8];
        corner_distances2(boxes, box, distance2);
        const V* half = boxes.half;
        const V size2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
        const uint32_t small = bits(size2 <= splat<V>(stop2));
        uint32_t kept = ~dominated_lanes(distance2, *rows) & ((1u << count) - 1);
        scratch->counts->node_tests += static_cast<int64_t>(count);
        for (; kept != 0; kept &= kept - 1) {
            const auto l = static_cast<size_t>(__builtin_ctz(kept));
            const Entry e = scratch->stack.data[first + l];
            const bool is_small = (small >> l & 1u) != 0;
            const Node& node = e.tree->nodes[e.node];
            const bool open = dice || (!is_small && is_chunk(scratch->patches, node));
            open_node(e, is_small, open, box, rows, scratch);
        }
        first += count;
    }
    scratch->stack.size = 0;
}

// Lists of leaves for sub-blocks. Corners of the whole block tell little of what is nearest in the
// middle of its sides: half of what they leave is in reach of no voxel. So each sub-block gets
// witnesses of its own, from what the block's list holds.

/// Lists no longer than that are not narrowed: it costs what it saves (bench/README.md).
constexpr size_t kFewLeaves = 96;
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
            corner_distances2(boxes, sub_box[sub], distance2);
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
