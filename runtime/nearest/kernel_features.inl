// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Faces, edges and vertices that may be nearest to a point of a box, and the voxels of the box
// against all of them without a branch. Part of kernel.inl.

/// How far something is from every corner of the box at most, squared.
OPENFAB_INLINE float farthest_row2(const Domination& rows) {
    float farthest2 = kInfinity;
    for (int i = 0; i < rows.rows; ++i) {
        const float far2 = largest_lane(load(rows.row[i]));
        farthest2 = far2 < farthest2 ? far2 : farthest2;
    }
    return farthest2;
}

// Which of a tree's features a leaf holds, and what is kept of one.

OPENFAB_INLINE const TriangleFrame* features_of(const TreeView& tree, const Node& leaf,
                                                const TriangleFrame** end) {
    *end = tree.frames + leaf.first() + leaf.count();
    return tree.frames + leaf.first();
}
OPENFAB_INLINE const EdgeFeature* features_of(const TreeView& tree, const Node& leaf,
                                              const EdgeFeature** end) {
    *end = tree.edges + tree.first_edge[leaf.first() + leaf.count()];
    return tree.edges + tree.first_edge[leaf.first()];
}
OPENFAB_INLINE const VertexFeature* features_of(const TreeView& tree, const Node& leaf,
                                                const VertexFeature** end) {
    *end = tree.vertices + tree.first_vertex[leaf.first() + leaf.count()];
    return tree.vertices + tree.first_vertex[leaf.first()];
}

OPENFAB_INLINE const TriangleDetail* owner_of(const TriangleFrame& f, const TreeView& tree) {
    return tree.details + (&f - tree.frames);
}
OPENFAB_INLINE const TriangleDetail* owner_of(const EdgeFeature& e, const TreeView& tree) {
    return tree.details + e.owner();
}
OPENFAB_INLINE const TriangleDetail* owner_of(const VertexFeature& v, const TreeView& tree) {
    return tree.details + v.owner();
}

/// Lists the features of one kind in the leaves of the list.
template <typename Feature>
OPENFAB_INLINE void list_candidates(KernelScratch* scratch) {
    size_t count = 0;
    for (size_t i = 0; i < scratch->list.size; ++i) {
        const Entry& e = scratch->list.data[i];
        const uint8_t subs = scratch->list_subs.data[i];
        const Feature* end;
        const Feature* f = features_of(*e.tree, e.tree->nodes[e.node], &end);
        // Always four at a time, whether there are as many or not: most leaves have about that.
        for (const auto left = static_cast<size_t>(end - f); f < end; f += 4) {
            scratch->rows.reserve(count + left + 4);
            scratch->trees.reserve(count + left + 4);
            scratch->subs.reserve(count + left + 4 + 16);
            store_four(scratch->rows.data + count, f, sizeof(Feature));
            store_four(scratch->trees.data + count, e.tree, 0);
            __builtin_memset(scratch->subs.data + count, subs, 4);
            count += static_cast<size_t>(end - f < 4 ? end - f : 4);
        }
    }
    scratch->rows.size = scratch->trees.size = count;
}

/// The features rows[0 .. lanes - 1], a lane each, float by float.
template <typename V, typename Feature>
OPENFAB_INLINE void load_features(const float* const* rows, V* columns) {
    for (size_t k = 0; k < sizeof(Feature) / sizeof(float); k += 16)
        transpose(rows, k, columns + k);
}

