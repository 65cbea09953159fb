// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds of the distances of 32 boxes from many cubes of a lattice, for ShapeNear. The square of a distance between two
// boxes is a sum over the axes, and cubes of a lattice share their sides: what a side is from each box is found once, and
// a cube costs two additions and a minimum for eight boxes. Cubes come from blocks of 64, of which eight are looked at a time.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vec.h"

namespace openfab::solid {

/// A cube of a lattice by its numbers along x, y and z.
struct NearCube {
    std::array<int32_t, 3> at;
    float low2;    ///< square of its least distance from what holds all boxes
    bool certain;  ///< a surface passes through it
};

/// A block of 4 x 4 x 4 cubes. Bit (z * 4 + y) * 4 + x of a mask is a cube.
struct NearBlock {
    std::array<int32_t, 3> first;       ///< numbers of its lowest cube
    std::array<const float*, 3> sides;  ///< by axis: its five sides
    uint64_t possible = 0, certain = 0;
};
constexpr int kBlockCubes = 4;
constexpr size_t kMostBlockCubes = 64;

/// Lowers `nearest2` to the square of the least distance within which a certain cube is from any point of `whole`; writes
/// the possible cubes that are not farther, and returns how many. `cubes` has room for all of a block.
using AddCubes = size_t (*)(const NearBlock& block, const Box3f& whole, float* nearest2,
                            NearCube* cubes);

constexpr size_t kNearLanes = 8;
constexpr size_t kMostNearBoxes = 32;

struct NearBoxes {
    alignas(32) std::array<std::array<float, kMostNearBoxes>, 3> lo, hi;  ///< [axis][box]
    /// Squares: of the least distance from a cube, at first the most that it can be; of the least distance
    /// within which a cube is that is certain, all of it.
    alignas(32) std::array<float, kMostNearBoxes> low2, high2;
};

/// What eight boxes have.
struct alignas(32) NearRow {
    std::array<float, kNearLanes> of;
};

struct NearLattice {
    std::array<const float*, 3> sides;  ///< by axis: cube i is between sides i and i + 1
    std::array<int32_t, 3> first, end;  ///< numbers of the cubes that are taken
    NearRow* table;                     ///< room for two of each place along each axis
};

/// Takes the cubes for eight boxes from `box` on. Of cubes behind `close` those are passed over that are farther than any
/// of the boxes needs.
using TakeCubes = void (*)(const NearLattice& lattice, std::span<const NearCube> cubes,
                           size_t close, size_t box, NearBoxes* boxes);

/// What this machine's instruction set has; all give the same bits.
struct NearKernels {
    TakeCubes take;
    AddCubes add;
};
NearKernels near_kernels();
NearKernels near_kernels_sse41();
NearKernels near_kernels_avx2();

}  // namespace openfab::solid
