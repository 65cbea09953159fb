// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What can be said of a whole cube of voxels. Part of kernel.inl.

/// Farthest distance² from each point to the node's box.
OPENFAB_INLINE F8 node_far2(const Node& n, const Points& p) {
    F8 sum;
    for (int k = 0; k < 3; ++k) {
        const F8 u =
            dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), p.x, p.y, p.z);
        const F8 d = absolute(u - set1(n.center[k])) + set1(n.half[k]);
        sum = k == 0 ? d * d : sum + d * d;
    }
    return sum;
}

/// Upper bounds of the distance at the corners without dicing: exact over triangles, and over
/// patches the far end of their boxes.
struct CubeUpper {
    F8 distance2;
    const Node* node[8];  ///< patch box that gave it, or null where a triangle did
};

inline void find_upper(const KernelInput& in, const Points& p, KernelScratch* scratch, Witnesses* w,
                       CubeUpper* upper) {
    scratch->stack.size = 0;
    scratch->stack.push({&in.root, 0});
    for (auto& node : upper->node)
        node = nullptr;
    while (scratch->stack.size != 0) {
        const Entry e = scratch->stack.data[--scratch->stack.size];
        const Node& node = e.tree->nodes[e.node];
        if (bits(node_distance2(node, p) < upper->distance2 - w->enough) == 0) continue;
        if (!node.is_leaf()) {
            const F8 bar = upper->distance2 - w->enough;
            F8 of_child[kMaxChildren];
            const uint32_t near = test_children(*e.tree, node, p, bar, of_child);
            const uint32_t child = node.child(), nearest = nearest_child(of_child);
            each_other_child(
                near, nearest, [&](uint32_t i) __attribute__((always_inline)) {
                    scratch->stack.push({e.tree, child + i});
                });
            if ((near >> nearest & 1u) != 0) scratch->stack.push({e.tree, child + nearest});
            continue;
        }
        if (is_chunk(scratch->patches, node)) {
            const TreeView* chunk = scratch->patches.fetch(scratch->patches.context,
                                                           static_cast<int32_t>(node.first()));
            if (chunk->nodes != nullptr) scratch->stack.push({chunk, 0});
            continue;
        }
        if (node.count() == 0) {
            const F8 far2 = node_far2(node, p);
            const M8 closer = far2 < upper->distance2;
            upper->distance2 = select(closer, far2, upper->distance2);
            const uint32_t mask = bits(closer);
            for (int l = 0; l < 8; ++l) {
                if ((mask >> l & 1u) != 0) upper->node[l] = &node;
            }
            continue;
        }
        for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
            offer_triangle(e.tree->frames[i], e.tree->details[i], p, w);
        }
        const M8 closer = w->distance2 < upper->distance2;
        upper->distance2 = select(closer, w->distance2, upper->distance2);
        const uint32_t mask = bits(closer);
        for (int l = 0; l < 8; ++l) {
            if ((mask >> l & 1u) != 0) upper->node[l] = nullptr;
        }
    }
}

/// Least squared distances of a node of the cut; of its triangles where it is a leaf, because the
/// box of a large slanted triangle says little.
struct CutDistance {
    float center2, corner2;
    bool dominated;
};

CutDistance cut_distance(const Entry& e, const Points& middle, const Points& corner,
                         Domination* rows) {
    const Node& node = e.tree->nodes[e.node];
    CutDistance d{kInfinity, kInfinity, true};
    if (!node.is_leaf() || node.count() == 0) {
        return {least_lane(node_distance2(node, middle)), least_lane(node_distance2(node, corner)),
                false};
    }
    for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
        const TriangleFrame& t = e.tree->frames[i];
        if (dominated(lower_bound(to_frame(t, corner)), rows)) continue;
        d.dominated = false;
        const float center2 = least_lane(lower_bound(to_frame(t, middle)));
        const float corner2 = least_lane(lower_bound(to_frame(t, corner)));
        d.center2 = center2 < d.center2 ? center2 : d.center2;
        d.corner2 = corner2 < d.corner2 ? corner2 : d.corner2;
    }
    return d;
}

