// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Candidate faces, edges and vertices of a block, listed for its quarters.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/answers.h"
#include "runtime/nearest/kernel/block_frame.h"
#include "runtime/nearest/kernel/half_spaces.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"
#include "simd/lists.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Returns an upper bound of the squared distance of every point of the box.
OPENFAB_INLINE float upper_bound2(const PruneBounds& bounds) {
    float farthest2 = kInfinity;
    for (int i = 0; i < bounds.count; ++i) {
        const float far2 = largest_lane(Floats8::load(bounds.bound[i]));
        farthest2 = far2 < farthest2 ? far2 : farthest2;
    }
    return farthest2;
}

/// Returns the length of the longest edge in all trees of the frontier.
OPENFAB_INLINE float longest_frontier_edge(const KernelScratch& scratch) {
    float longest = 0;
    for (size_t i = 0; i < scratch.frontier.size; ++i)
        longest = larger(longest, scratch.frontier.data[i].tree->longest_edge);
    return longest;
}

/// Returns all quarters of these sub-blocks.
OPENFAB_INLINE uint32_t quarters_of(uint32_t subs) {
    uint32_t spread = (subs | subs << 12) & 0x000f000fu;
    spread = (spread | spread << 6) & 0x03030303u;
    spread = (spread | spread << 3) & 0x11111111u;
    return spread * 15;
}

/// Features of a leaf tested at once.
constexpr auto kLeafLanes = static_cast<uint32_t>(Fixed16::kLanes);

/// A tagged index has the feature's kind in the bits above these.
constexpr uint32_t kIndexBits = 30;
constexpr uint32_t kFaces = 0, kEdges = 1, kVertices = 2;

/// Tags consecutive indices: edges start at lane `edges`, vertices at lane `vertices`.
OPENFAB_INLINE void tag_indices(uint32_t first, int32_t edges, int32_t vertices, uint32_t* out) {
    for (int32_t l = 0; l < static_cast<int32_t>(kLeafLanes); ++l) {
        const uint32_t kind = (l < edges ? kFaces : kEdges) + (l < vertices ? 0 : 1);
        out[l] = kind << kIndexBits | (first + static_cast<uint32_t>(l));
    }
}

/// Partitions tagged indices by kind.
OPENFAB_INLINE void partition_by_kind(const uint32_t* tagged, uint32_t count, FeaturesByKind* out) {
    for (auto& indices : out->indices) {
        indices.reserve(count + kLeafLanes);
        indices.size = 0;
    }
    for (uint32_t i = 0; i < count; i += kLeafLanes) {
        const uint32_t there = count - i < kLeafLanes ? (1u << (count - i)) - 1 : ~0u;
        alignas(64) uint32_t index[kLeafLanes];
        for (uint32_t l = 0; l < kLeafLanes; ++l)
            index[l] = tagged[i + l] & ((1u << kIndexBits) - 1);
        for (uint32_t kind = 0; kind < kFeatureKinds; ++kind) {
            auto& indices = out->indices[kind];
            indices.size += simd::list_numbers(there & simd::lanes_with_high_bits(tagged + i, kind),
                                               index, indices.data + indices.size);
        }
    }
}

/// Makes room for `size` indices per quarter; keeps the contents.
__attribute__((noinline)) void widen_quarters(size_t size, BlockFeatures* f) {
    const size_t stride = size + kLeafLanes, before = f->quarter_stride;
    f->in_quarter.reserve(kQuarters * stride);
    for (size_t q = kQuarters; q-- > 1 && before != 0;) {
        __builtin_memmove(f->in_quarter.data + q * stride, f->in_quarter.data + q * before,
                          f->quarter_count[q] * sizeof(uint32_t));
    }
    f->quarter_stride = stride;
}

