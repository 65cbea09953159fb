// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of parts, whatever it is made of: what the pipeline asks of it, per slab, block, patch
// or packet of points. A kind of geometry is a folder beside this one and a row in kinds/kinds.cpp.
//
// A Solid is shared by the parts that have the same geometry; a Placed is a solid in the grid of a
// print, one a part.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "base/vec.h"
#include "pieces/region.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/targets.h"
#include "runtime/part/part.h"
#include "runtime/solid/dicing.h"
#include "runtime/solid/tops.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

/// What kernels ask of a solid.
struct Asked {
    bool nearest = false;     ///< nearest points: distances
    bool attributes = false;  ///< at nearest points
    bool geometry = false;    ///< positions or normals of nearest points
    bool sign = false;        ///< inside or outside, at points other than voxel centres
};

/// What queries are set up with.
struct QuerySetUp {
    openfab_isa isa = OPENFAB_ISA_SSE41;
    std::shared_ptr<nearest::PatchCache> trees;  ///< shared by all solids of a print
};

/// Scratch memory of one thread for queries of one solid, by whichever of its placements.
struct Scratch {
    std::unique_ptr<nearest::Engine::Scratch> engine;
    virtual ~Scratch() = default;
};

/// Points known to be inside, one for each lane with its bit in `mask`.
struct KnownInside {
    const nearest::PointPacket* points = nullptr;
    uint32_t mask = 0;
    float slack_mm = 0;  ///< how far the surface that contains them may deviate
};

/// A solid on the grid of a print. Threads share it.
class Placed {
  public:
    virtual ~Placed() = default;

    /// Returns a box of voxels of the grid that holds all covered ones, hi exclusive.
    virtual Box3i voxel_box() const = 0;
    /// Computes the coverage of slices [8 slab, 8 slab + 8) (rule 14) into `out`, reusing its memory.
    /// Once `stop` is set it ends soon, and what is in `out` is of no use. Adds to `seconds` what it
    /// took, of threads that helped, too, but not what this one waited for them.
    virtual void coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                          double* seconds) const = 0;
    /// Forgets what coverage has kept for later slabs; call while no other thread uses it.
    virtual void forget_slabs() const {}
    /// Raises tops to the highest voxel that may be covered in each column (rule 17).
    virtual void raise_tops(const Columns& columns, TopRows* rows) const = 0;

    /// Makes the engine and what reads attributes, as far as the solid was prepared for them.
    virtual void begin_queries() = 0;
    /// Returns what answers queries for nearest points; null before begin_queries.
    const nearest::Engine* engine() const { return engine_.get(); }
    virtual std::unique_ptr<Scratch> make_scratch() const {
        auto scratch = std::make_unique<Scratch>();
        scratch->engine = engine_->make_scratch();
        return scratch;
    }
    /// Writes the @nearest inputs at the answers of a block. `active` as in nearest::BlockQuery.
    virtual void read(const nearest::BlockAnswer& answer, const uint8_t* active,
                      const nearest::AttributeTargets& targets, Scratch* scratch) const = 0;
    /// Writes inputs, positions and normals at the answers of a packet of points.
    virtual void read_points(const nearest::PointAnswer& answer,
                             const nearest::PointTargets& targets, Scratch* scratch) const = 0;
    /// Returns the active lanes with an answer that are inside. `answers` are those of the packet,
    /// without radius.
    virtual uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                            const KnownInside& known, Scratch* scratch) const = 0;

  protected:
    std::unique_ptr<nearest::Engine> engine_;
};

/// Where a solid is placed.
struct Place {
    const part::Part& part;  ///< which must outlive what is placed
    const part::Grid& grid;
    const std::array<float, OPENFAB_FRAME_COUNT>& frame;  ///< of the part in the grid
    size_t waiting_bytes = 0;  ///< that coverage may keep for later slabs
};

/// The geometry of one or more parts, in part-local mm.
class Solid {
  public:
    virtual ~Solid() = default;

    /// Returns the box of all that is covered, under an affine map.
    virtual Box3d exact_box(const Affine3d& local_to_other) const = 0;
    /// Returns the box of what of it is on all these sides, at least one, part-local; that of all of it
    /// where it is not known before a print.
    virtual Box3d box_on_sides(const Affine3d& local_to_other,
                               std::span<const pieces::Side> sides) const = 0;
    /// Returns the box of voxels of a grid, at multiples of its pitch in build space, that are covered,
    /// and on these sides, though they lie beyond those boxes, and beyond `known`: they may rest on
    /// points that were looked at.
    virtual Box3d voxels_beyond(const Affine3d& /*local_to_build*/,
                                std::span<const pieces::Side> /*sides*/, const Vec3d& /*pitch_mm*/,
                                const Box3d& /*known*/) const {
        return {};
    }
    /// Returns a box that holds it, which costs little.
    virtual Box3f bounds() const = 0;
    /// Where a distance has the sign of a value, wherever the surface lies that is made of it: tells of n boxes, part-local, by
    /// axis, on which side all of each is: 1 outside, -1 inside, 0 not known; of points always. Returns false, and tells
    /// nothing, where signs change on the surface alone.
    virtual bool sides(const std::array<const float*, 3>& /*lo*/,
                       const std::array<const float*, 3>& /*hi*/, size_t /*n*/,
                       int8_t* /*out*/) const {
        return false;
    }
    /// Returns what a query may have to make first, so that it is worth it to ask less; null: nothing.
    virtual const Dicing* dicing() const { return nullptr; }
    bool bounds_dice() const { return dicing() != nullptr && dicing()->for_bounds(); }
    /// Returns the bytes that lazily built trees of queries will still take once all exist; only if
    /// it was prepared for queries.
    virtual int64_t query_bytes() const { return 0; }
    /// Returns the same of other solids that it asks itself, queries or not.
    virtual int64_t body_bytes() const { return 0; }

    /// Returns an error once a kernel has failed, or geometry was found to be impossible; what was
    /// asked came back empty. To be checked after each slab.
    virtual Result<void> status() const { return {}; }
    /// As surface::Surface::set_stop.
    virtual void set_stop(const std::atomic<bool>* /*stop*/) const {}

    /// Makes what placements share, unless it exists: of queries what is asked. Call while no other
    /// thread uses it, and before `place`.
    virtual void prepare(const Asked& asked, const QuerySetUp& queries) = 0;
    /// Places it; it must outlive what it returns.
    virtual std::unique_ptr<Placed> place(const Place& where) const = 0;
};

}  // namespace openfab::solid
