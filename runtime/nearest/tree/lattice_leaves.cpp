// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/lattice_leaves.h"

#include <algorithm>
#include <cmath>

#include "base/infinity.h"
#include "runtime/nearest/tree/leaf_half_spaces.h"
#include "runtime/nearest/tree/vec_arrays.h"

namespace openfab::nearest {
namespace {

Vec3f corner(const TriangleFrame& frame, const TriangleDetail& detail, int i) {
    return to_vec(i == 0 ? frame.v0 : i == 1 ? detail.v1 : detail.v2);
}

}  // namespace

bool LatticeLeaves::begin(const LatticePatch& patch) {
    if (!cells_.read(*patch.patch, *patch.mesh)) return false;
    patch_ = patch;
    unit_ = nullptr;
    positions_ = patch.mesh->positions.data();
    return true;
}

void LatticeLeaves::prepare(const CellBlock& block) {
    const std::vector<std::array<int32_t, 3>>& triangles = patch_.mesh->triangles;
    frames_.resize(triangles.size());
    details_.resize(triangles.size());
    side_lengths_.resize(triangles.size());
    edges_.resize(patch_.mesh->positions.size());
    const auto make = [&](int32_t triangle) {
        if (triangle < 0) return;
        const auto t = static_cast<size_t>(triangle);
        const std::array<int32_t, 3>& v = triangles[t];
        make_triangle(positions_[v[0]], positions_[v[1]], positions_[v[2]], patch_.id, triangle,
                      &frames_[t], &details_[t]);
    };
    const CellBlock own = cells_.clip(block);
    const int32_t right = own.a + own.width, over = own.b + own.height;
    for (int32_t b = own.b; b < over; ++b) {
        for (int32_t a = own.a; a < right; ++a) {
            make(cells_.upper(a, b));
            make(cells_.lower(a, b));
        }
        // Of the cells around, these have the second triangles of its edges.
        make(cells_.upper(right, b));
    }
    for (int32_t a = own.a; a < right; ++a)
        make(cells_.upper(a, over));
    const CellBlock around =
        cells_.clip({block.a - 1, block.b - 1, block.width + 2, block.height + 2});
    measure_edges(around);
}

void LatticeLeaves::measure_edges(const CellBlock& around) {
    const auto measure = [&](int32_t from, int32_t to, size_t edge, PointEdges* out) {
        const Vec3f way = positions_[to] - positions_[from];
        const float l = std::sqrt(dot(way, way));
        out->length[edge] = l;
        out->along[edge] = way * (1.0f / l);
    };
    const int32_t b1 = around.b + around.height, a1 = around.a + around.width;
    for (int32_t b = around.b; b <= b1; ++b) {
        const int32_t points = cells_.points(b);
        const int32_t over = b < cells_.rows() ? cells_.points(b + 1) : 0;
        for (int32_t a = around.a; a <= std::min(a1, points - 1); ++a) {
            const int32_t here = cells_.vertex(a, b);
            PointEdges& edges = edges_[static_cast<size_t>(here)];
            edges.length = {0, 0, 0};
            if (a + 1 < points) measure(here, here + 1, 0, &edges);
            if (a < over) measure(here, cells_.vertex(a, b + 1), 1, &edges);
            if (a + 1 < points && a < over) measure(here + 1, cells_.vertex(a, b + 1), 2, &edges);
        }
    }
    const auto length = [&](int32_t a, int32_t b, size_t edge) {
        return edges_[static_cast<size_t>(cells_.vertex(a, b))].length[edge];
    };
    for (int32_t b = around.b; b < b1; ++b) {
        for (int32_t a = around.a; a < a1; ++a) {
            const int32_t upper = cells_.upper(a, b), lower = cells_.lower(a, b);
            if (upper >= 0) {
                side_lengths_[static_cast<size_t>(upper)] = {length(a, b, 0), length(a, b, 2),
                                                             length(a, b, 1)};
            }
            if (lower >= 0) {
                side_lengths_[static_cast<size_t>(lower)] = {length(a + 1, b, 1),
                                                             length(a, b + 1, 0), length(a, b, 2)};
            }
        }
    }
}

LatticeLeaves::Wing LatticeLeaves::wing(const Face& face) const {
    if (face.triangle < 0) return {};
    const TriangleFrame& frame = frames_[static_cast<size_t>(face.triangle)];
    if (frame.n[0] == 0 && frame.n[1] == 0 && frame.n[2] == 0) return {};
    const TriangleDetail& detail = details_[static_cast<size_t>(face.triangle)];
    const std::array<float, 3>& length = side_lengths_[static_cast<size_t>(face.triangle)];
    const int next = face.side == 2 ? 0 : face.side + 1, last = face.side == 0 ? 2 : face.side - 1;
    const Vec3f up = corner(frame, detail, last) - corner(frame, detail, face.side);
    const float height = std::abs(dot(to_vec(frame.m[face.side]), up));
    const float reach =
        std::max(length[static_cast<size_t>(next)], length[static_cast<size_t>(last)]);
    return {height / reach, reach};
}

void LatticeLeaves::add_edge(int32_t owner, const Side& edge, const Face& own, const Face& other,
                             LeafFeatures* leaf, Tree* tree) {
    const auto t = static_cast<size_t>(own.triangle);
    const TriangleFrame& frame = frames_[t];
    const TriangleDetail& detail = details_[t];
    const Vec3f v = corner(frame, detail, own.side),
                w = corner(frame, detail, own.side == 2 ? 0 : own.side + 1);
    const bool swapped = (detail.flags >> own.side & 1u) != 0;
    const Vec3f a = swapped ? w : v, b = swapped ? v : w, ab = b - a;
    EdgeFeature f;
    store(a, f.a);
    store(ab, f.ab);
    f.length2 = (ab.x * ab.x + ab.y * ab.y) + ab.z * ab.z;
    f.inv_length2 = 1.0f / f.length2;
    f.owner_edge =
        static_cast<uint32_t>(owner) << 3 | (swapped ? 4u : 0u) | static_cast<uint32_t>(own.side);
    tree->edges.push_back(f);
    ++leaf->edges;
    LeafSides::Edge sides{};
    const PointEdges& measured = edges_[static_cast<size_t>(edge.point)];
    sides.along = measured.along[static_cast<size_t>(edge.edge)];
    if (!(dot(sides.along, ab) > 0)) sides.along = sides.along * -1.0f;
    int i = 0;
    for (const Face& face : {own, other}) {
        const Wing of = wing(face);
        float* out = sides.wing[i++];
        if (!(of.rho > 0)) continue;
        store(to_vec(frames_[static_cast<size_t>(face.triangle)].m[face.side]) * of.rho, out);
        leaf->inv_reach = std::max(leaf->inv_reach, 1.0f / of.reach);
    }
    sides_.edges.push_back(sides);
}

/// Adds a vertex with four edges at most: the one that leads most into the part, which excludes
/// convex vertices as seen from there, then those around it that lie widest apart.
void LatticeLeaves::add_vertex(int32_t owner, int at_corner, int32_t a, int32_t b,
                               LeafFeatures* leaf, Tree* tree) {
    const int32_t here = cells_.vertex(a, b);
    VertexFeature f;
    // Both zeros count as one position; sums of it have no negative zero.
    store(positions_[here] + Vec3f{0, 0, 0}, f.v);
    f.owner_corner = static_cast<uint32_t>(owner) << 2 | static_cast<uint32_t>(at_corner);
    tree->vertices.push_back(f);
    ++leaf->vertices;
    const Vec3f normal = to_vec(tree->frames[static_cast<size_t>(owner)].n);
    std::array<Vec3f, 6> spoke;  // around the vertex
    size_t spokes = 0, into = 0;
    float shortest = kInfinity, deepest = kInfinity;
    // An edge is measured at the point (of_a, of_b).
    const auto add = [&](bool present, int32_t of_a, int32_t of_b, size_t edge, float sign) {
        if (!present) return;
        const PointEdges& of = edges_[static_cast<size_t>(cells_.vertex(of_a, of_b))];
        if (!(of.length[edge] > 0)) return;
        const Vec3f d = of.along[edge] * sign;
        const float along = dot(d, normal);
        if (along < deepest) {
            deepest = along;
            into = spokes;
        }
        spoke[spokes++] = d;
        shortest = std::min(shortest, of.length[edge]);
    };
    const auto is = [](int32_t triangle) { return triangle >= 0; };
    const bool ur = is(cells_.upper(a, b)), ul = is(cells_.upper(a - 1, b)),
               ud = is(cells_.upper(a, b - 1)), ll = is(cells_.lower(a - 1, b)),
               ld = is(cells_.lower(a - 1, b - 1)), lr = is(cells_.lower(a, b - 1));
    add(ur || lr, a, b, 0, 1.0f);
    add(ur || ll, a, b, 1, 1.0f);
    add(ll || ul, a - 1, b, 2, 1.0f);
    add(ul || ld, a - 1, b, 0, -1.0f);
    add(ld || ud, a, b - 1, 1, -1.0f);
    add(ud || lr, a, b - 1, 2, -1.0f);
    LeafSides::Vertex sides;
    const auto take = [&](size_t steps) {
        sides.direction[static_cast<size_t>(sides.count++)] = spoke[(into + steps) % spokes];
    };
    if (spokes <= kHalfSpaces) {
        for (size_t i = 0; i < spokes; ++i)
            take(i);
    } else {
        for (const size_t i :
             {size_t{0}, size_t{2}, spokes - 2, spokes == 6 ? size_t{3} : size_t{1}})
            take(i);
    }
    if (spokes > 0) leaf->inv_reach = std::max(leaf->inv_reach, 1.0f / shortest);
    sides_.vertices.push_back(sides);
}

LatticeLeaves::Area LatticeLeaves::add_triangle(int32_t triangle, Tree* tree) const {
    const auto t = static_cast<size_t>(triangle);
    tree->frames.push_back(unit_ != nullptr ? unit_->frame(first_in_unit_ + t) : frames_[t]);
    tree->details.push_back(unit_ != nullptr ? unit_->detail(first_in_unit_ + t) : details_[t]);
    const TriangleDetail& detail = tree->details.back();
    const Vec3f v0 = to_vec(tree->frames.back().v0);
    const Vec3f facing = cross(to_vec(detail.v1) - v0, to_vec(detail.v2) - v0);
    return {facing, length(facing)};
}

void LatticeLeaves::add_features_of_upper(int32_t a, int32_t b, int32_t owner, LeafFeatures* leaf,
                                          Tree* tree) {
    const int32_t t = cells_.upper(a, b), below = cells_.lower(a, b - 1),
                  left = cells_.lower(a - 1, b);
    const int32_t here = cells_.vertex(a, b);
    if (below < 0) add_edge(owner, {here, 0}, {t, 0}, {-1, 0}, leaf, tree);
    add_edge(owner, {here, 2}, {t, 1}, {cells_.lower(a, b), 2}, leaf, tree);
    if (left < 0) add_edge(owner, {here, 1}, {t, 2}, {-1, 0}, leaf, tree);
}

void LatticeLeaves::add_features_of_lower(int32_t a, int32_t b, int32_t owner, LeafFeatures* leaf,
                                          Tree* tree) {
    const int32_t t = cells_.lower(a, b);
    add_edge(owner, {cells_.vertex(a + 1, b), 1}, {t, 0}, {cells_.upper(a + 1, b), 2}, leaf, tree);
    add_edge(owner, {cells_.vertex(a, b + 1), 0}, {t, 1}, {cells_.upper(a, b + 1), 0}, leaf, tree);
    if (cells_.upper(a, b) < 0)
        add_edge(owner, {cells_.vertex(a, b), 2}, {t, 2}, {-1, 0}, leaf, tree);
}

/// Calls visit(a, b, whether it is the lower one) for the triangles of a block in their order.
template <typename Visit>
void LatticeLeaves::each_triangle(const CellBlock& block, const Visit& visit) const {
    const CellBlock in = cells_.clip(block);
    for (int32_t b = in.b; b < in.b + in.height; ++b) {
        for (int32_t a = in.a; a < in.a + in.width; ++a) {
            if (cells_.upper(a, b) >= 0) visit(a, b, false);
            if (cells_.lower(a, b) >= 0) visit(a, b, true);
        }
    }
}

LatticeLeaves::Area LatticeLeaves::append(const CellBlock& block, LeafFeatures* leaf, Tree* tree) {
    *leaf = {};
    leaf->first_edge = static_cast<uint32_t>(tree->edges.size());
    leaf->first_vertex = static_cast<uint32_t>(tree->vertices.size());
    sides_.clear();
    const size_t first = tree->frames.size();
    const auto triangle = [&](int32_t a, int32_t b, bool is_lower) {
        return is_lower ? cells_.lower(a, b) : cells_.upper(a, b);
    };
    Area area;
    each_triangle(block, [&](int32_t a, int32_t b, bool is_lower) {
        area.add(add_triangle(triangle(a, b, is_lower), tree));
    });
    if (unit_ == nullptr) {
        add_own_features(block, leaf, tree);
    } else {
        const auto each = [&](const auto& append_features) {
            auto owner = static_cast<uint32_t>(first);
            each_triangle(block, [&](int32_t a, int32_t b, bool is_lower) {
                const auto t = static_cast<size_t>(triangle(a, b, is_lower));
                (unit_->*append_features)(first_in_unit_ + t, owner++, leaf, &sides_, tree);
            });
        };
        each(&UnitFeatures::append_edges);
        each(&UnitFeatures::append_vertices);
    }
    write_half_spaces(first, tree->frames.size() - first, leaf, tree);
    return area;
}

/// Adds the edges, then the vertices.
void LatticeLeaves::add_own_features(const CellBlock& block, LeafFeatures* leaf, Tree* tree) {
    const size_t first = tree->frames.size() - static_cast<size_t>(cells_.count(block));
    auto owner = static_cast<int32_t>(first);
    each_triangle(block, [&](int32_t a, int32_t b, bool is_lower) {
        if (is_lower) {
            add_features_of_lower(a, b, owner++, leaf, tree);
        } else {
            add_features_of_upper(a, b, owner++, leaf, tree);
        }
    });
    owner = static_cast<int32_t>(first);
    const auto upper = [&](int32_t a, int32_t b) { return cells_.upper(a, b) >= 0; };
    const auto lower = [&](int32_t a, int32_t b) { return cells_.lower(a, b) >= 0; };
    each_triangle(block, [&](int32_t a, int32_t b, bool is_lower) {
        if (!is_lower) {
            const bool below = lower(a, b - 1), left = lower(a - 1, b);
            if (!below && !left && !lower(a - 1, b - 1) && !upper(a, b - 1) && !upper(a - 1, b))
                add_vertex(owner, 0, a, b, leaf, tree);
            if (!below && !upper(a + 1, b - 1) && !lower(a + 1, b - 1))
                add_vertex(owner, 1, a + 1, b, leaf, tree);
            if (!left) add_vertex(owner, 2, a, b + 1, leaf, tree);
        } else {
            if (!upper(a, b) && !lower(a, b - 1) && !upper(a + 1, b - 1) && !lower(a + 1, b - 1))
                add_vertex(owner, 0, a + 1, b, leaf, tree);
            add_vertex(owner, 1, a + 1, b + 1, leaf, tree);
            if (!upper(a, b) && !lower(a - 1, b)) add_vertex(owner, 2, a, b + 1, leaf, tree);
        }
        ++owner;
    });
}

void LatticeLeaves::write_half_spaces(size_t first, size_t count, LeafFeatures* of, Tree* tree) {
    LeafFeatures& leaf = *of;
    std::copy_n(tree->frames[first].v0, 3, leaf.origin);
    const Vec3f origin = to_vec(leaf.origin);
    LeafHalfSpaces all(leaf.origin);
    float farthest2 = 0;
    for (size_t i = first; i < first + count; ++i) {
        all.add_face(tree->frames[i], tree->details[i]);
        for (int k = 0; k < 3; ++k) {
            const Vec3f d = corner(tree->frames[i], tree->details[i], k) - origin;
            farthest2 = std::max(farthest2, dot(d, d));
        }
    }
    leaf.step = std::sqrt(farthest2) * 1.001f / LeafHalfSpaces::kMaxValue;
    for (size_t i = 0; i < sides_.edges.size(); ++i)
        all.add_edge(tree->edges[leaf.first_edge + i], sides_.edges[i].along, sides_.edges[i].wing);
    for (size_t i = 0; i < sides_.vertices.size(); ++i) {
        const Vec3f v = to_vec(tree->vertices[leaf.first_vertex + i].v);
        for (int k = 0; k < sides_.vertices[i].count; ++k)
            all.add(sides_.vertices[i].direction[static_cast<size_t>(k)], v);
        all.next_feature();
    }
    const size_t features = count + size_t{leaf.edges} + leaf.vertices;
    std::vector<int16_t>& values = tree->half_spaces.values;
    // The last vectors are written whole, and what follows overwrites them.
    if (values.empty()) values.resize(kHalfSpaceLanes);
    const size_t used = values.size() - kHalfSpaceLanes;
    leaf.first_half_space = static_cast<uint32_t>(used / HalfSpaces::kValues);
    values.resize(values.size() + features * HalfSpaces::kValues);
    all.write(leaf.step, values.data() + used);
}

}  // namespace openfab::nearest
