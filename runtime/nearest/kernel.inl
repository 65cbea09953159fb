// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The query kernel. Included by kernel_avx512.cpp, kernel_avx2.cpp and kernel_sse41.cpp.
//
// Notation: c the 8 corners of a box of voxel centres, one a lane; a a known surface point (a
// witness); X a set of surface. *Corner domination*: if dist²(c, X) > |c - a|² at all 8 corners, X
// holds the nearest point of no point of the box, because |p - x|² - |p - a|² is linear in p for
// each x, so their least over x is concave. One test decides for the whole box.
//
// Every test errs towards keeping. With delta = 2^-19 of the largest coordinate in play, a squared
// distance r² that something is compared with becomes (r + delta)² (1 + 2^-18) + 2^-40: delta holds
// the float errors of positions, boxes and `closest_point` (rule 15 gives the rest), so what is
// dropped could not have given even equal bits.

#include "runtime/nearest/kernel.h"
#include "runtime/nearest/simd.h"
#include "runtime/nearest/simd_fixed.h"

namespace openfab::nearest::OPENFAB_NEAREST_ISA {
namespace {

#include "runtime/nearest/kernel_packet.inl"

#include "runtime/nearest/kernel_box.inl"

#include "runtime/nearest/kernel_answers.inl"

#include "runtime/nearest/kernel_best.inl"

#include "runtime/nearest/kernel_search.inl"

#include "runtime/nearest/kernel_place.inl"

#include "runtime/nearest/kernel_nodes.inl"

#include "runtime/nearest/kernel_sub_blocks.inl"

#include "runtime/nearest/kernel_sides.inl"

#include "runtime/nearest/kernel_features.inl"

#include "runtime/nearest/kernel_lattice.inl"

#include "runtime/nearest/kernel_pieces.inl"

#include "runtime/nearest/kernel_near.inl"

#include "runtime/nearest/kernel_block.inl"

#include "runtime/nearest/kernel_cube.inl"

#include "runtime/nearest/kernel_points.inl"

}  // namespace

extern const KernelTable kKernels;
const KernelTable kKernels = {query, prepare, points, bound_points, bound_blocks, cube};

}  // namespace openfab::nearest::OPENFAB_NEAREST_ISA
