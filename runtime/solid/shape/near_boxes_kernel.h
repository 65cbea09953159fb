// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Implements NearKernels; near_boxes_avx2.cpp and near_boxes_sse41.cpp compile it with the flags of their instruction sets.

#include <algorithm>
#include <bit>

#include "runtime/solid/shape/near_boxes.h"
#include "simd/vectors.h"

namespace openfab::solid::OPENFAB_SIMD_ISA {
namespace {

using simd::Floats8;
using simd::Mask8;

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

/// Two rows of cubes at a time: a byte of the masks. Sums over the axes are in the order of x, y and z, as for boxes.
inline size_t add(const NearBlock& block, const Box3f& whole, float* nearest2, NearCube* cubes) {
    static_assert(kBlockCubes == 4);
    alignas(32) float gaps[3][8], mosts[3][8];
    for (size_t a = 0; a < 3; ++a) {
        const int axis = static_cast<int>(a);
        for (size_t k = 0; k < 4; ++k) {
            const float from = block.sides[a][k], end = block.sides[a][k + 1];
            const float gap = std::max(std::max(from - whole.hi[axis], whole.lo[axis] - end), 0.0f);
            const float most = std::max(whole.hi[axis] - from, end - whole.lo[axis]);
            // Along y a row has one value, and the next row the next.
            gaps[a][k] = gap * gap;
            mosts[a][k] = most * most;
        }
    }
    const auto rows_of = [](const float(&of)[3][8], Floats8* rows) OPENFAB_INLINE_LAMBDA {
        alignas(32) float xs[8], ys[8];
        for (size_t pair = 0; pair < 2; ++pair) {
            for (size_t i = 0; i < 8; ++i) {
                xs[i] = of[0][i % 4];
                ys[i] = of[1][2 * pair + i / 4];
            }
            rows[pair] = Floats8::load(xs) + Floats8::load(ys);
        }
    };
    Floats8 low[2], high[2];
    rows_of(gaps, low);
    rows_of(mosts, high);
    Floats8 nearest(*nearest2);
    for (size_t byte = 0; byte < 8; ++byte) {
        const auto bits = static_cast<uint32_t>(block.certain >> 8 * byte & 0xff);
        if (bits == 0) continue;
        const Floats8 most = high[byte % 2] + Floats8(mosts[2][byte / 2]);
        nearest = select(Mask8::from_bits(bits), min(most, nearest), nearest);
    }
    alignas(32) float lanes[8];
    store(lanes, nearest);
    *nearest2 = *std::min_element(lanes, lanes + 8);
    const Floats8 needed(*nearest2);
    size_t count = 0;
    for (size_t byte = 0; byte < 8; ++byte) {
        const auto possible = static_cast<uint32_t>(block.possible >> 8 * byte & 0xff);
        if (possible == 0) continue;
        const Floats8 least = low[byte % 2] + Floats8(gaps[2][byte / 2]);
        uint32_t left = static_cast<uint32_t>(bits(least <= needed)) & possible;
        if (left == 0) continue;
        store(lanes, least);
        for (; left != 0; left &= left - 1) {
            const int lane = std::countr_zero(left);
            cubes[count++] = {{block.first[0] + lane % 4,
                               block.first[1] + 2 * static_cast<int32_t>(byte % 2) + lane / 4,
                               block.first[2] + static_cast<int32_t>(byte / 2)},
                              lanes[lane],
                              (block.certain >> (8 * byte + static_cast<size_t>(lane)) & 1) != 0};
        }
    }
    return count;
}

}  // namespace
}  // namespace openfab::solid::OPENFAB_SIMD_ISA
