// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/features.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/infinity.h"
#include "base/vec.h"
#include "runtime/nearest/tree/vec_arrays.h"
#include "runtime/nearest/tree/vertex_numbers.h"

namespace openfab::nearest {
namespace {

/// An edge as seen from one end.
struct Spoke {
    uint32_t other;     ///< vertex at its other end
    uint32_t triangle;  ///< index in the tree
    uint32_t edge;      ///< of that triangle
};

/// A feature with its half-spaces.
struct Edge {
    EdgeFeature feature;
    EdgeHalfSpaces half_spaces;
};
struct Vertex {
    VertexFeature feature;
    VertexHalfSpaces half_spaces;
};

/// Finds the features of consecutive triangles of a tree. Triangles of the one-ring are numbered
/// after them.
class Builder {
  public:
    Builder(const TriangleFrame* frames, const TriangleDetail* details, size_t count,
            const TriangleList& one_ring)
        : frames_(frames),
          details_(details),
          count_(count),
          one_ring_(one_ring),
          numbers_(3 * all()) {}

    Features build() {
        const uint32_t own = number_vertices();
        sort_corners();
        std::vector<Edge> edges;
        std::vector<Vertex> vertices;
        std::vector<Spoke> spokes;
        for (uint32_t v = 0; v < own; ++v)
            add_vertex(v, own, &spokes, &edges, &vertices);
        Features out;
        sort_by_owner(edges, &out.first_edge, &out.edges, &out.edge_half_spaces);
        sort_by_owner(vertices, &out.first_vertex, &out.vertices, &out.vertex_half_spaces);
        return out;
    }

  private:
    size_t all() const { return count_ + one_ring_.frames.size(); }
    const TriangleFrame& frame(size_t triangle) const {
        return triangle < count_ ? frames_[triangle] : one_ring_.frames[triangle - count_];
    }
    const TriangleDetail& detail(size_t triangle) const {
        return triangle < count_ ? details_[triangle] : one_ring_.details[triangle - count_];
    }
    Vec3f position(size_t triangle, size_t corner) const {
        const TriangleDetail& d = detail(triangle);
        const float* v[3] = {frame(triangle).v0, d.v1, d.v2};
        return to_vec(v[corner]);
    }

    /// Numbers the vertices; returns how many are not in the one-ring alone, which come last.
    uint32_t number_vertices() {
        vertex_.resize(all() * 3);
        uint32_t own = 0;
        for (size_t c = 0; c < vertex_.size(); ++c) {
            vertex_[c] = numbers_.add(position(c / 3, c % 3));
            if (c < 3 * count_) own = std::max(own, vertex_[c] + 1);
        }
        return own;
    }

    /// Lists the corners at each vertex, in the order of triangles.
    void sort_corners() {
        first_corner_.assign(numbers_.positions().size() + 1, 0);
        for (const uint32_t v : vertex_)
            ++first_corner_[v + 1];
        for (size_t v = 0; v < numbers_.positions().size(); ++v)
            first_corner_[v + 1] += first_corner_[v];
        corner_.resize(vertex_.size());
        std::vector<uint32_t> next(first_corner_.begin(), first_corner_.end() - 1);
        for (size_t c = 0; c < vertex_.size(); ++c)
            corner_[next[vertex_[c]]++] = static_cast<uint32_t>(c);
    }

    bool owns_before(uint32_t a, uint32_t b) const {
        const TriangleDetail &da = detail(a), &db = detail(b);
        return precedes(da.patch, da.triangle, db.patch, db.triangle);
    }

    void add_vertex(uint32_t v, uint32_t own, std::vector<Spoke>* spokes, std::vector<Edge>* edges,
                    std::vector<Vertex>* vertices) const {
        spokes->clear();
        uint32_t owner = corner_[first_corner_[v]];
        for (uint32_t i = first_corner_[v]; i < first_corner_[v + 1]; ++i) {
            const uint32_t t = corner_[i] / 3, k = corner_[i] % 3;
            // If two corners of a triangle are here, the first.
            if (owns_before(t, owner / 3)) owner = corner_[i];
            const uint32_t next = vertex_[3 * t + (k + 1) % 3];
            const uint32_t previous = vertex_[3 * t + (k + 2) % 3];
            if (next != v) spokes->push_back({next, t, k});
            if (previous != v) spokes->push_back({previous, t, (k + 2) % 3});
        }
        std::sort(spokes->begin(), spokes->end(), [&](const Spoke& a, const Spoke& b) {
            if (a.other != b.other) return a.other < b.other;
            if (a.triangle != b.triangle) return owns_before(a.triangle, b.triangle);
            return a.edge < b.edge;
        });
        if (owner / 3 < count_) vertices->push_back(make_vertex(v, owner, *spokes));
        for (size_t i = 0; i < spokes->size();) {
            size_t end = i + 1;
            while (end < spokes->size() && (*spokes)[end].other == (*spokes)[i].other)
                ++end;
            const Spoke& first = (*spokes)[i];
            if (first.other > v && first.other < own && first.triangle < count_)
                edges->push_back(make_edge(v, spokes->data() + i, spokes->data() + end));
            i = end;
        }
    }

