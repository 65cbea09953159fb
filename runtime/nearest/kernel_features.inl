// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Faces, edges and vertices that may be nearest to a voxel of a block, and the voxels of its
// quarters against them without a branch. Part of kernel.inl.

/// How far something is from every corner of the box at most, squared.
OPENFAB_INLINE float farthest_row2(const Domination& rows) {
    float farthest2 = kInfinity;
    for (int i = 0; i < rows.rows; ++i) {
        const float far2 = largest_lane(load(rows.row[i]));
        farthest2 = far2 < farthest2 ? far2 : farthest2;
    }
    return farthest2;
}

/// The longest edge of the triangles of all trees that are on the list.
OPENFAB_INLINE float longest_edge_listed(const KernelScratch& scratch) {
    float longest = 0;
    for (size_t i = 0; i < scratch.list.size; ++i)
        longest = larger(longest, scratch.list.data[i].tree->longest_edge);
    return longest;
}

/// All quarters of these sub-blocks.
OPENFAB_INLINE uint32_t quarters_of(uint32_t subs) {
    uint32_t spread = (subs | subs << 12) & 0x000f000fu;
    spread = (spread | spread << 6) & 0x03030303u;
    spread = (spread | spread << 3) & 0x11111111u;
    return spread * 15;
}

/// As many features of a leaf are tested at once.
constexpr auto kLeafLanes = static_cast<uint32_t>(I16::kLanes);

/// A place with the kind of what is there.
constexpr uint32_t kPlaceBits = 30;
constexpr uint32_t kFaces = 0, kEdges = 1, kVertices = 2;

/// Lanes from `edges` and from `vertices` on have those.
OPENFAB_INLINE void tag_places(uint32_t first, int32_t edges, int32_t vertices, uint32_t* out) {
    for (int32_t l = 0; l < static_cast<int32_t>(kLeafLanes); ++l) {
        const uint32_t kind = (l < edges ? kFaces : kEdges) + (l < vertices ? 0 : 1);
        out[l] = kind << kPlaceBits | (first + static_cast<uint32_t>(l));
    }
}

/// Takes a list of places apart by kind.
OPENFAB_INLINE void part_kinds(const uint32_t* tagged, uint32_t count, KindLists* out) {
    for (auto& places : out->places) {
        places.reserve(count + kLeafLanes);
        places.size = 0;
    }
    for (uint32_t i = 0; i < count; i += kLeafLanes) {
        const uint32_t there = count - i < kLeafLanes ? (1u << (count - i)) - 1 : ~0u;
        alignas(64) uint32_t place[kLeafLanes];
        for (uint32_t l = 0; l < kLeafLanes; ++l)
            place[l] = tagged[i + l] & ((1u << kPlaceBits) - 1);
        for (uint32_t kind = 0; kind < kFeatureKinds; ++kind) {
            auto& places = out->places[kind];
            places.size += list_numbers(there & lanes_of_kind(tagged + i, kind), place,
                                        places.data + places.size);
        }
    }
}

/// Room for lists of `size` places for each quarter; what they hold stays.
__attribute__((noinline)) void widen_lists(size_t size, BlockFeatures* f) {
    const size_t stride = size + kLeafLanes, before = f->near_stride;
    f->near.reserve(kQuarters * stride);
    for (size_t q = kQuarters; q-- > 1 && before != 0;) {
        __builtin_memmove(f->near.data + q * stride, f->near.data + q * before,
                          f->near_count[q] * sizeof(uint32_t));
    }
    f->near_stride = stride;
}

/// Appends the places of the lanes `left` to what is left for a quarter.
OPENFAB_INLINE void list_for_quarter(int quarter, uint32_t left, const uint32_t* places,
                                     BlockFeatures* f) {
    uint32_t& count = f->near_count[quarter];
    if (__builtin_expect(count + kLeafLanes > f->near_stride, 0))
        widen_lists(2 * f->near_stride, f);
    count += list_numbers(left, places,
                          f->near.data + static_cast<size_t>(quarter) * f->near_stride + count);
}

