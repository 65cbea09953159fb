// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Points anywhere, 8 at a time: one walk down the hierarchy for a packet, each lane with its own
// limit. Part of kernel.inl.

/// A packet and what its walk keeps.
struct PointPacket {
    Points p;
    F8 delta;  ///< as in kernel.inl; a far lane does not loosen the others
    PacketBest best;
    F8 winner;  ///< as bits: place in KernelScratch::triangles
};

OPENFAB_INLINE void try_leaf(const TreeView& tree, const Node& node, KernelScratch* scratch,
                             PointPacket* packet) {
    for (uint32_t i = node.first(); i < node.first() + node.count(); ++i) {
        const InFrame f = to_frame(tree.frames[i], packet->p);
        const uint32_t near = bits(lower_bound(f) <= packet->best.limit);
        if (near == 0) continue;
        const TriangleRef ref{tree.frames + i, tree.details + i};
        const M8 better = improve(ref, f, near, packet->p, packet->delta, &packet->best);
        if (bits(better) == 0) continue;
        const auto place = static_cast<int32_t>(scratch->triangles.size);
        packet->winner = select(better, set1_bits(place), packet->winner);
        scratch->triangles.push(ref);
    }
    scratch->counts->triangle_tests += node.count();
}

/// Nodes wait on the stack with their distances in list_distance2, place for place.
__attribute__((noinline)) void search_points(const KernelInput& in, KernelScratch* scratch,
                                             PointPacket* packet) {
    scratch->stack.size = scratch->list_distance2.size = 0;
    const auto wait = [&](const Entry& e, F8 distance2) {
        scratch->stack.push(e);
        scratch->list_distance2.reserve(scratch->stack.size);
        store(scratch->list_distance2.data[scratch->stack.size - 1].v, distance2);
    };
    wait({&in.root, 0}, node_distance2(in.root.nodes[0], packet->p));
    while (scratch->stack.size != 0) {
        const size_t top = --scratch->stack.size;
        const Entry e = scratch->stack.data[top];
        if (bits(load(scratch->list_distance2.data[top].v) <= packet->best.limit) == 0) continue;
        const TreeView* tree = e.tree;
        const Node* node = tree->nodes + e.node;
        while (node != nullptr) {
            if (node->is_leaf() && node->count() == 0) {
                const Node* box = known_box(scratch->patches, *node);
                if (box != nullptr &&
                    bits(node_distance2(*box, packet->p) <= packet->best.limit) == 0)
                    break;
                tree = scratch->patches.fetch(scratch->patches.context,
                                              static_cast<int32_t>(node->first()));
                node = tree->nodes;
                continue;
            }
            if (node->is_leaf()) {
                try_leaf(*tree, *node, scratch, packet);
                break;
            }
            const Node* left = tree->nodes + node->child();
            const F8 dl = node_distance2(left[0], packet->p);
            const F8 dr = node_distance2(left[1], packet->p);
            scratch->counts->node_tests += 2;
            const uint32_t go_left = bits(dl <= packet->best.limit);
            const uint32_t go_right = bits(dr <= packet->best.limit);
            if (go_left != 0 && go_right != 0) {
                const bool right_first = __builtin_popcount(bits(dr < dl)) > 4;
                wait({tree, node->child() + (right_first ? 0u : 1u)}, right_first ? dl : dr);
                node = left + (right_first ? 1 : 0);
            } else {
                node = go_left != 0 ? left : go_right != 0 ? left + 1 : nullptr;
            }
        }
    }
}

/// The surface points that the lanes found are near those of the next packet.
OPENFAB_INLINE void keep_warm_points(const PointPacket& packet, uint32_t found,
                                     KernelScratch* scratch) {
    alignas(32) int32_t winner[8];
    alignas(32) float b1[8], b2[8];
    store_bits(winner, packet.winner);
    store(b1, packet.best.bary1);
    store(b2, packet.best.bary2);
    WarmStart& warm = scratch->warm_points;
    warm.count = 0;
    for (int l = 0; l < 8; ++l) {
        if ((found >> l & 1u) == 0) continue;
        const TriangleRef& t = scratch->triangles.data[winner[l]];
        for (int a = 0; a < 3; ++a) {
            const float v0 = t.frame->v0[a];
            warm.point[a][warm.count] =
                v0 + (b1[l] * (t.detail->v1[a] - v0) + b2[l] * (t.detail->v2[a] - v0));
        }
        ++warm.count;
    }
}

/// Squared distance to the nearest of the warm points: the answer is no farther.
OPENFAB_INLINE F8 warm_distance2(const WarmStart& warm, const Points& p, F8 start2) {
    for (int i = 0; i < warm.count; ++i) {
        const F8 dx = p.x - set1(warm.point[0][i]), dy = p.y - set1(warm.point[1][i]),
                 dz = p.z - set1(warm.point[2][i]);
        start2 = min(start2, dot3(dx, dy, dz, dx, dy, dz));
    }
    return start2;
}

OPENFAB_INLINE void write_points(const PacketBest& best, uint32_t found, PointAnswer* answer) {
    const M8 mask = mask_of(found);
    store(answer->distance2, select(mask, best.distance2, set1(kInfinity)));
    store_bits(answer->patch, select(mask, best.patch, set1_bits(-1)));
    store_bits(answer->triangle, select(mask, best.triangle, set1(0.0f)));
    store(answer->bary1, select(mask, best.bary1, set1(0.0f)));
    store(answer->bary2, select(mask, best.bary2, set1(0.0f)));
}

void points(const KernelInput& in, const PointGroup* groups, size_t count, float radius,
            KernelScratch* scratch, PointAnswer* answers) {
    const F8 radius2 = set1(radius < kInfinity ? radius * radius : kInfinity);
    for (size_t g = 0; g < count; ++g) {
        PointPacket packet;
        packet.p = {load(groups[g].p[0]), load(groups[g].p[1]), load(groups[g].p[2])};
        const Points& p = packet.p;
        const F8 ax = absolute(p.x), ay = absolute(p.y), az = absolute(p.z);
        const F8 infinity = set1(kInfinity);
        const F8 far = set1(kFarthestPoint);
        const M8 finite = (ax < far) & (ay < far) & (az < far);
        const uint32_t asked = in.root.nodes == nullptr ? 0 : groups[g].mask & bits(finite);
        packet.delta = max(max(max(ax, ay), az), set1(in.largest_coordinate)) * set1(0x1p-19f);
        const F8 start2 = warm_distance2(scratch->warm_points, p, radius2);
        packet.best = empty_packet(asked, start2, packet.delta);
        packet.winner = set1_bits(0);
        scratch->triangles.size = 0;
        if (asked != 0) search_points(in, scratch, &packet);
        const F8 d2 = packet.best.distance2;
        const uint32_t found = asked & bits((d2 <= radius2) & (d2 < infinity));
        write_points(packet.best, found, answers + g);
        if (found != 0) keep_warm_points(packet, found, scratch);
    }
}