/// Keeps the features of one kind that are not idle in all sub-blocks of `subs`.
template <typename Feature>
OPENFAB_INLINE void collect_kind(const BlockPlace& place, uint32_t subs, KernelScratch* scratch,
                                 BlockFeatures* out) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes, kFloats = 16;
    list_candidates<Feature>(scratch);
    const size_t count = scratch->rows.size;
    // Lanes that are over repeat the first.
    scratch->rows.reserve(count + 3 * kLanes);
    const float** rows = scratch->rows.data;
    for (size_t l = 0; count != 0 && l < 3 * kLanes; ++l)
        rows[count + l] = rows[0];
    out->rows.reserve(count + kLanes);
    out->details.reserve(count);
    out->subs.reserve(count + kLanes);
    size_t kept = 0;
    for (size_t first = 0; first < count; first += kLanes) {
        for (size_t l = first + 2 * kLanes; l < first + 3 * kLanes; ++l) {
            __builtin_prefetch(rows[l]);
        }
        V columns[kFloats];
        transpose(rows + first, 0, columns);
        IdleInSubBlocks<V> idle(*place.shape);
        test_sides<kFirstSidesOf<Feature>>(static_cast<const Feature*>(nullptr), columns, place,
                                           &idle);
        uint32_t alive = idle.not_everywhere(subs, scratch->subs.data + first);
        alive &= (1u << (count - first < kLanes ? count - first : kLanes)) - 1;
        for (; alive != 0; alive &= alive - 1) {
            const auto l = static_cast<size_t>(__builtin_ctz(alive));
            const float* row = rows[first + l];
            const TriangleDetail* owner =
                owner_of(*reinterpret_cast<const Feature*>(row), *scratch->trees.data[first + l]);
            // list_answers will read it, and list_near all of the feature.
            __builtin_prefetch(&owner->patch);
            if (sizeof(Feature) > kFloats * sizeof(float)) __builtin_prefetch(row + kFloats);
            out->rows.data[kept] = row;
            out->details.data[kept] = owner;
            out->subs.data[kept] = scratch->subs.data[first + l];
            ++kept;
        }
    }
    for (size_t l = 0; kept != 0 && l < kLanes; ++l)
        out->rows.data[kept + l] = out->rows.data[0];
    out->rows.size = out->details.size = kept;
}

/// Lists in out->near what may be nearest to the voxels of each of the `quarters`.
template <typename Feature>
OPENFAB_INLINE void list_near(const BlockPlace& place, uint32_t quarters, BlockFeatures* out) {
    using V = Widest;
    constexpr size_t kLanes = V::kLanes;
    for (uint32_t& count : out->near_count)
        count = 0;
    const size_t count = out->rows.size;
    out->near_stride = count + kLanes;
    out->near.reserve(kQuarters * out->near_stride);
    for (size_t first = 0; first < count; first += kLanes) {
        V columns[sizeof(Feature) / sizeof(float)];
        load_features<V, Feature>(out->rows.data + first, columns);
        IdleInQuarters<V, kSidesOf<Feature>> idle(*place.shape);
        test_sides<kSidesOf<Feature>>(static_cast<const Feature*>(nullptr), columns, place, &idle);
        const uint32_t lanes = (1u << (count - first < kLanes ? count - first : kLanes)) - 1;
        for (int sub = 0; sub < 8; ++sub) {
            const uint32_t some = quarters >> 4 * sub & 0xfu;
            if (some == 0) continue;
            const uint32_t here = lanes & lanes_with_bit<V>(out->subs.data + first, sub);
            if (here == 0) continue;
            for (int q = 0; q < 4; ++q) {
                if ((some >> q & 1u) == 0) continue;
                const uint32_t alive = here & ~bits(idle.idle(sub, q));
                const int quarter = 4 * sub + q;
                uint32_t& listed = out->near_count[quarter];
                listed += list_lanes<V>(
                    alive, static_cast<uint32_t>(first),
                    out->near.data + static_cast<size_t>(quarter) * out->near_stride + listed);
            }
        }
    }
}

__attribute__((noinline)) void list_near_features(const BlockPlace& place, uint32_t quarters,
                                                  KernelScratch* scratch) {
    list_near<TriangleFrame>(place, quarters, &scratch->faces);
    list_near<EdgeFeature>(place, quarters, &scratch->edges);
    list_near<VertexFeature>(place, quarters, &scratch->vertices);
}

