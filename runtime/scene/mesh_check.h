// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh must be before it can be printed: closed, of one orientation, with a volume.

#include <string>
#include <vector>

#include "runtime/base/result.h"
#include "runtime/scene/mesh.h"

namespace openfab::scene {

/// How often edges are used, counting each undirected edge once.
struct EdgeCounts {
    int64_t open = 0;          ///< one triangle
    int64_t non_manifold = 0;  ///< three or more
    int64_t inconsistent = 0;  ///< two, in the same direction
    int32_t triangle = -1;     ///< a triangle at the first bad edge, in order of triangles
    Vec3d from, to;            ///< that edge
    int64_t bad() const { return open + non_manifold + inconsistent; }
    bool fine() const { return bad() == 0; }
};

EdgeCounts count_edges(const Mesh& mesh);

/// Where triangle t comes from, for messages: `path:line:column`.
struct MeshOrigin {
    std::string file;
    std::vector<int32_t> lines;  ///< by triangle; empty where there is no file
    std::string str(int32_t triangle) const;
};

/// Makes a mesh fit to print, or says why it is not, with counts and one place:
/// vertices of equal positions (and of the same part, where `parts` gives one for each) are welded
/// if the mesh is open as it stands; triangles with two
/// equal corners are dropped with a warning; open, non-manifold and inconsistently oriented meshes
/// and those without volume are refused; closed shells of negative volume that no other shell
/// encloses are flipped with a warning; a size under 1 mm or over 1 m is a warning, over 100 m or
/// not finite an error. Vertices that no triangle uses are dropped.
Result<void> prepare_mesh(Mesh* mesh, MeshOrigin* origin, std::vector<std::string>* warnings,
                          const std::vector<int32_t>& parts = {});

}  // namespace openfab::scene
