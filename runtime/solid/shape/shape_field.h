// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The zero set of a shape on a lattice over its box: which blocks of cells it passes, by intervals,
// and its micropolygons there. Threads share it.
//
// The lattice has the pitch `cell`, with vertices at multiples of it in part-local mm; those that would
// lie beyond the box are moved to its border, so that nothing is evaluated outside. A vertex is inside
// if its value is below 0 and it is not on that border. On each edge between an inside and an outside
// vertex lies one micro-vertex, at the zero that a search finds which looks at nothing but the edge:
// neighbours that share the edge have it with equal bits.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/pool.h"
#include "base/result.h"
#include "base/vec.h"
#include "pieces/region.h"
#include "runtime/solid/extent/extent_search.h"
#include "runtime/solid/shape/shape_bodies.h"
#include "runtime/solid/shape/shape_calls.h"
#include "runtime/surface/surface.h"

namespace openfab::solid {

/// Cells along a side of a block, which is a patch of the surface.
constexpr int32_t kPatchCells = 16;

class ShapeField {
  public:
    /// `stage`: the part of Part::shape; `bodies`: those of it; `fablet` has the @nearest inputs. Stage
    /// and fablet must outlive it.
    ShapeField(const part::ShapeStage& stage, const Bodies& bodies, const openfab_fablet& fablet,
               double cell_mm, openfab_isa isa);

    /// Returns an error where the shape is negative at the border of its box, nowhere negative in it,
    /// or no number. The points that are looked at do not depend on the cell.
    Result<void> check() const;
    /// Returns the box of what is negative on these sides, under an affine map (find_extent).
    Box3d exact_box(const Affine3d& local_to_other, std::span<const pieces::Side> sides) const;
    /// Returns the box of voxels beyond `known` whose centres are inside, and on these sides, though no
    /// box of find_extent holds them. `pitch_mm` is along the axes of the other space, whose voxels lie
    /// at its multiples.
    Box3d voxels_beyond(const Affine3d& local_to_other, std::span<const pieces::Side> sides,
                        const Vec3d& pitch_mm, const Box3d& known) const;
    /// Returns the shape's box, part-local.
    const Box3f& bounds() const { return box_; }
    /// Returns whether a box within the shape's touches its border, where everything is outside.
    bool at_border(const Box3f& box) const;
    /// Lets values at points on that border be 0 where they are below; the points are in `around`.
    void close_border(const Box3f& around, const ShapePoints& points,
                      std::vector<float>* values) const;
    /// Tells of n boxes, by axis, on which side of the zero set all of each is: 1 outside, -1 inside, 0 not known; of points
    /// always.
    void sides(const std::array<const float*, 3>& lo, const std::array<const float*, 3>& hi,
               size_t n, int8_t* out) const;
    /// Returns the lattice's lowest corner, as it were without the box.
    Vec3f origin() const;
    /// Returns the lowest cells of all blocks that have a micropolygon, in order of z, y, x.
    std::vector<Vec3i> find_blocks(const std::atomic<bool>* stop) const;
    /// Returns the box of a block's cells.
    Box3f block_box(const Vec3i& lowest) const;
    double cell_mm() const { return cell_mm_; }
    /// Returns how many cells the lattice has along each axis.
    const Vec3i& cells() const { return cells_; }
    /// Returns the place of a vertex of the lattice.
    Vec3f position(const Vec3i& vertex) const {
        return {places_[0][static_cast<size_t>(vertex.x)],
                places_[1][static_cast<size_t>(vertex.y)],
                places_[2][static_cast<size_t>(vertex.z)]};
    }
    /// Makes the micropolygons of a block.
    void dice(const Vec3i& lowest, surface::MicroMesh* out) const;

    const part::ShapeStage& stage() const { return stage_; }
    /// Returns whether values are distances: they are declared so, and scaled alike along all axes.
    bool is_distance() const;
    ShapeCalls* take() const {
        return calls_.take(
            [&] { return std::make_unique<ShapeCalls>(stage_, fixed_, bodies_, isa_); });
    }
    void give(ShapeCalls* calls) const { calls_.give(calls); }
    /// As of a Solid.
    void set_stop(const std::atomic<bool>* stop) const { fixed_.set_stop(stop); }
    /// Notes that a kernel failed, or that the value at a point is NaN.
    void note(const abi::KernelStatus& failed) const;
    void note_nan(const Vec3f& at) const;
    Result<void> status() const;
    /// As ShapeBodies::query_bytes.
    int64_t body_bytes() const { return bodies_.query_bytes(); }
    int32_t float_components() const { return static_cast<int32_t>(floats_.size()); }
    int32_t int_components() const { return static_cast<int32_t>(ints_.size()); }

  private:
    /// A cube of blocks: its lowest cell and cells a side.
    struct Node {
        Vec3i lowest;
        int32_t size = 0;
    };
    struct Diced;
    Vec3i end_of(const Node& node) const;
    /// Appends the places of vertices from `first` to `last`, both included, every `step`-th along each axis.
    void append_vertices(const Vec3i& first, const Vec3i& last, int32_t step,
                         ShapePoints* to) const;
    Box3f box_of(const Node& node) const;
    Node root() const;
    static Box3f common(const Box3f& a, const Box3f& b);
    /// Appends those of the node's eight parts that the bounds kernel does not decide within a box.
    void split(const Node& node, const Box3f& within, ShapeCalls* calls,
               std::vector<Node>* out) const;
    const Extent& extent(const std::array<double, 9>& turn,
                         std::span<const pieces::Side> sides) const;
    bool fill_signs(const Vec3i& lowest, ShapeCalls* calls, Diced* diced) const;
    bool crosses(const Node& block, ShapeCalls* calls) const;
    abi::KernelStatus fill_ends(ShapeCalls* calls, Diced* diced) const;
    void find_zeros(ShapeCalls* calls, Diced* diced) const;
    Result<void> check_border() const;
    Result<void> check_side(int axis, bool high, ShapeCalls* calls) const;
    Result<void> check_points(const ShapePoints& points, int axis, bool high,
                              ShapeCalls* calls) const;
    Result<void> status_of() const;
    Error error(const std::string& what, const std::string& help) const;
    std::string place(const Vec3f& p) const;

    const part::ShapeStage& stage_;
    surface::StaticArgs fixed_;
    const ShapeBodies bodies_;
    double cell_mm_;
    openfab_isa isa_;
    Box3f box_;
    Vec3i first_;  ///< multiple of the pitch that is the lattice's lowest vertex
    Vec3i cells_;  ///< along each axis
    std::array<std::vector<float>, 3> places_;  ///< [axis][vertex]
    /// Places of the @nearest inputs' components in what ShapeCalls::attributes gives.
    std::vector<size_t> floats_, ints_;
    mutable Pool<ShapeCalls> calls_;
    mutable std::mutex mutex_;
    /// By map, and by normals and offsets of sides, outwards.
    mutable std::map<std::pair<std::array<double, 9>, std::vector<double>>, Extent> extents_;
    mutable std::mutex extents_mutex_;
    mutable std::optional<Vec3f> nan_;  ///< the first in z, y, x
    mutable std::optional<abi::KernelStatus> failed_;
};

}  // namespace openfab::solid
