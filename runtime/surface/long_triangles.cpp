// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/long_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "runtime/surface/base_mesh.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/patch_table.h"

namespace openfab::surface {

namespace {

/// Returns the squared length, bitwise independent of the order of the ends.
double edge_length2(const Vec3d& a, const Vec3d& b) {
    const Vec3d d = position_less(a, b) ? b - a : a - b;
    return (d.x * d.x + d.y * d.y) + d.z * d.z;
}

/// Returns the maximum length of pieces of a long triangle's edges: its height, but no less than a
/// patch. 0 if the triangle is not long.
double piece_length(const Vec3d& a, const Vec3d& b, const Vec3d& c, double micro_edge_mm) {
    const double longest2 = std::max({edge_length2(a, b), edge_length2(b, c), edge_length2(c, a)});
    const double least = kMinLongFactor * micro_edge_mm;
    if (!(longest2 > least * least)) return 0;
    const double longest = std::sqrt(longest2);
    // Too fine to be diced, which is reported later.
    if (!(longest / micro_edge_mm <= kMaxEdgeFactor)) return 0;
    const double height = length(cross(b - a, c - a)) / longest;
    if (!(longest > kMaxSlenderness * height)) return 0;
    return std::max(height, kTileEdges * micro_edge_mm);
}

struct PositionLess {
    bool operator()(const Vec3d& a, const Vec3d& b) const { return position_less(a, b); }
};

class Splitter {
  public:
    Splitter(const part::PartMesh& mesh, double micro_edge_mm, std::vector<uint8_t> displaced)
        : mesh_(mesh), micro_edge_mm_(micro_edge_mm), displaced_(std::move(displaced)) {}

    std::shared_ptr<const part::PartMesh> run();

  private:
    /// A triangle in progress: welded vertices, the triangle of the mesh that it came from, and the
    /// indices of its corners' values.
    struct Triangle {
        std::array<int32_t, 3> vertex;
        std::array<int32_t, 3> values;  ///< index in values_, in strides
        int32_t from;
        bool needle = false;  ///< to be cut across; its edges may be cut anywhere
    };
    using Edge = std::array<int32_t, 2>;  ///< the lower number first
    struct EdgeHash {
        size_t operator()(const Edge& e) const {
            const uint64_t both = static_cast<uint64_t>(static_cast<uint32_t>(e[0])) << 32 |
                                  static_cast<uint32_t>(e[1]);
            return static_cast<size_t>((both * 0x9e3779b97f4a7c15u) >> 17);
        }
    };

    /// Points along a side, including its ends: vertices, and the indices of their values.
    struct Chain {
        std::vector<int32_t> vertex, values;
    };

    void weld();
    void lay_out_values();
    const Vec3d& at(int32_t vertex) const { return positions_[vertex]; }
    int longest(const Triangle& t) const;
    double side_length2(const Triangle& t, int side) const {
        const Edge e = edge(t, side);
        return edge_length2(at(e[0]), at(e[1]));
    }
    static Edge edge(int32_t a, int32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }
    static Edge edge(const Triangle& t, int side) {
        return edge(t.vertex[side], t.vertex[static_cast<size_t>((side + 1) % 3)]);
    }
    /// Returns the vertex at the midpoint of an edge, -1 if it is not split.
    int32_t middle_if(const Edge& e) const {
        if (ends_[e[0]] == 0 || ends_[e[1]] == 0) return -1;
        const auto found = middles_.find(e);
        return found == middles_.end() ? -1 : found->second;
    }
    int32_t middle_of(const Edge& e);
    void cut(const Edge& e, double most2);
    int32_t middle_values(int32_t a, int32_t b, int32_t values_a, int32_t values_b);
    std::array<Triangle, 2> halve(const Triangle& t, int side);
    void find_needles();
    bool halve_cut();
    void add_points(int32_t b, int32_t values_b, Chain* chain);
    void add_needle(const Triangle& t, std::vector<Triangle>* out);
    std::shared_ptr<const part::PartMesh> result() const;

