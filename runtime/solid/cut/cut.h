// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One piece of a part on the grid of a print: which of the part's voxels belong to it.
//
// A cut is a half-space, asked at voxel centres in integers: its plane is brought to voxel space and
// rounded to 2^-40 of its largest coefficient, and a centre on it is moved by (e, e², e³), as the
// voxeliser does (rule 14). So each voxel of the part belongs to one piece of those in one pose.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/solid/solid.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

/// A half-space of voxels.
class VoxelSide {
  public:
    VoxelSide(const pieces::Side& side, const part::Part& part, const part::Grid& grid);
    /// Narrows voxels [lo, hi) of row (y, z) to those on this side.
    void narrow(int32_t y, int32_t z, int32_t* lo, int32_t* hi) const;

  private:
    __extension__ typedef __int128 Wide;
    int64_t a_ = 0, b_ = 0, c_ = 0;  ///< in front: a (2i + 1) + b (2j + 1) + c (2k + 1) > d
    Wide d_ = 0;
    bool front_ = false;
};

/// Voxels of a slab that are of another material than the part.
struct FilledMask {
    uint8_t code = 0;
    voxel::SlabMask mask;
};

class Cut {
  public:
    /// Of part.piece, in the box of voxels that its part may cover.
    Cut(const part::Part& part, const part::Grid& grid, const Solid& solid, const Box3i& whole);

    /// Returns the box of voxels that the piece may cover, hi exclusive.
    const Box3i& box() const { return box_; }
    /// Leaves in a part's coverage what belongs to the piece, and writes what is of other materials.
    void apply(int32_t slab, voxel::SlabMask* mask, std::vector<FilledMask>* filled) const;

  private:
    Vec3d center_of(int32_t x, int32_t y, int32_t z) const;
    Box3i box_of(const pieces::Shape& shape) const;
    template <typename Visit>
    void visit_voxels(const pieces::Shape& shape, int32_t slab, const voxel::SlabMask& mask,
                      const Visit& visit) const;
    void fill_sides(int32_t slab, voxel::SlabMask* allowed) const;

    std::shared_ptr<const part::Piece> piece_;
    std::vector<VoxelSide> sides_;
    Affine3d to_local_, to_voxel_;  ///< from voxels, and to them; a centre is at i + 0.5
    Box3i box_;
};

/// Returns the box of a part as placed: of its piece, if it is one.
Box3d box_in_build(const part::Part& part, const Solid& solid);
/// Returns the box of voxels that are covered beyond that and `known` (Solid::voxels_beyond).
Box3d voxels_beyond(const part::Part& part, const Solid& solid, const Vec3d& pitch_mm,
                    const Box3d& known);

/// Returns the top of each column of a box (rule 17), row by row, of a part that is a piece: the
/// highest voxel that it covers.
std::vector<int32_t> tops_of_piece(const Placed& placed, const Cut& cut, const Box3i& box);

}  // namespace openfab::solid