/// Appends the indices of the lanes `left` to the candidates of a quarter.
OPENFAB_INLINE void append_to_quarter(int quarter, uint32_t candidates, const uint32_t* indices,
                                      BlockFeatures* f) {
    uint32_t& count = f->quarter_count[quarter];
    if (__builtin_expect(count + kLeafLanes > f->quarter_stride, 0))
        widen_quarters(2 * f->quarter_stride, f);
    count += simd::list_numbers(
        candidates, indices,
        f->in_quarter.data + static_cast<size_t>(quarter) * f->quarter_stride + count);
}

OPENFAB_INLINE const int16_t* half_spaces_of(const TreeView& tree, const LeafFeatures& leaf) {
    return tree.half_spaces + size_t{leaf.first_half_space} * HalfSpaces::kValues;
}

/// Lists the candidate features of one leaf for the `quarters`.
OPENFAB_INLINE void collect_leaf(const HalfSpaceFrame& frame, const NodeRef& e, uint32_t quarters,
                                 BlockFeatures* f) {
    const TreeView& tree = *e.tree;
    const Node& node = tree.nodes[e.node];
    const LeafFeatures& leaf = tree.leaves[e.node];
    const LeafFrame leaf_frame(frame, leaf);
    const uint32_t edges_from = node.count(), vertices_from = edges_from + leaf.edges;
    const uint32_t end = vertices_from + leaf.vertices;
    const int16_t* values = half_spaces_of(tree, leaf);
    for (uint32_t first = 0; first < end; first += kLeafLanes) {
        LeafTest test(frame, leaf_frame, values + first, end,
                      static_cast<int32_t>(edges_from - first),
                      static_cast<int32_t>(vertices_from - first));
        const uint32_t all = end - first < kLeafLanes ? (1u << (end - first)) - 1 : 0xffffu;
        const auto base = static_cast<uint32_t>(f->lanes.size) * kLeafLanes;
        alignas(64) uint32_t indices[kLeafLanes];
        tag_indices(base, static_cast<int32_t>(edges_from - first),
                    static_cast<int32_t>(vertices_from - first), indices);
        uint32_t anywhere = 0;
        for (uint32_t candidates = quarters; candidates != 0;) {
            const int sub = __builtin_ctz(candidates) / 4;
            const uint32_t active = candidates >> 4 * sub & 0xfu;
            candidates &= ~(0xfu << 4 * sub);
            if ((test.enter(sub) & all) == 0) continue;
            for (int q = 0; q < 4; ++q) {
                if ((active >> q & 1u) == 0) continue;
                const uint32_t here = test.candidates_in(q) & all;
                anywhere |= here;
                append_to_quarter(4 * sub + q, here, indices, f);
            }
        }
        if (anywhere == 0) continue;
        f->lanes.push({e.tree,
                       {node.first() + first, leaf.first_edge + first - edges_from,
                        leaf.first_vertex + first - vertices_from}});
        f->candidates.reserve(f->candidates.size + kLeafLanes);
        f->candidates.size +=
            simd::list_numbers(anywhere, indices, f->candidates.data + f->candidates.size);
    }
}

OPENFAB_INLINE const TriangleFrame& face_at(const BlockFeatures& f, size_t index) {
    return *reinterpret_cast<const TriangleFrame*>(f.values.data[index]);
}
OPENFAB_INLINE const EdgeFeature& edge_at(const BlockFeatures& f, size_t index) {
    return *reinterpret_cast<const EdgeFeature*>(f.values.data[index]);
}
OPENFAB_INLINE const VertexFeature& vertex_at(const BlockFeatures& f, size_t index) {
    return *reinterpret_cast<const VertexFeature*>(f.values.data[index]);
}

/// Looks up the features of one kind and prefetches them.
template <typename Feature>
OPENFAB_INLINE void find_features(const ScratchVector<uint32_t>& indices, uint32_t kind,
                                  const Feature* TreeView::*features, BlockFeatures* f) {
    for (size_t i = 0; i < indices.size; ++i) {
        const uint32_t index = indices.data[i];
        const LeafLanes& lanes = f->lanes.data[index / kLeafLanes];
        const uint32_t at = lanes.first[kind] + index % kLeafLanes;
        const Feature* feature = lanes.tree->*features + at;
        __builtin_prefetch(feature);
        __builtin_prefetch(reinterpret_cast<const char*>(feature + 1) - 1);
        f->values.data[index] = reinterpret_cast<const float*>(feature);
    }
}

