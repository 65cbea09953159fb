// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part set up for printing on a grid: what every thread reads while it runs.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/nearest/attributes.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/winding.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/coverage.h"

namespace openfab::slab {

/// Which queries a kernel's arguments call for.
struct QueryNeeds {
    bool distance = false;
    bool attributes = false;
    bool gradients = false;
    bool any() const { return distance || attributes || gradients; }
};

QueryNeeds query_needs(const openfab_kernel& kernel);
QueryNeeds query_needs(const openfab_phases& phases);

/// What the queries of a stage at points of its own choosing ask of the part's own surface.
struct PointNeeds {
    bool any = false;
    bool sign = false;
    bool geometry = false;  ///< positions or normals
};

PointNeeds point_needs(const openfab_phases& phases);

/// What the volume stage asks of the surface at voxels.
QueryNeeds volume_needs(const openfab_fablet& fablet);
/// Whether parts with this fablet need trees over their surface.
bool asks_surface(const openfab_fablet& fablet);

/// Place of each component of a @nearest input among the flattened float or other components, the
/// order of surface::MicroMesh.
class NearestIndex {
  public:
    explicit NearestIndex(const openfab_fablet& fablet);
    int32_t floats() const { return floats_; }
    int32_t ints() const { return ints_; }
    bool is_float(int32_t input) const { return is_float_[static_cast<size_t>(input)]; }
    size_t place(int32_t input, int32_t component) const {
        return static_cast<size_t>(first_[static_cast<size_t>(input)] + component);
    }

  private:
    std::vector<bool> is_float_;
    std::vector<int32_t> first_;
    int32_t floats_ = 0, ints_ = 0;
};

/// A placement of an object that a fablet asks for its distance.
struct QueryTarget {
    int32_t part = 0;  ///< the one whose engine answers; parts with one surface share it
    const nearest::Engine* engine = nullptr;
    const nearest::Winding* winding = nullptr;
    Affine3d to_local;  ///< part-local mm of the asking part -> of the placement
};

struct PrintPart {
    const scene::Part* part = nullptr;
    std::shared_ptr<const surface::Surface> surface;
    /// The place of the first part with this surface, which makes what all of them share. Threads
    /// keep their scratch by it.
    int32_t owner = 0;
    std::shared_ptr<const voxel::PatchIndex> patches;
    std::unique_ptr<voxel::Voxeliser> voxeliser;
    std::shared_ptr<const nearest::BlockIndex> trees;  ///< null where no kernel asks a query
    std::unique_ptr<nearest::Engine> engine;           ///< likewise
    std::unique_ptr<nearest::AttributeReader> attributes;
    std::shared_ptr<const nearest::Winding> winding;  ///< null where no query asks for a sign
    std::vector<std::vector<QueryTarget>> targets;    ///< by place among the Object uniforms
    std::array<float, OPENFAB_FRAME_COUNT> frame{};
    Vec3i base;  ///< voxel of the grid with part-relative index 0
    Box3i box;   ///< voxels that may be covered, hi exclusive, cut to the grid
    std::vector<int32_t> slot_material;
    NearestIndex nearest;
    QueryNeeds volume, bounds;
    PointNeeds points;
    float largest_pitch_mm = 0;
    float voxel_diagonal_mm = 0;      ///< the longest of a voxel, in part space
    float largest_coordinate_mm = 0;  ///< of the surface, part-local, with some voxels to spare
    int32_t index = 0;                ///< place in the build list

    explicit PrintPart(const scene::Part& of) : part(&of), nearest(*of.fablet) {}
    /// After the grid is known: everything but the surface, which was set before. `first` is the
    /// part that owns the surface, placed before, or this one. `trees_of_patches` is for all parts;
    /// `crossing_bytes` is the budget of a cache of its own.
    void place(const scene::Grid& grid, openfab_isa isa,
               const std::shared_ptr<nearest::PatchCache>& trees_of_patches, size_t crossing_bytes,
               const PrintPart& first);
    int32_t slots() const { return part->fablet->slot_count; }
    /// Makes what a signed distance at any point needs, where it is not there yet.
    void answer_points(openfab_isa isa,
                       const std::shared_ptr<nearest::PatchCache>& trees_of_patches);
};

/// Finds the objects that the parts' fablets ask for their distance. All parts are placed.
void connect_targets(const std::vector<std::unique_ptr<PrintPart>>& parts, openfab_isa isa,
                     const std::shared_ptr<nearest::PatchCache>& trees_of_patches);

/// For each part the first one with the same surface: same mesh, fablet, bound, and what the
/// surface kernels read.
std::vector<int32_t> surface_owners(const std::vector<scene::Part>& parts);

/// Gives parts that are displaced the mesh that is diced, each owner's to those that it owns.
Result<void> split_meshes(const std::vector<int32_t>& owners,
                          const surface::SurfaceOptions& options, std::vector<scene::Part>* parts);

/// One surface for each owner; the parts that it owns share it.
Result<std::vector<std::shared_ptr<const surface::Surface>>> make_surfaces(
    const std::vector<scene::Part>& parts, const std::vector<int32_t>& owners,
    const surface::SurfaceOptions& options);

}  // namespace openfab::slab
