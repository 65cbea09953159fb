// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles of a diced lattice patch by cell (surface/lattice.h), so that a triangle's
// neighbours are found by index. Cell (a, b) has an upper triangle U, (a, b) (a+1, b) (a, b+1), and
// a lower one D, (a+1, b) (a+1, b+1) (a, b+1); those of no area are absent.
//
//   edge                      triangles on it, the first owns it
//   H (a, b) - (a+1, b)       D(a, b-1) as its edge 1, U(a, b) as its edge 0
//   V (a, b) - (a, b+1)       D(a-1, b) as its edge 0, U(a, b) as its edge 2
//   X (a+1, b) - (a, b+1)     U(a, b) as its edge 1, D(a, b) as its edge 2
//   vertex (a, b)             D(a-1, b-1), U(a, b-1), D(a, b-1), U(a-1, b), D(a-1, b), U(a, b)

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/vec.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// A rectangle of cells.
struct CellBlock {
    int32_t a, b, width, height;
};

/// The cells of one patch.
class LatticeCells {
  public:
    /// Reads a diced patch of kind kLattice; returns false if it has other triangles than those of
    /// its lattice, as after a stop.
    bool read(const surface::Patch& patch, const surface::MicroMesh& mesh);

    int32_t columns() const { return columns_; }
    int32_t rows() const { return rows_; }
    /// The number of points in row b.
    int32_t points(int32_t b) const { return cells(b) + 1; }
    /// The vertex of the mesh at a lattice point.
    int32_t vertex(int32_t a, int32_t b) const { return first_[b] + a; }
    /// Returns the part of a block that may have cells.
    CellBlock clip(const CellBlock& block) const {
        const int32_t a0 = std::max(block.a, 0), b0 = std::max(block.b, 0);
        return {a0, b0, std::max(std::min(block.a + block.width, columns_) - a0, 0),
                std::max(std::min(block.b + block.height, rows_) - b0, 0)};
    }
    /// The triangle of the mesh, -1 if it is absent; one cell beyond the patch may be asked for.
    int32_t upper(int32_t a, int32_t b) const { return triangle_[slot(a, b)]; }
    int32_t lower(int32_t a, int32_t b) const { return triangle_[slot(a, b) + 1]; }
    /// Returns the number of triangles in a block, which may reach beyond the patch.
    int32_t count(const CellBlock& block) const {
        const CellBlock in = clip(block);
        const int32_t a1 = in.a + in.width, b1 = in.b + in.height;
        if (in.width == 0 || in.height == 0) return 0;
        return sum(a1, b1) - sum(in.a, b1) - sum(a1, in.b) + sum(in.a, in.b);
    }

  private:
    static constexpr size_t kSide = surface::kTileEdges + 2;

    int32_t cells(int32_t b) const { return std::min(columns_, longest_ - b); }
    static size_t slot(int32_t a, int32_t b) {
        return 2 * (static_cast<size_t>(b + 1) * kSide + static_cast<size_t>(a + 1));
    }
    int32_t sum(int32_t a, int32_t b) const {
        return sums_[static_cast<size_t>(b) * kSide + static_cast<size_t>(a)];
    }

    int32_t columns_ = 0, rows_ = 0, longest_ = 0;
    std::array<int32_t, kSide> first_{};  ///< [row]: vertex of its first point
    std::array<int16_t, 2 * kSide * kSide> triangle_;
    /// [row][column]: triangles in the cells below and left of it
    std::array<int16_t, kSide * kSide> sums_;
};

}  // namespace openfab::nearest
