// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Normal cones of a tree's nodes. If x is the surface point nearest to p, then p - x lies in the
// normal cone of the feature that x is on: along the normal of a face, between those of the faces
// at an edge, or leading away from all edges at a vertex. Small pieces of a smooth surface have
// narrow cones, so a node matters only to points straight above and below it.

#include <vector>

namespace openfab::nearest {

struct Features;
struct Tree;

/// The normal cone of one node.
struct NodeCone {
    /// Sine of the largest angle between the node's last axis, in either direction, and the normal
    /// cones of the features in it; 1 if the cone is not known.
    float sine = 1;
    /// By rounding a feature can also win for a point outside its half-spaces by up to x max(1, x
    /// inv_reach) (tree/features.h), with x^2 the error of squared distances. Such a point is
    /// outside the cone by at most x max(offset, x offset_by_reach) across that axis.
    float offset = 0, offset_by_reach = 0;
};

/// Computes the cone of each node of the tree from its features.
std::vector<NodeCone> make_cones(const Tree& tree, const Features& features);

}  // namespace openfab::nearest