OPENFAB_INLINE const int16_t* half_spaces_of(const TreeView& tree, const LeafFeatures& leaf) {
    return tree.half_spaces + size_t{leaf.first_half_space} * HalfSpaces::kValues;
}

/// Lists what is left of the features of one leaf for the `quarters`.
OPENFAB_INLINE void collect_leaf(const SidePlace& place, const Entry& e, uint32_t quarters,
                                 BlockFeatures* f) {
    const TreeView& tree = *e.tree;
    const Node& node = tree.nodes[e.node];
    const LeafFeatures& leaf = tree.leaves[e.node];
    const LeafPlace leaf_place(place, leaf);
    const uint32_t edges_from = node.count(), vertices_from = edges_from + leaf.edges;
    const uint32_t end = vertices_from + leaf.vertices;
    const int16_t* values = half_spaces_of(tree, leaf);
    for (uint32_t first = 0; first < end; first += kLeafLanes) {
        LeafTest test(place, leaf_place, values + first, end,
                      static_cast<int32_t>(edges_from - first),
                      static_cast<int32_t>(vertices_from - first));
        const uint32_t all = end - first < kLeafLanes ? (1u << (end - first)) - 1 : 0xffffu;
        const auto base = static_cast<uint32_t>(f->lanes.size) * kLeafLanes;
        alignas(64) uint32_t places[kLeafLanes];
        tag_places(base, static_cast<int32_t>(edges_from - first),
                   static_cast<int32_t>(vertices_from - first), places);
        uint32_t anywhere = 0;
        for (uint32_t left = quarters; left != 0;) {
            const int sub = __builtin_ctz(left) / 4;
            const uint32_t asked = left >> 4 * sub & 0xfu;
            left &= ~(0xfu << 4 * sub);
            if ((test.enter(sub) & all) == 0) continue;
            for (int q = 0; q < 4; ++q) {
                if ((asked >> q & 1u) == 0) continue;
                const uint32_t here = test.left_in(q) & all;
                anywhere |= here;
                list_for_quarter(4 * sub + q, here, places, f);
            }
        }
        if (anywhere == 0) continue;
        f->lanes.push({e.tree,
                       {node.first() + first, leaf.first_edge + first - edges_from,
                        leaf.first_vertex + first - vertices_from}});
        f->left.reserve(f->left.size + kLeafLanes);
        f->left.size += list_numbers(anywhere, places, f->left.data + f->left.size);
    }
}

OPENFAB_INLINE const TriangleFrame& face_at(const BlockFeatures& f, size_t place) {
    return *reinterpret_cast<const TriangleFrame*>(f.rows.data[place]);
}
OPENFAB_INLINE const EdgeFeature& edge_at(const BlockFeatures& f, size_t place) {
    return *reinterpret_cast<const EdgeFeature*>(f.rows.data[place]);
}
OPENFAB_INLINE const VertexFeature& vertex_at(const BlockFeatures& f, size_t place) {
    return *reinterpret_cast<const VertexFeature*>(f.rows.data[place]);
}

/// Finds the features of one kind, and gets them on their way from memory.
template <typename Feature>
OPENFAB_INLINE void find_rows(const Growing<uint32_t>& places, uint32_t kind,
                              const Feature* TreeView::*features, BlockFeatures* f) {
    for (size_t i = 0; i < places.size; ++i) {
        const uint32_t place = places.data[i];
        const LeafLanes& lanes = f->lanes.data[place / kLeafLanes];
        const uint32_t at = lanes.first[kind] + place % kLeafLanes;
        const Feature* feature = lanes.tree->*features + at;
        __builtin_prefetch(feature);
        __builtin_prefetch(reinterpret_cast<const char*>(feature + 1) - 1);
        f->rows.data[place] = reinterpret_cast<const float*>(feature);
    }
}

