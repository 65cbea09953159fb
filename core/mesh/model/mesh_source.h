// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh during import: the contents of its file, and the results of checking it.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/source_location.h"
#include "mesh/model/look.h"
#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// What a face belongs to. Materials are told apart by their looks, since names may repeat.
struct FaceGroup {
    std::vector<std::string> names;  ///< OBJ `g`, STL solid, glTF node, 3MF object
    std::string material;            ///< OBJ `usemtl`, glTF material, 3MF base material
    int32_t look = -1;               ///< index in MeshSource::looks; -1: the file says nothing
    int32_t body = 0;                ///< index in MeshSource::bodies
    auto operator<=>(const FaceGroup&) const = default;
};

/// The origin of triangles in their file, for messages.
struct MeshOrigin {
    std::string file;
    std::vector<int32_t> lines;  ///< by triangle; empty where there is no file
    SourceLocation location(int32_t triangle) const;
    std::string str(int32_t triangle) const { return location(triangle).str(); }
};

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

/// Counts of what was found in a mesh.
struct MeshChecks {
    EdgeCounts edges;
    int64_t equal_corners = 0;      ///< triangles with two equal corners; left out
    int64_t duplicates = 0;         ///< triangles over the corners of another one; left out
    int64_t without_area = 0;       ///< triangles with collinear corners; kept
    int64_t shells = 0;             ///< connected by edges
    int64_t turned = 0;             ///< shells that were inside out
    int64_t cavities = 0;           ///< shells that bound a hollow
    int64_t nested = 0;             ///< shells inside others that are not cavities
    int64_t overlapping = 0;        ///< pairs of shells that share volume, neither inside the other
    int64_t intersections = -1;     ///< pairs of triangles that cross; -1: not searched for
    bool all_intersections = true;  ///< false: there may be more than those counted
};

/// A mesh as its file has it.
struct MeshSource {
    /// The mesh in the file's unit. Corners of float attributes may be -1 where a face has no
    /// value.
    Mesh mesh;
    MeshOrigin origin;
    double unit_mm = 0;  ///< from the file or its format, 0 if unknown; after conversion to mm,
                         ///< the unit that was assumed
    std::vector<FaceGroup> groups;        ///< no two equal
    std::vector<int32_t> face_groups;     ///< by triangle, index in groups; empty without groups
    std::vector<int32_t> part_of_vertex;  ///< vertices of different parts are never welded; may be
                                          ///< empty: one part
    std::vector<std::filesystem::path> files;  ///< read besides the mesh file
    std::vector<std::string> warnings;
    std::vector<std::string> of_size;  ///< those of the unit and the size, which a scale may settle
    std::vector<Look> looks;
    std::vector<Body> bodies;  ///< empty: one, without a name
    std::vector<LeftOut> left_out;
    bool corners_joined =
        false;  ///< by join_corners: the file has no vertices, but three a triangle
    bool corners_apart = false;  ///< no two are equal: nothing was scaled or moved since
    MeshChecks checks;

    /// Tells that something is left out; the same `what` is told once and counted.
    void leave_out(const std::string& what, const std::string& place, const std::string& remedy);

    /// Formats a position in mm for messages, with its coordinates in the file if they differ.
    std::string location(const Vec3d& mm) const;

    /// Returns the index of `group`, adding it if it is new.
    int32_t group_index(const FaceGroup& group);
    /// Returns the bytes of the groups; names may be long, and one may be in many groups.
    int64_t group_bytes() const { return group_bytes_; }

  private:
    int64_t group_bytes_ = 0;
    std::map<FaceGroup, int32_t> group_indices_;
};

}  // namespace openfab::mesh