/// Looks up the candidates and their answers. All features are prefetched before the first is read,
/// and so are their owners.
OPENFAB_INLINE void look_up_answers(BlockFeatures* f, FeaturesByKind* by_kind) {
    const size_t size = f->lanes.size * kLeafLanes;
    f->values.reserve(size);
    f->details.reserve(size);
    f->answers.reserve(size);
    f->margins.reserve(size);
    partition_by_kind(f->candidates.data, static_cast<uint32_t>(f->candidates.size), by_kind);
    find_features(by_kind->indices[kFaces], kFaces, &TreeView::frames, f);
    find_features(by_kind->indices[kEdges], kEdges, &TreeView::edges, f);
    find_features(by_kind->indices[kVertices], kVertices, &TreeView::vertices, f);
    const auto each = [by_kind](uint32_t kind, const auto& visit) OPENFAB_INLINE_LAMBDA {
        const auto& indices = by_kind->indices[kind];
        for (size_t i = 0; i < indices.size; ++i)
            visit(indices.data[i]);
    };
    const auto own = [f](uint32_t index, uint32_t owner) OPENFAB_INLINE_LAMBDA {
        const TriangleDetail* d = f->lanes.data[index / kLeafLanes].tree->details + owner;
        __builtin_prefetch(&d->patch);
        f->details.data[index] = d;
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

/// Collects the features of the frontier's leaves that may be nearest to a voxel of the `quarters`.
__attribute__((noinline)) void collect_features(const BlockFrame& frame, uint32_t quarters,
                                                KernelScratch* scratch) {
    constexpr size_t kFirstSize = 128, kAhead = 7;
    BlockFeatures* f = &scratch->features;
    f->lanes.size = f->candidates.size = 0;
    for (uint32_t& count : f->quarter_count)
        count = 0;
    if (f->quarter_stride == 0) widen_quarters(kFirstSize, f);
    const HalfSpaceFrame half_space_frame =
        make_half_space_frame(frame, longest_frontier_edge(*scratch));
    const size_t count = scratch->frontier.size;
    for (size_t i = 0; i < count; ++i) {
        const NodeRef& next = scratch->frontier.data[i + kAhead < count ? i + kAhead : i];
        const int16_t* ahead = half_spaces_of(*next.tree, next.tree->leaves[next.node]);
        for (int line = 0; line < 8; ++line)
            __builtin_prefetch(ahead + line * 32);
        collect_leaf(half_space_frame, scratch->frontier.data[i],
                     quarters & quarters_of(scratch->frontier_subs.data[i]), f);
    }
    look_up_answers(f, &scratch->by_kind);
}

/// The candidates of a quarter, by kind.
struct FeaturesOfQuarter {
    const BlockFeatures& block;
    const FeaturesByKind& lists;

    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        each(kFaces, [&](uint32_t index) OPENFAB_INLINE_LAMBDA {
            visit(face_at(block, index), block.margins.data[index], index);
        });
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        each(kEdges,
             [&](uint32_t index) OPENFAB_INLINE_LAMBDA { visit(edge_at(block, index), index); });
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        each(kVertices, [&](uint32_t index)
                            OPENFAB_INLINE_LAMBDA { visit(vertex_at(block, index).v, index); });
    }
    OPENFAB_INLINE const FeatureAnswer& answer(int32_t index) const {
        return block.answers.data[index];
    }

  private:
    template <typename Visit>
    OPENFAB_INLINE void each(uint32_t kind, const Visit& visit) const {
        const uint32_t* indices = lists.indices[kind].data;
        const size_t count = lists.indices[kind].size;
        for (size_t i = 0; i < count; ++i)
            visit(indices[i]);
    }
};

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
