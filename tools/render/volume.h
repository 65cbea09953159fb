// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print as light sees it: codes of materials in blocks of 8 x 8 x 8 voxels, and the coverage of
// space by resin, smoothed over some voxels, whose level set at one half is the outer surface. Drops
// flow together before they harden: the steps of voxels are no facets of the printed part. Blocks of
// one code or coverage take no memory.
//
// Coordinates here are voxels, from origin_mm on: voxel (x, y, z) takes x to x + 1 along its axis.
// Blocks of void and what the smoothing reaches lie around the print, so that no look-up beside a
// surface needs a check. Coverage is stored at the centers of voxels and trilinear between them.

#include <array>
#include <cstdint>
#include <vector>

#include "base/check.h"
#include "base/result.h"
#include "base/vec.h"
#include "tools/render/mixtures.h"

namespace openfab::render {

/// Where a cell is in a grid of so many, x fastest.
inline size_t index_in(const Vec3i& count, const Vec3i& at) {
    return (static_cast<size_t>(at.z) * static_cast<size_t>(count.y) + static_cast<size_t>(at.y)) *
               static_cast<size_t>(count.x) +
           static_cast<size_t>(at.x);
}

class Volume {
  public:
    static constexpr int32_t kSide = 8;
    static constexpr int32_t kBlockVoxels = kSide * kSide * kSide;
    /// Numbers of blocks are multiples of it, and so many void ones are on each side: macrocells of so
    /// many blocks have no rest, and those at the border no surface.
    static constexpr int32_t kGroup = 4;
    /// The coverage inside, and at the surface.
    static constexpr int32_t kFull = 65280;
    static constexpr int32_t kSurface = kFull / 2;

    const Vec3i& blocks() const { return blocks_; }
    const Vec3d& pitch_mm() const { return pitch_mm_; }
    /// The build's millimetres of the coordinate 0.
    const Vec3d& origin_mm() const { return origin_mm_; }
    /// The tight box of what is solid, in millimetres.
    const Box3d& solid_mm() const { return solid_mm_; }
    int64_t bytes() const;

    uint8_t code(int32_t x, int32_t y, int32_t z) const {
        const uint32_t entry = codes_[block_index(x, y, z)];
        return (entry & kUniform) != 0 ? static_cast<uint8_t>(entry)
                                       : code_pool_[size_t{entry} * kBlockVoxels + place(x, y, z)];
    }
    int32_t coverage(int32_t x, int32_t y, int32_t z) const {
        const uint32_t entry = coverages_[block_index(x, y, z)];
        return (entry & kUniform) != 0
                   ? static_cast<int32_t>(entry & ~kUniform)
                   : coverage_pool_[size_t{entry} * kBlockVoxels + place(x, y, z)];
    }
    /// The coverage of the eight centers around a dual cell, whose lowest center is (x, y, z):
    /// x fastest, then y, z.
    std::array<int32_t, 8> corners(int32_t x, int32_t y, int32_t z) const {
        if ((x & 7) == 7 || (y & 7) == 7 || (z & 7) == 7) {
            return {coverage(x, y, z),         coverage(x + 1, y, z),
                    coverage(x, y + 1, z),     coverage(x + 1, y + 1, z),
                    coverage(x, y, z + 1),     coverage(x + 1, y, z + 1),
                    coverage(x, y + 1, z + 1), coverage(x + 1, y + 1, z + 1)};
        }
        const uint32_t entry = coverages_[block_index(x, y, z)];
        if ((entry & kUniform) != 0) {
            const auto all = static_cast<int32_t>(entry & ~kUniform);
            return {all, all, all, all, all, all, all, all};
        }
        const uint16_t* const at =
            coverage_pool_.data() + size_t{entry} * kBlockVoxels + place(x, y, z);
        return {at[0], at[1], at[8], at[9], at[64], at[65], at[72], at[73]};
    }
    /// Calls use(code) for the codes of a block, in no order, with repetitions.
    template <typename Use>
    void for_codes(const Vec3i& block, const Use& use) const {
        const uint32_t entry = codes_[index_of(block)];
        if ((entry & kUniform) != 0) return use(static_cast<uint8_t>(entry));
        const uint8_t* const codes = code_pool_.data() + size_t{entry} * kBlockVoxels;
        for (int32_t i = 0; i < kBlockVoxels; ++i)
            use(codes[i]);
    }
    /// Tells whether some of a block's voxels are inside and others not; sets bit x of rows[8 z + y] for those that are.
    bool inside(const Vec3i& block, uint8_t* rows) const;
    /// By block, x fastest: kUniform and the code of all its voxels, or which 512 bytes of the pool have them, x fastest.
    const uint32_t* codes() const { return codes_.data(); }
    const uint8_t* code_pool() const { return code_pool_.data(); }