/// Squared distance between the node's box and the box around the corners in the node's axes. For a
/// large flat node beside a flat cube it is exact, where the centre's distance less half the
/// diagonal tells little.
float separation2(const Node& n, const Points& corner) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) {
        const F8 u = dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), corner.x,
                          corner.y, corner.z) -
                     set1(n.center[k]);
        const float above = least_lane(u) - n.half[k];
        const float below = least_lane(set1(0.0f) - u) - n.half[k];
        const float gap = larger(larger(above, below), 0.0f);
        sum += gap * gap;
    }
    return sum;
}

float cube(const KernelInput& in, const Vec3i& lowest, int32_t size, KernelScratch* scratch) {
    scratch->list.size = 0;
    scratch->list_least.size = 0;
    if (in.root.nodes == nullptr) return kInfinity;
    const int32_t low[3] = {lowest.x, lowest.y, lowest.z};
    const int32_t sizes[3] = {size, size, size};
    const BoxOfPoints box = make_box(in, low, sizes);
    Witnesses w{set1(kInfinity), set1(0), set1(0), set1(0), 0, witness_tolerance(box)};
    CubeUpper upper{set1(kInfinity), {}};
    find_upper(in, box.corner, scratch, &w, &upper);

    Domination rows;
    make_rows(box, w, &rows);
    float hi2 = kInfinity;
    for (int i = 0; i < rows.rows; ++i) {
        const float far2 = largest_lane(load(rows.row[i]));
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    // Any point of a patch's box may be the one that is on the surface: the row is the farthest of
    // them at each corner.
    for (int l = 0; l < 8; ++l) {
        bool fresh = upper.node[l] != nullptr;
        for (int j = 0; j < l; ++j)
            fresh = fresh && upper.node[j] != upper.node[l];
        if (!fresh) continue;
        const F8 row = with_slack(node_far2(*upper.node[l], box.corner), box.delta);
        store(rows.row[rows.rows++], row);
        const float far2 = largest_lane(row);
        hi2 = far2 < hi2 ? far2 : hi2;
    }
    const float stop = 0.5f * box.half_diagonal;
    scratch->stack.push({&in.root, 0});
    collect(box, stop * stop, false, nullptr, &rows, scratch);

    alignas(32) float center[3];
    center[0] = largest_lane(box.corner.x) * 0.5f - largest_lane(set1(0.0f) - box.corner.x) * 0.5f;
    center[1] = largest_lane(box.corner.y) * 0.5f - largest_lane(set1(0.0f) - box.corner.y) * 0.5f;
    center[2] = largest_lane(box.corner.z) * 0.5f - largest_lane(set1(0.0f) - box.corner.z) * 0.5f;
    const Points middle{set1(center[0]), set1(center[1]), set1(center[2])};
    size_t kept = 0;
    for (size_t i = 0; i < scratch->list.size; ++i) {
        const Entry e = scratch->list.data[i];
        const CutDistance d = cut_distance(e, middle, box.corner, &rows);
        if (d.dominated) continue;
        scratch->list.data[kept++] = e;
        // From the centre no voxel is farther than half the diagonal, and each has a corner within
        // it.
        const float least2 = larger(d.center2, d.corner2);
        const float ball = __builtin_sqrtf(least2) * (1.0f - 0x1p-18f) - box.half_diagonal;
        const float gap =
            __builtin_sqrtf(separation2(e.tree->nodes[e.node], box.corner)) * (1.0f - 0x1p-18f);
        scratch->list_least.push(larger(larger(ball, gap) - 2 * box.delta, 0.0f));
    }
    scratch->list.size = kept;
    return __builtin_sqrtf(hi2) * kSlack + box.delta;
}