OPENFAB_INLINE const TriangleFrame& face_at(const KernelScratch& block, size_t i) {
    return *reinterpret_cast<const TriangleFrame*>(block.faces.rows.data[i]);
}
OPENFAB_INLINE const EdgeFeature& edge_at(const KernelScratch& block, size_t i) {
    return *reinterpret_cast<const EdgeFeature*>(block.edges.rows.data[i]);
}
OPENFAB_INLINE const VertexFeature& vertex_at(const KernelScratch& block, size_t i) {
    return *reinterpret_cast<const VertexFeature*>(block.vertices.rows.data[i]);
}

/// The excess for the triangles of all trees that are on the list.
OPENFAB_INLINE float least_excess(const BlockPlace& place, const KernelScratch& scratch) {
    float longest = 0;
    for (size_t i = 0; i < scratch.list.size; ++i)
        longest = larger(longest, scratch.list.data[i].tree->longest_edge);
    const float rounded = (longest + place.reach) * kRounded;
    return rounded < place.excess ? rounded : place.excess;
}

/// Writes what wins where a feature of the block does: faces, edges, vertices.
OPENFAB_INLINE void list_answers(KernelScratch* scratch) {
    const size_t faces = scratch->faces.rows.size, edges = scratch->edges.rows.size,
                 vertices = scratch->vertices.rows.size;
    scratch->margins.reserve(faces);
    scratch->answers.size = faces + edges + vertices;
    scratch->answers.reserve(scratch->answers.size);
    FeatureAnswer* answer = scratch->answers.data;
    for (size_t i = 0; i < faces; ++i) {
        const TriangleDetail& d = *scratch->faces.details.data[i];
        scratch->margins.data[i] = d.margin;
        *answer++ = face_answer(d);
    }
    for (size_t i = 0; i < edges; ++i)
        *answer++ = edge_answer(edge_at(*scratch, i), *scratch->edges.details.data[i]);
    for (size_t i = 0; i < vertices; ++i) {
        *answer++ = vertex_answer(vertex_at(*scratch, i), *scratch->vertices.details.data[i]);
    }
}

/// The features that may be nearest to a voxel of the sub-blocks `subs`, from the leaves of the
/// list.
__attribute__((noinline)) void collect_features(const BlockPlace& place, uint32_t subs,
                                                KernelScratch* scratch) {
    for (size_t i = 0; i < scratch->list.size; ++i) {
        const Entry& e = scratch->list.data[i];
        const uint32_t first = e.tree->nodes[e.node].first();
        __builtin_prefetch(e.tree->first_edge + first);
        __builtin_prefetch(e.tree->first_vertex + first);
    }
    collect_kind<TriangleFrame>(place, subs, scratch, &scratch->faces);
    collect_kind<EdgeFeature>(place, subs, scratch, &scratch->edges);
    collect_kind<VertexFeature>(place, subs, scratch, &scratch->vertices);
    list_answers(scratch);
}

/// What is left of a block's features for a quarter; places are those in the answers.
struct FeaturesOfQuarter {
    const KernelScratch& block;
    int quarter;

    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        each(
            block.faces, [&](uint32_t i) __attribute__((always_inline)) {
                visit(face_at(block, i), block.margins.data[i], i);
            });
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        const auto first = static_cast<uint32_t>(block.faces.rows.size);
        each(
            block.edges, [&](uint32_t i) __attribute__((always_inline)) {
                visit(edge_at(block, i), first + i);
            });
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        const auto first = static_cast<uint32_t>(block.faces.rows.size + block.edges.rows.size);
        each(
            block.vertices, [&](uint32_t i) __attribute__((always_inline)) {
                visit(vertex_at(block, i).v, first + i);
            });
    }
    OPENFAB_INLINE const FeatureAnswer& answer(int32_t place) const {
        return block.answers.data[place];
    }

  private:
    template <typename Visit>
    OPENFAB_INLINE void each(const BlockFeatures& features, const Visit& visit) const {
        const uint32_t* near =
            features.near.data + static_cast<size_t>(quarter) * features.near_stride;
        const uint32_t count = features.near_count[quarter];
        for (uint32_t i = 0; i < count; ++i)
            visit(near[i]);
    }
};
