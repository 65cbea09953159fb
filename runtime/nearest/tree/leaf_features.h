// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The features of each leaf, and their half-spaces, which tell that a feature is nearest to no
// point of a box. Faces, edges and vertices alike have up to four, in 16-bit numbers side by side,
// one feature per lane, so that all features of a leaf are tested at once.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace openfab::nearest {

struct Tree;
struct Features;

/// Half-spaces per feature: a point outside any of them is not nearest to the feature.
constexpr int kHalfSpaces = 4;

/// The features of a leaf. Its faces are its triangles; edges and vertices are consecutive in the
/// tree. A leaf that stands for a tree (Node) may have vertices, which are surface points in it.
struct LeafFeatures {
    uint32_t first_edge = 0, first_vertex = 0;
    uint16_t edges = 0, vertices = 0;
    uint32_t first_half_space = 0;  ///< number of features of the tree before these
    float origin[3] = {};           ///< mm
    float step = 0;                 ///< unit of the half-spaces' offsets, mm
    float inv_reach = 0;            ///< largest of its features (tree/features.h)
};

/// The half-spaces of a tree. For each leaf values[half-space][x, y, z, offset][feature]: faces,
/// then edges, then vertices. A point p is not nearest to a feature if, for any of its half-spaces,
///     dot(value xyz / kUnit, p - origin) + offset * step > limit,
/// where the limit bounds the rounding: of a distance for faces and for the last two of edges;
/// larger for the others (kernel/half_spaces.h).
struct HalfSpaces {
    static constexpr float kUnit = 32768;
    static constexpr size_t kValues = kHalfSpaces * 4;  ///< per feature
    std::vector<int16_t> values;                        ///< padded by one vector
};

/// Fills tree->leaves, one per node, and tree->half_spaces.
void make_leaf_features(const Features& features, Tree* tree);

}  // namespace openfab::nearest
