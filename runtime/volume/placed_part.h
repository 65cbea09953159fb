// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part placed on the grid of a print: shared read-only by all threads.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/stages.h"
#include "runtime/nearest/engine.h"
#include "runtime/part/part.h"
#include "runtime/solid/cut/cut.h"
#include "runtime/solid/solid.h"
#include "runtime/surface/surface.h"
#include "runtime/volume/walk_lattice.h"

namespace openfab::volume {

/// The query results that a kernel's arguments need.
struct QueryNeeds {
    bool distance = false;
    bool attributes = false;
    bool gradients = false;
    bool any() const { return distance || attributes || gradients; }
};

QueryNeeds query_needs(std::span<const openfab_arg> args);

/// The results that queries of a stage at arbitrary points need from the part's own surface.
struct PointNeeds {
    bool any = false;
    bool sign = false;
    bool attributes = false;
    bool geometry = false;  ///< positions or normals
};

PointNeeds point_needs(const openfab_segments& segments);

/// Returns the query results that the volume stage needs at voxels.
QueryNeeds volume_needs(const openfab_fablet& fablet);
/// Returns whether parts with this fablet need trees over their surface.
bool asks_surface(const openfab_fablet& fablet);

/// The index of each component of a @nearest input among the flattened float or other components,
/// in the order of surface::MicroMesh.
class NearestIndex {
  public:
    explicit NearestIndex(const openfab_fablet& fablet);
    int32_t floats() const { return floats_; }
    int32_t ints() const { return ints_; }
    bool is_float(int32_t input) const { return is_float_[input]; }
    size_t index(int32_t input, int32_t component) const {
        return static_cast<size_t>(first_[input] + component);
    }

  private:
    std::vector<bool> is_float_;
    std::vector<int32_t> first_;
    int32_t floats_ = 0, ints_ = 0;
};

/// A placement of an object whose distance a fablet queries.
struct QueryTarget {
    int32_t part = 0;  ///< the part whose engine is used; parts with one solid share it
    const solid::Placed* placed = nullptr;
    Affine3d to_local;  ///< part-local mm of the querying part -> of the placement
};

struct PlacedPart {
    const part::Part* part = nullptr;
    std::shared_ptr<solid::Solid> solid;
    /// The index of the first part with this solid. Threads index their scratch by it.
    int32_t owner = 0;
    std::unique_ptr<solid::Placed> placed;
    std::unique_ptr<const solid::Cut> cut;          ///< of a piece
    std::vector<std::vector<QueryTarget>> targets;  ///< by index among the Object uniforms
    /// Of walks that end on the part's own surface; then by index among the Object uniforms. Null without such walks.
    std::vector<std::shared_ptr<WalkLattice>> lattices;
    std::array<float, OPENFAB_FRAME_COUNT> frame{};
    Vec3i base;               ///< voxel of the grid with part-relative index 0
    Box3i box;                ///< voxels that may be covered, hi exclusive, cut to the grid
    abi::Channels channels;   ///< of the slots' materials
    bool own_dither = false;  ///< mixtures are dithered by the fablet's rule
    std::array<uint32_t, OPENFAB_GRID_SEED + 1> rule_inputs{};  ///< by openfab_grid_value
    NearestIndex nearest;
    QueryNeeds volume, bounds;
    bool bounds_say_looks = false;  ///< the bounds kernel has the output of abi/looks.h
    PointNeeds points;
    float largest_pitch_mm = 0;
    float voxel_diagonal_mm = 0;      ///< longest diagonal of a voxel, in part space
    float largest_coordinate_mm = 0;  ///< of the surface, part-local, with a margin of some voxels
    int32_t index = 0;                ///< index in the build list

    explicit PlacedPart(const part::Part& of) : part(&of), nearest(*of.fablet) {}
    /// Sets up everything but the solid, which was set before. `first` is the part that owns the
    /// solid, set up before, or this one. `crossing_bytes` is the budget of a cache of its own.
    void set_grid(const part::Grid& grid, const solid::QuerySetUp& queries, size_t crossing_bytes,
                  const PlacedPart& first);
    /// Uses the fablet's dither rule with a seed of the print (fold_seed); `base` is set.
    void set_own_dither(uint32_t seed);
    int32_t slots() const { return part->fablet->slot_count; }
    const nearest::Engine& engine() const { return *placed->engine(); }
};

/// Resolves the objects whose distance the parts' fablets query. All parts must be set up.
void resolve_object_queries(const std::vector<std::unique_ptr<PlacedPart>>& parts,
                            const solid::QuerySetUp& queries);

/// Makes the lattices of the parts' walks, which keep that many bytes together; returns how many there are. All parts must
/// be set up.
size_t make_walk_lattices(const std::vector<std::unique_ptr<PlacedPart>>& parts, size_t bytes);

/// Returns for each part the first one with the same solid: alike (solid::Kind), and of the same
/// fablet, or another plain one (part_mesh.h) with the same needs.
std::vector<int32_t> solid_owners(const std::vector<part::Part>& parts);

/// Refines the sources of solids (solid::Kind); parts share their owner's.
Result<void> refine_sources(const std::vector<int32_t>& owners,
                            const surface::SurfaceOptions& options, std::vector<part::Part>* parts);

/// Makes one solid for each owner; its parts share it.
Result<std::vector<std::shared_ptr<solid::Solid>>> make_solids(
    const std::vector<part::Part>& parts, const std::vector<int32_t>& owners,
    const surface::SurfaceOptions& options);

}  // namespace openfab::volume
