// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes boundary meshes of the materials of a print, slice by slice.
//
// The mesh of a material is the boundary of the union of its voxels: closed, its triangles
// counter-clockwise seen from outside, its volume to the bit that of the voxels. Where two
// materials meet, both meshes have the same triangles, reversed. By vertex indices each mesh is a
// 2-manifold (fans.h); where voxels of a material touch only along an edge, two sheets of it
// coincide there.
//
// Files without vertex indices are read by position, so coincident vertices must be separated
// there. Each is moved by one step, 1/512 voxel, along each axis that its faces are across: into
// its own voxels. (Where two single voxels of others meet at their corners inside a material, its
// two vertices move into these, whose vertices follow.) No mesh intersects itself or another; where
// two would share a triangle there may be a gap of a step between them, and nothing else moves. A
// rectangle that is so long that a step would flip one of its triangles gets a rim of a quarter of
// a voxel around triangles that stay in place.
//
// Faces are merged into rectangles: across z in a whole plane, across x and y in one slice. There
// are no T-junctions: each rectangle has on its sides the corners of all others. Along edges where
// sheets touch all lattice points are vertices, and where both ends of such an edge join the
// sheets, so is the midpoint of the edge, or the edge would have four triangles.
//
// The vertices of each material are numbered for themselves, or those of all materials together, as
// in a file that has all triangles in one mesh.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "backends/boundary/color_layers.h"
#include "backends/boundary/faces.h"
#include "backends/boundary/lattice.h"
#include "backends/boundary/rectangle.h"
#include "backends/boundary/vertex_table.h"
#include "base/result.h"

namespace openfab::boundary {

constexpr int32_t kSteps = 512;  ///< steps per voxel

struct MeshCorner {
    Vec3i point;          ///< in half voxels from the grid's lowest corner
    uint32_t vertex = 0;  ///< counted from 0 for each material, or for all together
    /// Offset from the point in steps. Only for identification by position; the corners of rims
    /// have vertex 0.
    std::array<int16_t, 3> off{};
};
struct MeshTriangle : std::array<MeshCorner, 3> {
    uint32_t color = 0;  ///< of the voxel behind it, where there are colours
};

/// Receives the meshes in pieces, vertices in the order of their indices.
class MeshReceiver {
  public:
    virtual ~MeshReceiver() = default;
    /// Returns whether vertices are identified by position, so that coincident ones must be
    /// separated.
    virtual bool identifies_by_position() const { return false; }
    /// Returns whether vertices of all materials are numbered together; they come with code 0 then.
    virtual bool numbers_together() const { return false; }
    /// Returns whether triangles have colours: then faces of different ones are not merged.
    virtual bool has_colors() const { return false; }
    virtual Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) = 0;
    virtual Result<void> take_triangles(uint8_t code, std::span<const MeshTriangle> triangles) = 0;
};

/// Memory of a mesher for each voxel of a slice, in bytes: three slices of codes, bits at the
/// points, and vertex indices. Slices in which every voxel differs from its neighbours take half a
/// byte more for each material.
constexpr int64_t kMesherBytesPerColumn = 6;

class Mesher {
  public:
    /// `width` and `height` in voxels; `first_slice` is the z of the first slice.
    Mesher(int32_t width, int32_t height, int32_t first_slice, MeshReceiver* receiver);

    /// Adds the next slice above. Codes are at most 255, 0 is void. `colors`: of its voxels, for a receiver that
    /// has colours.
    Result<void> add(const pipeline::SliceView& slice, int32_t bits,
                     const uint32_t* colors = nullptr);
    /// Closes the meshes above the last slice.
    Result<void> finish();

  private:
    /// The vertices of a lattice plane: which points and midpoints of edges are vertices.
    struct Plane {
        Plane(int32_t width, int32_t height)
            : points(width, height), midpoints_x(width, height), midpoints_y(width, height) {}
        BitPlane points, midpoints_x, midpoints_y;
        VertexTable point_table, x_table, y_table;
    };
    struct Pending {
        std::vector<Vec3i> points;
        std::vector<MeshTriangle> triangles;
        uint32_t vertices = 0;  ///< total so far
    };

    Layer& layer(int32_t z) { return layers_[static_cast<size_t>(z + 3) % 3]; }
    Plane& plane(int32_t z) { return planes_[static_cast<size_t>(z + 3) % 3]; }

    Result<void> step();
    /// Visits the rectangle, or its parts of one colour.
    template <typename Visit>
    void split(const Rectangle& rectangle, Visit visit) {
        if (colors_ == nullptr) return visit(rectangle);
        colors_->split(rectangle, visit);
    }
    void mark(const Rectangle& rectangle);
    void mark_crossings();
    bool needs_midpoint(int32_t axis, const std::array<uint8_t, 8>& low_end,
                        const std::array<uint8_t, 8>& high_end) const;
    void find_midpoints_z();
    void number_points();
    void number_midpoints(const BitPlane& midpoints, int32_t axis, int32_t z, VertexTable* table);
    void add_vertices(VertexTable* table, uint8_t code, int32_t bit, int32_t count, Vec3i point);
    void end_word(VertexTable* table, Vec3i first_point);
    void outline(const Rectangle& rectangle);
    void emit(const Rectangle& rectangle);
    void emit_side(const Rectangle& rectangle, bool high);
    bool would_flip(const Rectangle& rectangle) const;
    void add_rim(const Rectangle& rectangle);
    MeshCorner corner(const Rectangle& rectangle, bool high, const Vec3i& point);
    MeshCorner midpoint_corner(const Rectangle& rectangle, bool high, const Vec3i& point,
                               int32_t axis);
    uint8_t code_at(const Vec3i& voxel) { return layer(voxel.z).row(voxel.y)[voxel.x]; }
    void flush(size_t code);

    int32_t width_, height_, first_slice_;
    int32_t z_ = 0;  ///< of the latest slice, from 0
    MeshReceiver* receiver_;
    bool by_position_, together_;
    std::vector<Layer> layers_;  ///< the last three, by z modulo 3
    std::vector<Plane> planes_;  ///< below, at and above the last slice's lower plane
    BitPlane midpoints_z_;       ///< of the slice before the last
    VertexTable z_table_;
    FaceFinder finder_;
    std::unique_ptr<ColorLayers> colors_;  ///< null: there are none
    std::vector<Pending> pending_;         ///< by code
    Result<void> error_;
    // Scratch of emit.
    Outline outline_;
    std::vector<Vec3i> points_;
    std::array<std::vector<MeshCorner>, 2> corners_;  ///< of the outline, on the low and high side
    std::vector<std::array<int32_t, 3>> triangles_;
};

}  // namespace openfab::boundary
