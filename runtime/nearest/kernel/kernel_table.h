// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The query kernel. avx512.cpp, avx2.cpp and sse41.cpp compile it, each with the flags of a set.
// All of it has internal linkage, so that each set inlines as if it were the only one.
//
// Notation: c are the 8 corners of a box of voxel centers, one per lane; a is a known surface point
// (a witness); X is a part of the surface.
// *Corner domination*: if dist²(c, X) > |c - a|² at all 8 corners, X
// holds the nearest point of no point of the box, because |p - x|² - |p - a|² is linear in p for
// each x, so their least over x is concave. One test decides for the whole box.
//
// Every test errs towards keeping. With delta = 2^-19 of the largest coordinate in play, a squared
// distance r² that something is compared with becomes (r + delta)² (1 + 2^-18) + 2^-40: delta holds
// the float errors of positions, boxes and `closest_point` (rule 15 gives the rest), so what is
// dropped could not have given even equal bits.

#include "runtime/nearest/kernel/block.h"
#include "runtime/nearest/kernel/block_bounds.h"
#include "runtime/nearest/kernel/corner_cache.h"
#include "runtime/nearest/kernel/cube.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/points.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {

extern const KernelTable kKernels;
const KernelTable kKernels = {query, prepare, query_points, bound_points, bound_blocks, bound_cube};

}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
