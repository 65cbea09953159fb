// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/unit_features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/infinity.h"
#include "runtime/nearest/tree/vec_arrays.h"

namespace openfab::nearest {

void UnitFeatures::find(std::span<const LatticePatch* const> patches) {
    size_t triangles = 0, vertices = 0;
    by_id_.clear();
    for (size_t i = 0; i < patches.size(); ++i) {
        triangles += patches[i]->mesh->triangles.size();
        vertices += patches[i]->mesh->positions.size();
        by_id_.push_back(static_cast<uint32_t>(i));
    }
    std::sort(by_id_.begin(), by_id_.end(),
              [&](uint32_t a, uint32_t b) { return patches[a]->id < patches[b]->id; });
    frames_.resize(triangles);
    details_.resize(triangles);
    corners_.clear();
    sides_.clear();
    edges_.clear();
    vertices_.clear();
    vertex_slots_.assign(std::bit_ceil(2 * vertices), kNone);
    edge_slots_.assign(std::bit_ceil(6 * triangles), kNone);
    first_.resize(patches.size());
    for (const uint32_t place : by_id_) {
        first_[place] = corners_.size();
        add_patch(*patches[place]);
    }
}

void UnitFeatures::add_patch(const LatticePatch& patch) {
    numbers_.assign(patch.mesh->positions.size(), kNone);
    const auto number = [&](int32_t v) {
        uint32_t& n = numbers_[static_cast<size_t>(v)];
        if (n == kNone) n = vertex_at(patch.mesh->positions[static_cast<size_t>(v)]);
        return n;
    };
    for (size_t t = 0; t < patch.mesh->triangles.size(); ++t) {
        const std::array<int32_t, 3>& v = patch.mesh->triangles[t];
        const auto triangle = static_cast<uint32_t>(corners_.size());
        const Vec3f* positions = patch.mesh->positions.data();
        make_triangle(positions[v[0]], positions[v[1]], positions[v[2]], patch.id,
                      static_cast<int32_t>(t), &frames_[triangle], &details_[triangle]);
        const std::array<uint32_t, 3> corners{number(v[0]), number(v[1]), number(v[2])};
        for (uint32_t k = 0; k < 3; ++k) {
            Vertex& vertex = vertices_[corners[k]];
            if (vertex.owner == kNone) vertex.owner = 3 * triangle + k;
        }
        corners_.push_back(corners);
        std::array<uint32_t, 3> sides;
        for (uint32_t k = 0; k < 3; ++k)
            sides[k] = edge_between(corners[k], corners[(k + 1) % 3], 3 * triangle + k);
        sides_.push_back(sides);
    }
}

uint32_t UnitFeatures::vertex_at(const Vec3f& position) {
    const Vec3f p = position + Vec3f{0, 0, 0};  // both zeros count as one position
    const uint64_t x = std::bit_cast<uint32_t>(p.x), y = std::bit_cast<uint32_t>(p.y),
                   z = std::bit_cast<uint32_t>(p.z);
    uint64_t hash =
        (x * 0x9e3779b97f4a7c15u) ^ (y * 0xc2b2ae3d27d4eb4fu) ^ (z * 0x165667b19e3779f9u);
    hash ^= hash >> 29;
    const size_t mask = vertex_slots_.size() - 1;
    size_t slot = hash * 0x9e3779b97f4a7c15u >> 20 & mask;
    for (; vertex_slots_[slot] != kNone; slot = (slot + 1) & mask) {
        if (vertices_[vertex_slots_[slot]].at == p) return vertex_slots_[slot];
    }
    const auto made = static_cast<uint32_t>(vertices_.size());
    vertex_slots_[slot] = made;
    vertices_.push_back({p, kNone, 0, {}});
    return made;
}

uint32_t UnitFeatures::edge_between(uint32_t a, uint32_t b, uint32_t face) {
    const uint32_t from = std::min(a, b), to = std::max(a, b);
    const size_t mask = edge_slots_.size() - 1;
    size_t slot = (from * 2654435761u ^ to * 2246822519u) >> 4 & mask;
    for (; edge_slots_[slot] != kNone; slot = (slot + 1) & mask) {
        Edge& edge = edges_[edge_slots_[slot]];
        if (edge.from != from || edge.to != to) continue;
        // A third face only prunes: it is left out.
        if (edge.face[1] == kNone) edge.face[1] = face;
        return edge_slots_[slot];
    }
    const auto made = static_cast<uint32_t>(edges_.size());
    edge_slots_[slot] = made;
    const Vec3f way = vertices_[to].at - vertices_[from].at;
    const float l = std::sqrt(dot(way, way));
    edges_.push_back({from, to, {face, kNone}, way * (1.0f / l), l});
    for (const uint32_t end : {from, to}) {
        Vertex& vertex = vertices_[end];
        if (vertex.spokes < kMaxSpokes && l > 0) vertex.spoke[vertex.spokes++] = made;
    }
    return made;
}

UnitFeatures::Wing UnitFeatures::wing(uint32_t face) const {
    if (face == kNone) return {};
    const size_t t = face / 3, side = face % 3, next = (side + 1) % 3, last = (side + 2) % 3;
    const TriangleFrame& frame = frames_[t];
    if (frame.n[0] == 0 && frame.n[1] == 0 && frame.n[2] == 0) return {};
    const float height = std::abs(dot(to_vec(frame.m[side]), corner(t, last) - corner(t, side)));
    const float reach = std::max(edges_[sides_[t][next]].length, edges_[sides_[t][last]].length);
    return {height / reach, reach};
}

void UnitFeatures::append_edges(size_t triangle, uint32_t owner, LeafFeatures* leaf,
                                LeafSides* sides, Tree* tree) const {
    for (uint32_t k = 0; k < 3; ++k) {
        const Edge& edge = edges_[sides_[triangle][k]];
        if (edge.face[0] == 3 * triangle + k) append_edge(edge, owner, leaf, sides, tree);
    }
}

void UnitFeatures::append_vertices(size_t triangle, uint32_t owner, LeafFeatures* leaf,
                                   LeafSides* sides, Tree* tree) const {
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t number = corners_[triangle][k];
        if (vertices_[number].owner == 3 * triangle + k)
            append_vertex(number, owner, leaf, sides, tree);
    }
}

