// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Assembles a mesh from the parts of a scene file, whose attributes may differ.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mesh/model/mesh_memory.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// A mesh under construction.
class MeshAssembly {
  public:
    static constexpr size_t kMaxAttributes = 64;

    /// Reserves memory for the whole mesh.
    void reserve(const MeshCounts& counts);

    /// Vertices from here on are never welded to earlier ones.
    void begin_part() { ++part_; }

    int32_t add_vertex(const Vec3d& position);

    /// Finds or adds a float attribute; none if it exists with another number of components, or
    /// there are already kMaxAttributes.
    std::optional<size_t> attribute(const std::string& name, int32_t components);

    /// Adds a value of an attribute; returns its index, or -1 if a component is not finite.
    int32_t add_value(size_t attribute, const double* components);

    void add_triangle(const std::array<int32_t, 3>& vertices, int32_t group);

    /// Sets the values of an attribute at the corners of the last triangle.
    void set_corners(size_t attribute, const std::array<int32_t, 3>& values);

    size_t triangles() const { return source_.mesh.triangles.size(); }
    size_t vertices() const { return source_.mesh.positions.size(); }
    std::vector<std::string>& warnings() { return source_.warnings; }
    std::vector<Look>& looks() { return source_.looks; }
    std::vector<Body>& bodies() { return source_.bodies; }
    void leave_out(const std::string& what, const std::string& place, const std::string& remedy) {
        source_.leave_out(what, place, remedy);
    }
    int64_t group_bytes() const { return source_.group_bytes(); }
    int32_t group_index(const FaceGroup& group) { return source_.group_index(group); }

    /// Returns the mesh; corners without a value are -1.
    MeshSource finish(const std::string& file, double unit_mm);

  private:
    MeshSource source_;
    MeshCounts reserved_;
    int32_t part_ = 0;
};

}  // namespace openfab::mesh