    Vertex make_vertex(uint32_t v, uint32_t owner, const std::vector<Spoke>& spokes) const {
        Vertex out{};
        store(numbers_.positions()[v], out.feature.v);
        out.feature.owner_corner = owner / 3 << 2 | owner % 3;
        const float* n = frames_[out.feature.owner()].n;
        Vec3f up{}, down{}, along_edge[VertexHalfSpaces::kMaxEdges];
        float shortest = kInfinity;
        int edges = 0, ups = 0;
        for (size_t i = 0; i < spokes.size() && edges < VertexHalfSpaces::kMaxEdges; ++i) {
            if (i > 0 && spokes[i].other == spokes[i - 1].other) continue;
            const Vec3f along = numbers_.positions()[spokes[i].other] - numbers_.positions()[v];
            const float l = length(along);
            if (!(l > 0)) continue;
            const Vec3f u = along * (1.0f / l);
            along_edge[edges++] = u;
            shortest = std::min(shortest, l);
            const bool above = dot(u, to_vec(n)) > 0;
            (above ? up : down) = (above ? up : down) + u;
            ups += above ? 1 : 0;
        }
        VertexHalfSpaces& half_spaces = out.half_spaces;
        half_spaces.inv_reach = 1.0f / shortest;
        int count = 0;
        if (ups > 1) store(up * (1.0f / static_cast<float>(ups)), half_spaces.direction[count++]);
        if (edges - ups > 1)
            store(down * (1.0f / static_cast<float>(edges - ups)), half_spaces.direction[count++]);
        for (int i = 0; i < edges; ++i)
            store(along_edge[i], half_spaces.direction[count++]);
        return out;
    }

    struct Wing {
        float rho = 0, reach = 0;
    };

    /// Computes the wing of a face at one of its edges.
    Wing wing(uint32_t triangle, uint32_t edge) const {
        const TriangleFrame& t = frame(triangle);
        if (t.n[0] == 0 && t.n[1] == 0 && t.n[2] == 0) return {};
        const Vec3f apex = position(triangle, (edge + 2) % 3);
        const Vec3f first = position(triangle, edge), second = position(triangle, (edge + 1) % 3);
        const float height = std::abs(dot(to_vec(t.m[edge]), apex - first));
        const float reach = std::max(length(apex - first), length(apex - second));
        return {height / reach, reach};
    }

    Edge make_edge(uint32_t v, const Spoke* begin, const Spoke* end) const {
        Edge out{};
        const Vec3f &p = numbers_.positions()[v], &q = numbers_.positions()[begin->other];
        const bool p_first = std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
        const Vec3f a = p_first ? p : q, b = p_first ? q : p;
        const Vec3f ab = b - a;
        EdgeFeature& f = out.feature;
        store(a, f.a);
        store(ab, f.ab);
        f.length2 = (ab.x * ab.x + ab.y * ab.y) + ab.z * ab.z;
        f.inv_length2 = 1.0f / f.length2;
        f.owner_edge = begin->triangle << 3 |
                       (details_[begin->triangle].flags >> begin->edge & 1u) << 2 | begin->edge;
        EdgeHalfSpaces& half_spaces = out.half_spaces;
        const Wing own = wing(begin->triangle, begin->edge);
        store(to_vec(frames_[begin->triangle].m[begin->edge]) * own.rho, half_spaces.wing[0]);
        Wing best;
        for (const Spoke* s = begin + 1; s != end; ++s) {
            const Wing w = wing(s->triangle, s->edge);
            if (!(w.rho > best.rho)) continue;
            best = w;
            store(to_vec(frame(s->triangle).m[s->edge]) * w.rho, half_spaces.wing[1]);
        }
        for (const Wing& w : {own, best})
            if (w.rho > 0) half_spaces.inv_reach = std::max(half_spaces.inv_reach, 1.0f / w.reach);
        return out;
    }