    const part::PartMesh& mesh_;
    const double micro_edge_mm_;
    const std::vector<uint8_t> displaced_;  ///< [triangle of the mesh]
    std::vector<Vec3d> positions_;          ///< welded, then middles
    std::map<Vec3d, int32_t, PositionLess> added_;
    size_t welded_ = 0;  ///< of positions_ those of the mesh, in order
    std::vector<Triangle> triangles_;
    std::unordered_map<Edge, int32_t, EdgeHash> middles_;  ///< of edges that are cut
    std::vector<uint8_t> ends_;                            ///< [vertex] of one of them
    size_t stride_ = 0;
    std::vector<float> values_;  ///< [stride]: normal, uv, inputs and @nearest attributes
};

void Splitter::weld() {
    std::vector<int32_t> order(mesh_.positions.size());
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int32_t i) -> const Vec3d& { return mesh_.positions[i]; };
    std::sort(order.begin(), order.end(),
              [&](int32_t a, int32_t b) { return position_less(place(a), place(b)); });
    std::vector<int32_t> rank(order.size());
    for (const int32_t i : order) {
        if (positions_.empty() || position_less(positions_.back(), place(i)))
            positions_.push_back(place(i));
        rank[i] = static_cast<int32_t>(positions_.size()) - 1;
    }
    welded_ = positions_.size();
    triangles_.reserve(mesh_.triangles.size());
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
        Triangle out;
        for (size_t c = 0; c < 3; ++c) {
            out.vertex[c] = rank[static_cast<size_t>(mesh_.triangles[t][c])];
            out.values[c] = static_cast<int32_t>(3 * t + c);
        }
        out.from = static_cast<int32_t>(t);
        triangles_.push_back(out);
    }
}

/// Calls visit(values of all corners, components a corner) for all that is interpolated.
template <typename Mesh, typename Visit>
void each_channel(Mesh& mesh, const Visit& visit) {
    if (!mesh.corner_uv.empty()) visit(mesh.corner_uv, size_t{2});
    for (auto* all : {&mesh.inputs, &mesh.nearest_attributes}) {
        for (auto& attribute : *all) {
            if (!attribute.corner_values.empty())
                visit(attribute.corner_values, static_cast<size_t>(attribute.components));
        }
    }
}

void Splitter::lay_out_values() {
    const size_t corners = 3 * mesh_.triangles.size();
    const bool normals = !mesh_.corner_normals.empty();
    stride_ = normals ? 3 : 0;
    each_channel(mesh_, [&](const std::vector<float>&, size_t n) { stride_ += n; });
    values_.resize(corners * stride_);
    for (size_t c = 0; c < corners; ++c) {
        float* to = values_.data() + c * stride_;
        if (normals) {
            for (int a = 0; a < 3; ++a)
                *to++ = mesh_.corner_normals[c][a];
        }
        each_channel(mesh_, [&](const std::vector<float>& from, size_t n) {
            to = std::copy_n(from.data() + c * n, n, to);
        });
    }
}

/// Returns the longest side; ties go to the first by position, so that all triangles agree.
int Splitter::longest(const Triangle& t) const {
    int best = 0;
    double best2 = -1;
    std::array<Vec3d, 2> best_ends;
    for (int side = 0; side < 3; ++side) {
        const Edge e = edge(t, side);
        const double length2 = edge_length2(at(e[0]), at(e[1]));
        if (length2 < best2) continue;
        std::array<Vec3d, 2> ends{at(e[0]), at(e[1])};
        if (position_less(ends[1], ends[0])) std::swap(ends[0], ends[1]);
        const auto before = [&] {
            if (position_less(ends[0], best_ends[0])) return true;
            return !position_less(best_ends[0], ends[0]) && position_less(ends[1], best_ends[1]);
        };
        if (length2 == best2 && !before()) continue;
        best = side;
        best2 = length2;
        best_ends = ends;
    }
    return best;
}

