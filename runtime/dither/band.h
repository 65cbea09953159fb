// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of blocks between the volume stage and packed slices. A RowBand is one row of blocks (8
// voxels in y) of a slab with codes everywhere and fractions only for blocks that hold a mixed
// voxel. Bands are filled independently, in any order; SlabDither processes them in +y, one voxel
// row behind, because the dither of a voxel depends on which voxels of the next row are mixed.

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "abi/stages.h"
#include "base/vec.h"
#include "runtime/dither/dither_row.h"

namespace openfab::dither {

/// Columns of 8 voxels along z as the slab kernel gives them. Their fractions are in the band.
struct EvaluatedColumns {
    std::span<const int32_t> columns;  ///< 8 y + x of each, modulo 64
    const uint8_t* codes = nullptr;    ///< 8 a column
    int32_t fractions = 0;             ///< number in the band of the first column
    bool alike = false;                ///< codes and fractions are those of one column, for all
};

struct RowBand {
    int32_t row = 0;                         ///< block row: voxels y = 8 row .. 8 row + 7
    int32_t blocks = 0;                      ///< block columns of the grid
    int32_t channels = 0;                    ///< of fractions
    int32_t first_block = 0, end_block = 0;  ///< the columns that were written to
    bool any_mixed = false;
    std::vector<uint8_t> codes;         ///< (z 8, x 8 blocks, y 8)
    std::vector<uint8_t> mixed;         ///< [y][kRowMargin + x + kRowMargin], bit z
    std::vector<uint8_t> mixed_blocks;  ///< per block column: 1 if any voxel is mixed
    std::vector<int32_t> columns;       ///< [y][x]: number of a column with mixed voxels
    std::vector<uint16_t> fractions;    ///< [number][channel][z], see add_columns

    int32_t width() const { return 8 * blocks; }
    int32_t mixed_stride() const { return width() + 2 * kRowMargin; }
    uint8_t* codes_at(int32_t x, int32_t y) {
        return &codes[(static_cast<size_t>(y) * width() + x) * 8];
    }
    const uint8_t* mixed_row(int32_t y) const {
        return &mixed[static_cast<size_t>(y) * mixed_stride() + kRowMargin];
    }
    uint8_t* mixed_row(int32_t y) {
        return &mixed[static_cast<size_t>(y) * mixed_stride() + kRowMargin];
    }
    uint16_t* fractions_at(int32_t column) {
        return &fractions[static_cast<size_t>(column) * static_cast<size_t>(8 * channels)];
    }

    /// Makes all voxels void. `first` and `end` bound the block columns that will be written.
    void reset(int32_t row_index, int32_t block_columns, int32_t channel_count, int32_t first,
               int32_t end);

    /// Sets the owned voxels of a block (64 bytes, bit z of byte y * 8 + x) to one material.
    void fill(int32_t block, const uint8_t* owned, uint8_t code);
    /// Sets voxels of one column (8 y + x) of a block, by bit z, to one material.
    void fill_column(int32_t block, int32_t column, uint8_t voxels, uint8_t code);

    /// Makes room for the fractions of `count` columns, all 0, and returns the first's number.
    int32_t add_columns(size_t count);
    /// Takes the owned voxels of a block's columns. Fractions of voxels that are not mixed are
    /// never looked at.
    void merge(int32_t block, const uint8_t* owned, const EvaluatedColumns& evaluated);
    size_t bytes() const;

  private:
    int32_t blend_columns(int32_t column, int32_t other, uint8_t voxels);
};

/// 8 packed slices of the grid. Plane z starts at z * plane_bytes.
struct SlabPlanes {
    int32_t bits = 4;               ///< a voxel
    int32_t width = 0, height = 0;  ///< voxels
    int64_t row_bytes = 0, plane_bytes = 0;
    /// 8 planes. Pages become resident on first write: a tray's planes are 200 MB.
    std::unique_ptr<uint8_t, decltype(&std::free)> data{nullptr, &std::free};

    /// Makes all voxels void. Memory is reused where the size is the same; returns false if out of
    /// memory.
    [[nodiscard]] bool reset(int32_t grid_width, int32_t grid_height, int32_t voxel_bits);
};

struct SupportFill;

class SlabDither {
  public:
    /// `channels` of fractions; `size` of the grid in voxels; memory is reused from slab to slab.
    /// `support`, if any, fills void voxels.
    SlabDither(int32_t channels, openfab_isa isa, DitherRule rule, uint64_t seed, const Vec3i& size,
               const SupportFill* support = nullptr);

    /// Begins slices 8 slab .. 8 slab + 7 of `planes`, which was reset. Those not in `slices`, by
    /// bit, may be left unwritten.
    void begin(int32_t slab, uint8_t slices, SlabPlanes* planes);
    /// Adds the next row of blocks; rows without voxels may be skipped. Takes ownership of the band
    /// and returns the previous one for reuse.
    abi::KernelStatus add(RowBand* band, RowBand** released);
    /// Finishes after the last band. Returns 0 or a Halide error code.
    abi::KernelStatus end(RowBand** released);

    double seconds_dither = 0, seconds_support = 0, seconds_pack = 0;
    /// Changes codes of a band that has got its support; empty: nobody does.
    std::function<void(RowBand* band)> supported;

  private:
    void dither_rows(RowBand* band, int32_t first, int32_t count, const uint8_t* above,
                     const uint8_t* below);
    abi::KernelStatus finish_held(const uint8_t* below);
    abi::KernelStatus pack_held(int32_t first, int32_t end);

    DitherSetup setup_;
    const SupportFill* support_;
    int32_t z_ = 0;
    uint8_t slices_ = 0;
    SlabPlanes* planes_ = nullptr;
    RowBand* held_ = nullptr;
    std::vector<float> errors_;
    std::vector<uint8_t> nothing_mixed_;
};

}  // namespace openfab::dither
