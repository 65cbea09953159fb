// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/cones.h"

#include <algorithm>
#include <cmath>

#include "base/vec.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/vec_arrays.h"

namespace openfab::nearest {
namespace {

/// Sine of the widest cone; wider ones are not worth testing and count as not known.
constexpr float kMaxSine = 0.7f;
/// Least scale of a half-space; thin triangles have smaller ones (tree/features.h), which prune too
/// little.
constexpr float kMinScale = 0.25f;

/// Accumulates the cone over the features of a leaf.
struct Sum {
    float sine2 = 0;  ///< of the largest angle
    float rise = 0;   ///< tangent of the largest angle of a vertex's cone
    float scale = 1;  ///< the least of a half-space across the axis
    float inv_reach = 0;
    bool known = true;

    /// Adds a normal n with squared length l2.
    void add_normal(const Vec3f& axis, const Vec3f& n, float l2) {
        const float along = dot(axis, n);
        sine2 = std::max(sine2, 1 - along * along / l2);
    }
};

void add(const TriangleFrame& face, const Node& node, Sum* sum) {
    const Vec3f n = to_vec(face.n);
    // A triangle without area is its edges.
    if (!(n == Vec3f{0, 0, 0})) sum->add_normal(to_vec(node.axis[2]), n, 1);
}

/// Adds an edge: its cone lies between the normals of its faces, the first of which is in the leaf.
void add(const EdgeFeature& edge, const EdgeHalfSpaces& half_spaces, const Node& node, Sum* sum) {
    const Vec3f own = to_vec(half_spaces.wing[0]), other = to_vec(half_spaces.wing[1]);
    const float scale2 = std::min(dot(own, own), dot(other, other));
    if (!(scale2 >= kMinScale * kMinScale) || !(dot(own, other) < 0)) {
        sum->known = false;
        return;
    }
    sum->add_normal(to_vec(node.axis[2]), cross(other, to_vec(edge.ab)),
                    dot(other, other) * edge.length2);
    // A wing leans from the plane across the axis by no more than the normal does from the axis.
    constexpr float kMinCosine = 0.7f;
    sum->scale = std::min(sum->scale, kMinCosine * std::sqrt(scale2));
    sum->inv_reach = std::max(sum->inv_reach, half_spaces.inv_reach);
}

/// Adds a vertex: any direction between two consecutive edges around the axis is within half their
/// angle of one of them, and rises no faster than the steeper one.
void add(const VertexHalfSpaces& vertex, const Node& node, Sum* sum) {
    constexpr int kMaxDirections = VertexHalfSpaces::kMaxDirections;
    float x[kMaxDirections], y[kMaxDirections], rise[kMaxDirections], least_across = 1;
    int count = 0;
    for (const auto& direction : vertex.direction) {
        const Vec3f d = to_vec(direction);
        const float along_x = dot(d, to_vec(node.axis[0])), along_y = dot(d, to_vec(node.axis[1]));
        const float across = std::sqrt(along_x * along_x + along_y * along_y);
        // Means of edges, which are shorter, are of no use either.
        if (!(across > kMinScale) || dot(d, d) < 0.99f) continue;
        x[count] = along_x / across;
        y[count] = along_y / across;
        rise[count++] = std::abs(dot(d, to_vec(node.axis[2]))) / across;
        least_across = std::min(least_across, across);
    }
    float least_half = 1;
    for (int i = 0; i < count; ++i) {
        float cosine = -1, steeper = 0;
        for (int j = 0; j < count; ++j) {
            const float c = x[i] * x[j] + y[i] * y[j];
            if (!(x[i] * y[j] - y[i] * x[j] > 0) || !(c > cosine)) continue;
            cosine = c;
            steeper = std::max(rise[i], rise[j]);
        }
        const float half = std::sqrt(0.5f * (1 + cosine));
        least_half = std::min(least_half, half);
        sum->rise = std::max(sum->rise, steeper / half);
    }
    const float scale = least_half * least_across;
    if (count < 3 || !(scale >= kMinScale)) {
        sum->known = false;
        return;
    }
    sum->scale = std::min(sum->scale, scale);
    sum->inv_reach = std::max(sum->inv_reach, vertex.inv_reach);
}

NodeCone of_leaf(const Tree& tree, const Features& f, const Node& leaf) {
    if (leaf.count() == 0) return {};
    Sum sum;
    const size_t first = leaf.first(), end = first + leaf.count();
    for (size_t i = first; i < end; ++i)
        add(tree.frames[i], leaf, &sum);
    for (size_t i = f.first_edge[first]; i < f.first_edge[end] && sum.known; ++i)
        add(f.edges[i], f.edge_half_spaces[i], leaf, &sum);
    for (size_t i = f.first_vertex[first]; i < f.first_vertex[end] && sum.known; ++i)
        add(f.vertex_half_spaces[i], leaf, &sum);
    // Rounding error of 1 - cosine² for a cosine near 1.
    constexpr float kRounding2 = 0x1p-20f;
    const float rise2 = sum.rise * sum.rise;
    const float sine = std::sqrt(std::max(sum.sine2 + kRounding2, rise2 / (1 + rise2)));
    if (!sum.known || !(sine < kMaxSine)) return {};
    const float offset = 1 / sum.scale;
    return {sine, offset, offset * sum.inv_reach};
}

NodeCone of_children(const Tree& tree, const Node& node, const std::vector<NodeCone>& cones) {
    NodeCone sum{0, 0, 0};
    for (uint32_t i = node.child(); i < node.child() + node.children(); ++i) {
        const NodeCone& cone = cones[i];
        const float turn = length(cross(to_vec(node.axis[2]), to_vec(tree.nodes[i].axis[2])));
        if (!(cone.sine < kMaxSine && turn < kMaxSine)) return {};
        // sin(a + b); both are below a quarter of pi.
        const float sine =
            turn * std::sqrt(1 - cone.sine * cone.sine) + cone.sine * std::sqrt(1 - turn * turn);
        sum = {std::max(sum.sine, sine), std::max(sum.offset, cone.offset),
               std::max(sum.offset_by_reach, cone.offset_by_reach)};
    }
    return sum.sine < kMaxSine ? sum : NodeCone{};
}

}  // namespace

std::vector<NodeCone> make_cones(const Tree& tree, const Features& features) {
    std::vector<NodeCone> cones(tree.nodes.size());
    // Children come after their parents.
    for (size_t i = tree.nodes.size(); i-- > 0;) {
        const Node& node = tree.nodes[i];
        cones[i] = node.is_leaf() ? of_leaf(tree, features, node) : of_children(tree, node, cones);
    }
    return cones;
}

}  // namespace openfab::nearest