void UnitFeatures::append_edge(const Edge& edge, uint32_t owner, LeafFeatures* leaf,
                               LeafSides* sides, Tree* tree) const {
    const size_t t = edge.face[0] / 3, side = edge.face[0] % 3;
    const TriangleDetail& detail = details_[t];
    const bool swapped = (detail.flags >> side & 1u) != 0;
    const Vec3f v = corner(t, side), w = corner(t, (side + 1) % 3);
    const Vec3f a = swapped ? w : v, b = swapped ? v : w, ab = b - a;
    EdgeFeature f;
    store(a, f.a);
    store(ab, f.ab);
    f.length2 = (ab.x * ab.x + ab.y * ab.y) + ab.z * ab.z;
    f.inv_length2 = 1.0f / f.length2;
    f.owner_edge = owner << 3 | (swapped ? 4u : 0u) | static_cast<uint32_t>(side);
    tree->edges.push_back(f);
    ++leaf->edges;
    LeafSides::Edge of{};
    of.along = edge.along;
    if (!(dot(of.along, ab) > 0)) of.along = of.along * -1.0f;
    for (int i = 0; i < 2; ++i) {
        const Wing wing_of = wing(edge.face[i]);
        if (!(wing_of.rho > 0)) continue;
        const TriangleFrame& frame = frames_[edge.face[i] / 3];
        store(to_vec(frame.m[edge.face[i] % 3]) * wing_of.rho, of.wing[i]);
        leaf->inv_reach = std::max(leaf->inv_reach, 1.0f / wing_of.reach);
    }
    sides->edges.push_back(of);
}

/// Takes four edges at most: the one that leads most into the part, which excludes convex vertices
/// as seen from there, then those in the widest gaps.
void UnitFeatures::append_vertex(uint32_t number, uint32_t owner, LeafFeatures* leaf,
                                 LeafSides* sides, Tree* tree) const {
    const Vertex& vertex = vertices_[number];
    VertexFeature f;
    store(vertex.at, f.v);
    f.owner_corner = owner << 2 | vertex.owner % 3;
    tree->vertices.push_back(f);
    ++leaf->vertices;
    constexpr float kTaken = 2;  // more than any cosine
    std::array<Vec3f, kMaxSpokes> spoke;
    std::array<float, kMaxSpokes> cost;
    const Vec3f normal = to_vec(frames_[vertex.owner / 3].n);
    float shortest = kInfinity;
    for (uint32_t i = 0; i < vertex.spokes; ++i) {
        const Edge& edge = edges_[vertex.spoke[i]];
        spoke[i] = edge.from == number ? edge.along : edge.along * -1.0f;
        cost[i] = dot(spoke[i], normal);
        shortest = std::min(shortest, edge.length);
    }
    LeafSides::Vertex of;
    while (of.count < kHalfSpaces) {
        uint32_t best = 0;
        for (uint32_t i = 1; i < vertex.spokes; ++i)
            best = cost[i] < cost[best] ? i : best;
        if (best >= vertex.spokes || cost[best] >= kTaken) break;
        const Vec3f taken = spoke[best];
        for (uint32_t i = 0; i < vertex.spokes; ++i) {
            const float gap = dot(spoke[i], taken);
            cost[i] = of.count == 0 ? gap : std::max(cost[i], gap);
        }
        // Those taken before keep the most.
        of.direction[static_cast<size_t>(of.count++)] = taken;
        cost[best] = kTaken;
    }
    if (vertex.spokes > 0) leaf->inv_reach = std::max(leaf->inv_reach, 1.0f / shortest);
    sides->vertices.push_back(of);
}

}  // namespace openfab::nearest