int32_t Splitter::middle_of(const Edge& e) {
    if (const int32_t known = middle_if(e); known >= 0) return known;
    const bool forward = position_less(at(e[0]), at(e[1]));
    const Vec3d p = edge_position(at(e[forward ? 0 : 1]), at(e[forward ? 1 : 0]), 1, 2);
    const auto end = positions_.begin() + static_cast<std::ptrdiff_t>(welded_);
    const auto there = std::lower_bound(positions_.begin(), end, p, PositionLess{});
    int32_t middle;
    if (there != end && !position_less(p, *there)) {
        middle = static_cast<int32_t>(there - positions_.begin());
    } else {
        const auto [known, added] = added_.emplace(p, static_cast<int32_t>(positions_.size()));
        if (added) {
            positions_.push_back(p);
            ends_.push_back(0);
        }
        middle = known->second;
    }
    ends_[e[0]] = ends_[e[1]] = 1;
    middles_.emplace(e, middle);
    return middle;
}

/// Bisects until no piece's squared length exceeds `most2`.
void Splitter::cut(const Edge& e, double most2) {
    if (!(edge_length2(at(e[0]), at(e[1])) > most2)) return;
    const int32_t middle = middle_of(e);
    cut(edge(e[0], middle), most2);
    cut(edge(middle, e[1]), most2);
}

/// Makes the values midway between two corners; returns their index.
int32_t Splitter::middle_values(int32_t a, int32_t b, int32_t values_a, int32_t values_b) {
    if (stride_ == 0) return 0;
    const bool forward = position_less(at(a), at(b));
    const size_t lo = static_cast<size_t>(forward ? values_a : values_b) * stride_,
                 hi = static_cast<size_t>(forward ? values_b : values_a) * stride_;
    const size_t to = values_.size();
    values_.resize(to + stride_);
    for (size_t k = 0; k < stride_; ++k)
        values_[to + k] = edge_value(values_[lo + k], values_[hi + k], 1, 2);
    return static_cast<int32_t>(to / stride_);
}

/// Splits into (a, middle, c) and (middle, b, c), where the side runs from a to b.
std::array<Splitter::Triangle, 2> Splitter::halve(const Triangle& t, int side) {
    const auto a = static_cast<size_t>(side), b = static_cast<size_t>((side + 1) % 3),
               c = static_cast<size_t>((side + 2) % 3);
    const int32_t m = middle_of(edge(t, side));
    const int32_t values = middle_values(t.vertex[a], t.vertex[b], t.values[a], t.values[b]);
    return {{{{t.vertex[a], m, t.vertex[c]}, {t.values[a], values, t.values[c]}, t.from},
             {{m, t.vertex[b], t.vertex[c]}, {values, t.values[b], t.values[c]}, t.from}}};
}

/// Splits the edges of triangles that are cut across. A long triangle without a short edge is
/// bisected first, which leaves needles and compact triangles.
void Splitter::find_needles() {
    std::vector<Triangle> next, waiting;
    next.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
        waiting = {t};
        while (!waiting.empty()) {
            Triangle one = waiting.back();
            waiting.pop_back();
            const double piece = displaced_[one.from] == 0
                                     ? 0
                                     : piece_length(at(one.vertex[0]), at(one.vertex[1]),
                                                    at(one.vertex[2]), micro_edge_mm_);
            if (piece == 0) {
                next.push_back(one);
                continue;
            }
            const int side = longest(one);
            const double b2 = side_length2(one, (side + 1) % 3),
                         c2 = side_length2(one, (side + 2) % 3);
            if (4 * std::min(b2, c2) > std::max(b2, c2)) {
                const std::array<Triangle, 2> halves = halve(one, side);
                waiting.push_back(halves[1]);
                waiting.push_back(halves[0]);
                continue;
            }
            // Bisection gives between 3/4 and 3/2 of the desired length.
            const double most2 = 2.25 * piece * piece;
            for (int e = 0; e < 3; ++e)
                cut(edge(one, e), most2);
            one.needle = true;
            next.push_back(one);
        }
    }
    triangles_ = std::move(next);
}

