// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Operators of coarser grids: 27 blocks of C x C a node, made from those of the finer grid by Galerkin's
// products with trilinear interpolation, so that mixtures and voids inside of a coarse cell count. They are
// symmetric, so that the blocks of half of the neighbours are kept: a node finds the others at these.

#include <cstdint>
#include <vector>

#include "mechanics/solver/element_operator.h"

namespace openfab::mechanics {

/// The grid of every other node: of n nodes (n + 1) / 2 of a periodic grid, n / 2 + 1 of another.
Grid coarser(const Grid& fine);

template <int C>
struct Stencil {
    Grid grid;
    static constexpr int kSelf = 13, kKept = 14;
    /// [z][y][neighbours 13 ... 26 of 27, x fastest][C][C][x], with a ghost at either end of a row, which
    /// is the node at the other end of a periodic grid, else 0.
    std::vector<float> blocks;

    size_t stride() const { return static_cast<size_t>(grid.nodes[0]) + 2; }
    size_t row_size() const { return size_t{kKept} * C * C * stride(); }
    size_t row_at(int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(grid.nodes[1]) +
                static_cast<size_t>(y)) *
               row_size();
    }
    /// The block of a node and its neighbour `o` of 13 ... 26, its numbers `stride` apart.
    const float* block(int32_t x, int32_t y, int32_t z, int o) const {
        return blocks.data() + row_at(y, z) + static_cast<size_t>((o - kSelf) * C * C) * stride() +
               static_cast<size_t>(x + 1);
    }
    /// Of any of the 27; 0 where there is no neighbour.
    float at(int32_t x, int32_t y, int32_t z, int o, int c, int d) const;
    /// Sets the ghosts of rows to what they stand for.
    void fill_ghosts();
    /// y = A x; fills the ghosts of x. `done` is called for each plane, several at once, when all of y is whole.
    void apply(Field<float, C>* x, Field<float, C>* y, const PlaneDone& done = nullptr) const;
    void inverse_diagonal(Field<float, C>* out) const;
};

/// Of the finest grid.
template <int C>
Stencil<C> coarsen(const ElementOperator<C>& fine);
template <int C>
Stencil<C> coarsen(const Stencil<C>& fine);

/// coarse = P^T fine. Fills no ghosts.
template <int C>
void restrict_to(const Field<float, C>& fine, const Grid& fine_grid, Field<float, C>* coarse);
/// fine += P coarse; fills the ghosts of coarse.
template <int C>
void add_prolonged(Field<float, C>* coarse, const Grid& fine_grid, Field<float, C>* fine);

}  // namespace openfab::mechanics