  private:
    friend class VolumeBuilder;
    static constexpr uint32_t kUniform = 0x80000000U;

    size_t index_of(const Vec3i& block) const { return index_in(blocks_, block); }
    size_t block_index(int32_t x, int32_t y, int32_t z) const {
        return index_of({x >> 3, y >> 3, z >> 3});
    }
    static size_t place(int32_t x, int32_t y, int32_t z) {
        return static_cast<size_t>(((z & 7) << 6) | ((y & 7) << 3) | (x & 7));
    }

    Vec3i blocks_;
    Vec3d pitch_mm_, origin_mm_;
    Box3d solid_mm_;
    /// By block: kUniform and the value of all its voxels, or its number in the pool.
    std::vector<uint32_t> codes_, coverages_;
    std::vector<uint8_t> code_pool_;
    std::vector<uint16_t> coverage_pool_;
};

/// The grid that a print is read into: its own, or one whose cells are `cell` voxels wide.
struct VolumeGrid {
    Vec3i voxels;     ///< of the print, along each axis
    Vec3d pitch_mm;   ///< of them
    Vec3d origin_mm;  ///< lowest corner
    Vec3i cell{1, 1, 1};
    /// The codes that its voxels may have, increasing.
    std::vector<uint8_t> codes;

    bool is_own() const { return cell == Vec3i{1, 1, 1}; }
    Vec3i cells() const {
        return {(voxels.x + cell.x - 1) / cell.x, (voxels.y + cell.y - 1) / cell.y,
                (voxels.z + cell.z - 1) / cell.z};
    }
    Vec3d cell_mm() const {
        return {pitch_mm.x * cell.x, pitch_mm.y * cell.y, pitch_mm.z * cell.z};
    }
    /// Makes the cells larger along the axis in which they are smallest.
    void coarsen();
};

/// Makes a volume from slices, bottom up.
class VolumeBuilder {
  public:
    /// Takes at most `memory_bytes`, the finished volume included. The code of a cell of several voxels is that of a
    /// mixture of `grid.codes` (mixtures), of its solid voxels, rounded by a hash of its place, so that mixtures stay as
    /// they are in the mean; its coverage is their share. `seed` decides the draws.
    VolumeBuilder(const VolumeGrid& grid, int64_t memory_bytes, uint64_t seed);

    /// Returns what a builder takes before it stores a block.
    static int64_t least_bytes(const VolumeGrid& grid);

    const Mixtures& mixtures() const { return mixtures_; }

    /// Takes slice `z`, codes of one byte, x fastest: above the last one. Slices left out are void.
    /// Returns false where the memory does not suffice.
    bool add(int32_t z, const uint8_t* codes);
    /// Returns false as add does.
    bool finish(Volume* out);

  private:
    struct Layer {
        std::vector<uint8_t> codes;
        std::vector<uint16_t> coverage;  ///< smoothed along x and y
        bool is_void = true;
    };

    size_t cells_of_layer() const {
        return static_cast<size_t>(cells_.x) * static_cast<size_t>(cells_.y);
    }
    void count(size_t cell, uint8_t code);
    bool close_cells();
    void smooth(const std::vector<uint8_t>& solid, std::vector<uint16_t>* out);
    /// Layer `z` of cells, which may lie outside: then it is void.
    const Layer& layer(int32_t z) const;
    bool emit(int32_t z);
    void spread_codes(int32_t z, uint8_t* codes, const uint16_t* coverage) const;
    bool store_slab();

    VolumeGrid grid_;
    Vec3i margin_;  ///< cells around the print that the smoothing reaches
    Vec3i cells_;   ///< with them
    int64_t memory_bytes_;
    uint64_t seed_;
    std::array<std::vector<uint32_t>, 3> kernel_;  ///< half of it: [0] the center
    std::vector<Vec3i> nearby_;                    ///< cells around one, nearest first
    int32_t open_ = 0;                             ///< the layer of cells being gathered
    std::vector<uint32_t> solid_;                  ///< voxels that are, by cell
    Mixtures mixtures_;
    std::array<uint16_t, 256> place_of_{};  ///< of a code among the grid's
    std::vector<uint16_t> counts_;          ///< voxels of each code, by cell of several
    std::vector<uint8_t> codes_;
    std::vector<Layer> window_;  ///< layer z at z modulo its size
    Layer nothing_;
    int32_t emitted_ = 0;
    std::vector<uint8_t> slab_codes_;  ///< kSide layers
    std::vector<uint16_t> slab_coverage_;
    std::vector<uint16_t> between_;  ///< smoothed along x
    Box3i tight_;
    Volume volume_;
};

}  // namespace openfab::render