/// Bisects triangles with a split edge, at their longest edge first. Each edge split for this is
/// longer than the previous one, so this terminates.
bool Splitter::halve_cut() {
    const auto is_cut = [&](const Triangle& t) {
        return !t.needle && (middle_if(edge(t, 0)) >= 0 || middle_if(edge(t, 1)) >= 0 ||
                             middle_if(edge(t, 2)) >= 0);
    };
    if (std::none_of(triangles_.begin(), triangles_.end(), is_cut)) return false;
    std::vector<Triangle> next, waiting;
    next.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
        waiting = {t};
        while (!waiting.empty()) {
            const Triangle one = waiting.back();
            waiting.pop_back();
            if (!is_cut(one)) {
                next.push_back(one);
                continue;
            }
            const std::array<Triangle, 2> halves = halve(one, longest(one));
            waiting.push_back(halves[1]);
            waiting.push_back(halves[0]);
        }
    }
    triangles_ = std::move(next);
    return true;
}

/// Continues from the chain's last point to vertex `b`.
void Splitter::add_points(int32_t b, int32_t values_b, Chain* chain) {
    const int32_t a = chain->vertex.back(), middle = middle_if(edge(a, b));
    if (middle >= 0) {
        const int32_t values = middle_values(a, b, chain->values.back(), values_b);
        add_points(middle, values, chain);
        add_points(b, values_b, chain);
        return;
    }
    chain->vertex.push_back(b);
    chain->values.push_back(values_b);
}

/// Cuts a needle across, from its tip to its base: always by the shorter of two edges.
void Splitter::add_needle(const Triangle& t, std::vector<Triangle>* out) {
    // The corner that is on both long sides is opposite the short one.
    int base = 0;
    for (int e = 1; e < 3; ++e) {
        if (side_length2(t, e) < side_length2(t, base)) base = e;
    }
    const auto b = static_cast<size_t>(base), c = static_cast<size_t>((base + 1) % 3),
               tip = static_cast<size_t>((base + 2) % 3);
    const auto chain_to = [&](size_t from, size_t to) {
        Chain chain{{t.vertex[from]}, {t.values[from]}};
        add_points(t.vertex[to], t.values[to], &chain);
        return chain;
    };
    const Chain right = chain_to(tip, b), left = chain_to(tip, c), end = chain_to(b, c);
    using Point = std::array<int32_t, 2>;  // vertex and values
    const auto at_right = [&](size_t i) { return Point{right.vertex[i], right.values[i]}; };
    const auto at_left = [&](size_t j) { return Point{left.vertex[j], left.values[j]}; };
    const auto at_end = [&](size_t k) { return Point{end.vertex[k], end.values[k]}; };
    const auto add = [&](const Point& p, const Point& q, const Point& r) {
        out->push_back({{p[0], q[0], r[0]}, {p[1], q[1], r[1]}, t.from});
    };
    const size_t i_end = right.vertex.size() - 1, j_end = left.vertex.size() - 1;
    // Both start at one point, and the first triangle takes one point of each.
    size_t i = 1, j = 0;
    while (i < i_end || j < j_end) {
        const bool to_left =
            j == 0 || i == i_end ||
            (j < j_end && edge_length2(at(right.vertex[i]), at(left.vertex[j + 1])) <
                              edge_length2(at(right.vertex[i + 1]), at(left.vertex[j])));
        const Point from = to_left ? at_left(j) : at_right(i);
        const Point across = to_left ? at_right(i) : at_left(j);
        (to_left ? j : i) += 1;
        if (i == i_end && j == j_end) {
            for (size_t k = 0; k + 1 < end.vertex.size(); ++k)
                add(from, at_end(k), at_end(k + 1));
        } else if (to_left) {
            add(at_left(j), from, across);
        } else {
            add(from, at_right(i), across);
        }
    }
}