    /// Sorts features by their owners.
    template <typename Item, typename Feature, typename Sides>
    void sort_by_owner(const std::vector<Item>& list, std::vector<uint32_t>* first,
                       std::vector<Feature>* features, std::vector<Sides>* half_spaces) const {
        first->assign(count_ + 1, 0);
        for (const Item& k : list)
            ++(*first)[k.feature.owner() + 1];
        for (size_t t = 0; t < count_; ++t)
            (*first)[t + 1] += (*first)[t];
        features->resize(list.size());
        half_spaces->resize(list.size());
        std::vector<uint32_t> next(first->begin(), first->end() - 1);
        for (const Item& k : list) {
            const uint32_t at = next[k.feature.owner()]++;
            (*features)[at] = k.feature;
            (*half_spaces)[at] = k.half_spaces;
        }
    }

    const TriangleFrame* frames_;
    const TriangleDetail* details_;
    size_t count_;
    const TriangleList& one_ring_;
    VertexNumbers numbers_;
    std::vector<uint32_t> vertex_;        // [3 * triangle + corner]
    std::vector<uint32_t> first_corner_;  // [vertex]: where its corners begin in corner_
    std::vector<uint32_t> corner_;
};

/// Copies the features of the triangles from `begin` on to `offset` in the list of all.
template <typename Feature>
void append(const std::vector<Feature>& list, const std::vector<uint32_t>& first, size_t begin,
            size_t offset, uint32_t owner_shift, uint32_t Feature::*owner,
            std::vector<Feature>* out, std::vector<uint32_t>* out_first) {
    for (size_t i = 0; i < list.size(); ++i) {
        Feature f = list[i];
        f.*owner += static_cast<uint32_t>(begin) << owner_shift;
        (*out)[offset + i] = f;
    }
    // The last is the first of what follows.
    for (size_t t = 0; t + 1 < first.size(); ++t)
        (*out_first)[begin + t] = static_cast<uint32_t>(offset) + first[t];
}

}  // namespace

Features make_features(const std::vector<TriangleFrame>& frames,
                       const std::vector<TriangleDetail>& details, const TriangleList& one_ring) {
    // Neighbours in the tree are neighbours in space: ranges of it share few edges, so each is done
    // separately in little memory.
    constexpr size_t kChunk = 4096;
    const size_t count = frames.size();
    std::vector<Features> chunks((count + kChunk - 1) / kChunk);
    const auto make = [&](size_t c) {
        const size_t begin = c * kChunk;
        chunks[c] = Builder(frames.data() + begin, details.data() + begin,
                            std::min(kChunk, count - begin), one_ring)
                        .build();
    };
    if (chunks.empty()) return {};
    if (chunks.size() == 1) {
        make(0);
        return std::move(chunks[0]);
    }
    tbb::parallel_for(size_t{0}, chunks.size(), make);
    std::vector<size_t> edges(chunks.size() + 1), vertices(chunks.size() + 1);
    for (size_t c = 0; c < chunks.size(); ++c) {
        edges[c + 1] = edges[c] + chunks[c].edges.size();
        vertices[c + 1] = vertices[c] + chunks[c].vertices.size();
    }
    Features out;
    tbb::parallel_invoke([&] { out.edges.resize(edges.back()); },
                         [&] { out.vertices.resize(vertices.back()); },
                         [&] { out.edge_half_spaces.resize(edges.back()); },
                         [&] { out.vertex_half_spaces.resize(vertices.back()); });
    out.first_edge.assign(count + 1, static_cast<uint32_t>(edges.back()));
    out.first_vertex.assign(count + 1, static_cast<uint32_t>(vertices.back()));
    tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
        const Features& f = chunks[c];
        append(f.edges, f.first_edge, c * kChunk, edges[c], 3, &EdgeFeature::owner_edge, &out.edges,
               &out.first_edge);
        append(f.vertices, f.first_vertex, c * kChunk, vertices[c], 2, &VertexFeature::owner_corner,
               &out.vertices, &out.first_vertex);
        std::copy(f.edge_half_spaces.begin(), f.edge_half_spaces.end(),
                  out.edge_half_spaces.begin() + static_cast<ptrdiff_t>(edges[c]));
        std::copy(f.vertex_half_spaces.begin(), f.vertex_half_spaces.end(),
                  out.vertex_half_spaces.begin() + static_cast<ptrdiff_t>(vertices[c]));
        chunks[c] = {};
    });
    return out;
}

}  // namespace openfab::nearest
