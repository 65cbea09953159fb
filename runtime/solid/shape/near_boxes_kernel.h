// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Implements take_cubes; near_boxes_avx2.cpp and near_boxes_sse41.cpp compile it with the flags of their instruction sets.

#include <algorithm>

#include "runtime/solid/shape/near_boxes.h"
#include "simd/vectors.h"

namespace openfab::solid::OPENFAB_SIMD_ISA {
namespace {

using simd::Floats8;

inline void take(const NearLattice& lattice, std::span<const NearCube> cubes, size_t close,
                 size_t box, NearBoxes* boxes) {
    const NearRow* near[3];
    const NearRow* far[3];
    NearRow* to = lattice.table;
    for (size_t a = 0; a < 3; ++a) {
        const Floats8 lo = Floats8::load(&boxes->lo[a][box]),
                      hi = Floats8::load(&boxes->hi[a][box]);
        const auto first = static_cast<size_t>(lattice.first[a]);
        const size_t count = static_cast<size_t>(lattice.end[a]) - first;
        near[a] = to;
        far[a] = to + count;
        for (size_t i = 0; i < count; ++i, ++to) {
            const Floats8 from(lattice.sides[a][first + i]), end(lattice.sides[a][first + i + 1]);
            const Floats8 gap = max(max(from - hi, lo - end), Floats8(0.0f));
            const Floats8 most = max(hi - from, end - lo);
            store(to->of.data(), gap * gap);
            store(to[count].of.data(), most * most);
        }
        to += count;
    }
    Floats8 low = Floats8::load(&boxes->low2[box]), high = Floats8::load(&boxes->high2[box]);
    const auto sum = [&](const NearRow* const(&of)[3], const NearCube& cube) OPENFAB_INLINE_LAMBDA {
        const auto at = [&](size_t a) OPENFAB_INLINE_LAMBDA {
            return Floats8::load(of[a][cube.at[a] - lattice.first[a]].of.data());
        };
        return at(0) + at(1) + at(2);
    };
    const auto take_one = [&](const NearCube& cube) OPENFAB_INLINE_LAMBDA {
        low = min(sum(near, cube), low);
        if (cube.certain) high = min(sum(far, cube), high);
    };
    for (const NearCube& cube : cubes.first(close))
        take_one(cube);
    store(&boxes->high2[box], high);
    const float* of = &boxes->high2[box];
    const float needed = *std::max_element(of, of + kNearLanes);
    for (const NearCube& cube : cubes.subspan(close)) {
        if (!(cube.low2 > needed)) take_one(cube);
    }
    store(&boxes->low2[box], low);
    store(&boxes->high2[box], high);
}

}  // namespace
}  // namespace openfab::solid::OPENFAB_SIMD_ISA