/// Finds what is left, and what wins where it does. All features are on their way from memory
/// before the first is read, and so are their owners.
OPENFAB_INLINE void list_answers(BlockFeatures* f, KindLists* by_kind) {
    const size_t places = f->lanes.size * kLeafLanes;
    f->rows.reserve(places);
    f->details.reserve(places);
    f->answers.reserve(places);
    f->margins.reserve(places);
    part_kinds(f->left.data, static_cast<uint32_t>(f->left.size), by_kind);
    find_rows(by_kind->places[kFaces], kFaces, &TreeView::frames, f);
    find_rows(by_kind->places[kEdges], kEdges, &TreeView::edges, f);
    find_rows(by_kind->places[kVertices], kVertices, &TreeView::vertices, f);
    const auto each = [by_kind](uint32_t kind, const auto& visit) __attribute__((always_inline)) {
        const auto& list = by_kind->places[kind];
        for (size_t i = 0; i < list.size; ++i)
            visit(list.data[i]);
    };
    const auto own = [f](uint32_t place, uint32_t owner) __attribute__((always_inline)) {
        const TriangleDetail* d = f->lanes.data[place / kLeafLanes].tree->details + owner;
        __builtin_prefetch(&d->patch);
        f->details.data[place] = d;
    };
    each(kFaces,
         [&](uint32_t p) { own(p, f->lanes.data[p / kLeafLanes].first[kFaces] + p % kLeafLanes); });
    each(kEdges, [&](uint32_t p) { own(p, edge_at(*f, p).owner()); });
    each(kVertices, [&](uint32_t p) { own(p, vertex_at(*f, p).owner()); });
    each(kFaces, [&](uint32_t p) {
        const TriangleDetail& d = *f->details.data[p];
        f->margins.data[p] = d.margin;
        f->answers.data[p] = face_answer(d);
    });
    each(kEdges, [&](uint32_t p) {
        f->answers.data[p] = edge_answer(edge_at(*f, p), *f->details.data[p]);
    });
    each(kVertices, [&](uint32_t p) {
        f->answers.data[p] = vertex_answer(vertex_at(*f, p), *f->details.data[p]);
    });
}

/// The features that may be nearest to a voxel of the `quarters`, from the leaves of the list.
__attribute__((noinline)) void collect_features(const BlockPlace& place, uint32_t quarters,
                                                KernelScratch* scratch) {
    constexpr size_t kFirstSize = 128, kAhead = 7;
    BlockFeatures* f = &scratch->features;
    f->lanes.size = f->left.size = 0;
    for (uint32_t& count : f->near_count)
        count = 0;
    if (f->near_stride == 0) widen_lists(kFirstSize, f);
    const SidePlace side_place = make_side_place(place, longest_edge_listed(*scratch));
    const size_t count = scratch->list.size;
    for (size_t i = 0; i < count; ++i) {
        const Entry& next = scratch->list.data[i + kAhead < count ? i + kAhead : i];
        const int16_t* coming = half_spaces_of(*next.tree, next.tree->leaves[next.node]);
        for (int line = 0; line < 8; ++line)
            __builtin_prefetch(coming + line * 32);
        collect_leaf(side_place, scratch->list.data[i],
                     quarters & quarters_of(scratch->list_subs.data[i]), f);
    }
    list_answers(f, &scratch->by_kind);
}

/// What is left for a quarter, by kind.
struct FeaturesOfQuarter {
    const BlockFeatures& block;
    const KindLists& lists;

    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        each(
            kFaces, [&](uint32_t place) __attribute__((always_inline)) {
                visit(face_at(block, place), block.margins.data[place], place);
            });
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        each(
            kEdges, [&](uint32_t place)
                        __attribute__((always_inline)) { visit(edge_at(block, place), place); });
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        each(
            kVertices, [&](uint32_t place) __attribute__((always_inline)) {
                visit(vertex_at(block, place).v, place);
            });
    }
    OPENFAB_INLINE const FeatureAnswer& answer(int32_t place) const {
        return block.answers.data[place];
    }

  private:
    template <typename Visit>
    OPENFAB_INLINE void each(uint32_t kind, const Visit& visit) const {
        const uint32_t* places = lists.places[kind].data;
        const size_t count = lists.places[kind].size;
        for (size_t i = 0; i < count; ++i)
            visit(places[i]);
    }
};
