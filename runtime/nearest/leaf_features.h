// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The features of each leaf, and the half-spaces that tell in which boxes none of them is nearest
// to any point: faces, edges and vertices alike have up to four, numbers of 16 bits that lie side
// by side, a feature a lane, so that whatever a leaf holds is tested at once.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace openfab::nearest {

struct Tree;
struct Features;

/// Of each feature. Nothing is nearest to it beyond one of them.
constexpr int kSides = 4;

/// The faces of a leaf are its triangles; edges and vertices follow each other in the tree.
struct LeafFeatures {
    uint32_t first_edge = 0, first_vertex = 0;
    uint16_t edges = 0, vertices = 0;
    uint32_t first_half_space = 0;  ///< how many features come before these among the tree's
    float origin[3] = {};           ///< mm
    float step = 0;                 ///< of their offsets, mm
    float inv_reach = 0;            ///< the largest of its features' (nearest/features.h)
};

/// Of each leaf: values[side][x, y, z, offset][feature], faces, edges and vertices. No point p is
/// nearest to a feature where, for any side,
///     dot(value xyz / kUnit, p - origin) + offset * step > limit,
/// the limit being what rounding may do: for the sides of faces and the two last of edges that of
/// a distance; for the others more (kernel_sides.inl).
struct HalfSpaces {
    static constexpr float kUnit = 32768;
    static constexpr size_t kValues = kSides * 4;  ///< of a feature
    std::vector<int16_t> values;                   ///< and as many as a vector holds
};

/// Fills tree->leaves, one for each node, and tree->half_spaces.
void make_leaf_features(const Features& features, Tree* tree);

}  // namespace openfab::nearest
