// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The normal cones of a tree's nodes. Where x is the point of the surface that is nearest to p,
// p - x lies in the normal cone of the feature that x is on: along a face's normal, between those
// of the faces at an edge, or so that it leads away from all edges at a vertex. Small pieces of a
// smooth surface have narrow cones, so a node matters to the points straight above and below it
// alone, and not to all that are near.

#include <vector>

namespace openfab::nearest {

struct Features;
struct Tree;

struct NodeCone {
    /// Sine of the largest angle between a node's last axis, either way, and the normal cones of
    /// the features in it; 1 where nothing is known.
    float sine = 1;
    /// A feature still wins by rounding where a point is off its half-spaces by x max(1, x
    /// inv_reach) (nearest/features.h), x being what squared distances may be wrong by. Then it is
    /// off the cone by x max(stray, x stray_by_reach) across that axis at most.
    float stray = 0, stray_by_reach = 0;
};

/// Of each node of the tree, whose features these are.
std::vector<NodeCone> make_cones(const Tree& tree, const Features& features);

}  // namespace openfab::nearest
