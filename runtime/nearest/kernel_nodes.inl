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

/// A box of points along the axes of nodes: its middle from theirs, and how far its ends are from
/// there.
template <typename V>
struct BoxAlong {
    V middle[3], half[3][3];
};
template <typename V>
OPENFAB_INLINE BoxAlong<V> box_along(const BoxesOf<V>& boxes, const BoxOfPoints& box) {
    BoxAlong<V> along;
    for (int k = 0; k < 3; ++k) {
        const V* axis = boxes.axis[k];
        along.middle[k] = about_dot(axis, box.middle, splat<V>(0.0f) - boxes.center[k]);
        for (int a = 0; a < 3; ++a)
            along.half[k][a] = about_dot(axis, box.half[a], splat<V>(0.0f));
    }
    return along;
}

/// Squared distances of each box of `boxes` to the corners of a box of points.
template <typename V>
OPENFAB_INLINE void corner_distances2(const BoxesOf<V>& boxes, const BoxAlong<V>& box,
                                      V* distance2) {
    for (int c = 0; c < 8; ++c)
        distance2[c] = splat<V>(0.0f);
    for (int k = 0; k < 3; ++k) {
        V at[8];
        corners_of(box.middle[k], box.half[k], at);
        for (int c = 0; c < 8; ++c)
            add_outside2(boxes, k, at[c], distance2 + c);
    }
}

/// The normal cones of nodes (nearest/cones.h).
template <typename V>
struct ConesOf {
    V sine, stray, stray_by_reach, longest_edge;
};
template <typename V>
OPENFAB_INLINE ConesOf<V> load_cones(const Entry* entries, size_t count) {
    alignas(64) float of[4][V::kLanes];
    for (size_t l = 0; l < V::kLanes; ++l) {
        const Entry& e = entries[l < count ? l : 0];
        const NodeCone& cone = e.tree->cones[e.node];
        of[0][l] = cone.sine;
        of[1][l] = cone.stray;
        of[2][l] = cone.stray_by_reach;
        of[3][l] = e.tree->longest_edge;
    }
    return {Width<V>::load(of[0]), Width<V>::load(of[1]), Width<V>::load(of[2]),
            Width<V>::load(of[3])};
}

/// How far a voxel may be off the normal cones of what it is nearest to, in float. Twice what
/// NodeCone says: along a cone it is as wrong as across.
template <typename V>
OPENFAB_INLINE V stray_of(const ConesOf<V>& cones, const BlockPlace& place) {
    const V rounded = (cones.longest_edge + splat<V>(place.reach)) * splat<V>(kRounded);
    const V x = min(splat<V>(place.excess), rounded);
    return about_mul_add(x + x, max(cones.stray, x * cones.stray_by_reach), splat<V>(place.slack));
}

/// Lanes that are out of the block's reach, or in whose normal cones no point of the box is.
template <typename V>
OPENFAB_INLINE uint32_t beside_lanes(const BoxesOf<V>& boxes, const BoxAlong<V>& box,
                                     const ConesOf<V>& cones, const BlockPlace& place) {
    V d[3], sum = splat<V>(0.0f);
    for (int k = 0; k < 3; ++k) {
        const V extent = (absolute(box.half[k][0]) + absolute(box.half[k][1])) +
                         (absolute(box.half[k][2]) + boxes.half[k]);
        d[k] = max(absolute(box.middle[k]) - extent, splat<V>(0.0f));
        sum = about_mul_add(d[k], d[k], sum);
    }
    const V across = about_mul_add(splat<V>(place.reach), cones.sine, stray_of(cones, place));
    const float far = place.reach + place.slack;
    return bits((across < max(d[0], d[1])) | (splat<V>(far * far) < sum));
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
        __builtin_prefetch(e.tree->leaves + e.node);
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

/// Appends to the list what is left below the entries on the stack: nodes no larger than `stop2`
/// (squared half diagonal) and leaves. What is left is not dominated; or, where `near` is a block's
/// place, in its reach and with a voxel of it in its normal cones: there witnesses tell little.
/// Patches are diced, or stand for themselves, as chunks that are no larger then do. Breadth first,
/// so that there are always many to test, and their children are on their way from memory
/// meanwhile.
__attribute__((noinline)) void collect(const BoxOfPoints& box, float stop2, bool dice,
                                       const BlockPlace* near, Domination* rows,
                                       KernelScratch* scratch) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes;
    for (size_t first = 0; first < scratch->stack.size;) {
        const size_t left = scratch->stack.size - first;
        const size_t count = left < kLanes ? left : kLanes;
        const Entry* entries = scratch->stack.data + first;
        const auto boxes = load_boxes<V>(entries, count);
        const auto along = box_along(boxes, box);
        uint32_t kept = (1u << count) - 1;
        if (near != nullptr) {
            kept &= ~beside_lanes(boxes, along, load_cones<V>(entries, count), *near);
        } else {
            V distance2[8];
            corner_distances2(boxes, along, distance2);
            kept &= ~dominated_lanes(distance2, *rows);
        }
        const V* half = boxes.half;
        const V size2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
        const uint32_t small = bits(size2 <= splat<V>(stop2));
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