std::shared_ptr<const part::PartMesh> Splitter::result() const {
    auto out = std::make_shared<part::PartMesh>();
    out->positions = positions_;
    out->center_part_mm = mesh_.center_part_mm;
    // Values at corners are filled below.
    out->inputs = mesh_.inputs;
    out->nearest_attributes = mesh_.nearest_attributes;
    const size_t corners = 3 * triangles_.size();
    if (!mesh_.corner_normals.empty()) out->corner_normals.resize(corners);
    if (!mesh_.corner_uv.empty()) out->corner_uv.resize(1);
    each_channel(*out, [&](std::vector<float>& values, size_t n) { values.resize(corners * n); });
    for (const Triangle& t : triangles_) {
        const size_t first = 3 * out->triangles.size();
        out->triangles.push_back(t.vertex);
        for (size_t c = 0; c < 3; ++c) {
            const float* from = values_.data() + static_cast<size_t>(t.values[c]) * stride_;
            if (!mesh_.corner_normals.empty()) {
                out->corner_normals[first + c] = {from[0], from[1], from[2]};
                from += 3;
            }
            each_channel(*out, [&](std::vector<float>& values, size_t n) {
                std::copy_n(from, n, values.data() + (first + c) * n);
                from += n;
            });
        }
    }
    const auto copy_faces = [&](const std::vector<part::PartAttribute>& from,
                                std::vector<part::PartAttribute>* to) {
        for (size_t i = 0; i < from.size(); ++i) {
            const std::vector<uint32_t>& old = from[i].face_values;
            if (old.empty()) continue;
            const auto n = static_cast<size_t>(from[i].components);
            std::vector<uint32_t>& faces = (*to)[i].face_values;
            faces.clear();
            for (const Triangle& t : triangles_) {
                const auto first =
                    old.begin() + static_cast<std::ptrdiff_t>(static_cast<size_t>(t.from) * n);
                faces.insert(faces.end(), first, first + static_cast<std::ptrdiff_t>(n));
            }
        }
    };
    copy_faces(mesh_.inputs, &out->inputs);
    copy_faces(mesh_.nearest_attributes, &out->nearest_attributes);
    return out;
}

std::shared_ptr<const part::PartMesh> Splitter::run() {
    weld();
    lay_out_values();
    ends_.assign(positions_.size(), 0);
    find_needles();
    if (middles_.empty()) return nullptr;
    while (halve_cut()) {
    }
    std::vector<Triangle> all;
    all.reserve(triangles_.size() + 2 * middles_.size());
    for (const Triangle& t : triangles_) {
        if (t.needle) {
            add_needle(t, &all);
        } else {
            all.push_back(t);
        }
    }
    triangles_ = std::move(all);
    return result();
}

}  // namespace

std::shared_ptr<const part::PartMesh> split_long_triangles(const part::PartMesh& mesh,
                                                           double micro_edge_mm,
                                                           std::vector<uint8_t> displaced) {
    return Splitter(mesh, micro_edge_mm, std::move(displaced)).run();
}

Result<std::shared_ptr<const part::PartMesh>> mesh_to_dice(const part::Part& part,
                                                           const SurfaceOptions& options) {
    const part::PartMesh& mesh = *part.mesh;
    if (part.fablet->has_surface == 0) return part.mesh;
    const auto long_one = [&](const std::array<int32_t, 3>& t) {
        const auto at = [&](size_t c) { return mesh.positions[t[c]]; };
        return piece_length(at(0), at(1), at(2), options.micro_edge_mm) > 0;
    };
    if (std::none_of(mesh.triangles.begin(), mesh.triangles.end(), long_one)) return part.mesh;
    if (Result<void> good = check_surface_input(part); !good) return good.error();
    BaseMesh base(part);
    const StaticArgs args(part);
    const NearestLayout nearest(*part.fablet);
    if (Result<void> done = classify(part, options, args, nearest, &base); !done)
        return done.error();
    std::vector<uint8_t> displaced(base.classes.size());
    std::transform(base.classes.begin(), base.classes.end(), displaced.begin(),
                   [](TriangleClass c) { return c == TriangleClass::kDisplaced ? 1 : 0; });
    std::shared_ptr<const part::PartMesh> split =
        split_long_triangles(mesh, options.micro_edge_mm, std::move(displaced));
    return split != nullptr ? split : part.mesh;
}

}  // namespace openfab::surface
