// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cuts meshes by planes, like a CAD program that exports the pieces of an assembly: both pieces
// have the same vertices along the cut, rounded to float, and the same cap from either side.

#include <array>
#include <vector>

#include "base/vec.h"
#include "mesh/model/mesh.h"

namespace openfab::testing {

using CutTriangle = std::array<Vec3d, 3>;

/// One piece of a cut mesh, closed by caps.
struct CutPiece {
    std::vector<CutTriangle> outer, caps;

    bool empty() const { return outer.empty() && caps.empty(); }
    mesh::Mesh mesh(bool with_caps = true) const;
};

struct CutPlane {
    Vec3d normal;
    double offset = 0;  ///< dot(normal, p) on the plane

    double side(const Vec3d& p) const { return dot(normal, p) - offset; }
};

/// Rounds positions to float, as in most files.
CutPiece whole(const mesh::Mesh& mesh);

/// Returns the pieces above and below the plane. Each cap is a fan around the center of its
/// outline: for outlines that are not star-shaped its triangles overlap and cancel.
std::array<CutPiece, 2> cut(const CutPiece& piece, const CutPlane& plane);

}  // namespace openfab::testing
