// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds of the distances of the pieces of a block, from its corners alone.
//
// For a point v between the corners c, v = sum w_c c with weights of 0 to 1 whose sum is 1, and any
// q it is |v - q|^2 = sum w_c |c - q|^2 - sum w_c |c - v|^2. No surface point q is closer to c than
// r_c, so the squared distance of v is no less than sum w_c r_c^2 - sum w_c |c - v|^2. With weights
// that are linear along each axis the second sum is that of h^2 (1 - t^2) over the axes, h half the
// block's side and t from -1 to 1.

#include <cstddef>

#include "runtime/nearest/kernel/corner_cache.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Positions of the pieces in the block, one piece per lane.
struct PieceLanes {
    /// Position of the outer centers, 0 at the block's low end, 1 at its high end.
    alignas(64) float end[3][2][kQuarters];
    alignas(64) float less[3][2][kQuarters];  ///< the axis's term of the second sum there, mm^2
    alignas(64) float center[3][kQuarters];   ///< from the block's low end, mm
    float reach[3];                           ///< from the center to the outer voxel centers, mm
    float axis[3][3];                         ///< unit vectors
};

inline void make_piece_lanes(const KernelInput& in, PieceLanes* lanes) {
    for (int a = 0; a < 3; ++a) {
        const float* step = in.frame + 3 * a;
        const float pitch =
            __builtin_sqrtf(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]);
        for (int c = 0; c < 3; ++c)
            lanes->axis[a][c] = step[c] / pitch;
        const float half2 = 16 * pitch * pitch, reach = in.shape->quarter_reach[a];
        lanes->reach[a] = reach * pitch;
        // Between the ends the sum is at least the linear interpolant less this.
        const float bend = half2 * (reach * 0.25f) * (reach * 0.25f);
        for (int q = 0; q < kQuarters; ++q) {
            const float low = static_cast<float>(in.shape->packet_origin[2 * q][a]) + 0.5f;
            lanes->center[a][q] = (low + reach) * pitch;
            for (int e = 0; e < 2; ++e) {
                const float at = (low + static_cast<float>(e) * 2 * reach) * 0.125f;
                const float t = 2 * at - 1;
                lanes->end[a][e][q] = at;
                lanes->less[a][e][q] = half2 * (1 - t * t) + bend;
            }
        }
    }
}

/// Returns the least value of the sum in each of the V::kLanes pieces from `first` on; `r2` are the
/// squared lower bounds of the corners.
template <typename V>
OPENFAB_INLINE V least_distance2(const PieceLanes& lanes, int first, const float* r2) {
    const auto end = [&](int a, int e) { return V::load(lanes.end[a][e] + first); };
    const auto less = [&](int a, int e) { return V::load(lanes.less[a][e] + first); };
    V least = V(kInfinity);
    for (int x = 0; x < 2; ++x) {
        V of_x[4];
        for (int k = 0; k < 4; ++k) {
            of_x[k] =
                about_mul_add(end(0, x), V(r2[2 * k + 1] - r2[2 * k]), V(r2[2 * k]) - less(0, x));
        }
        for (int y = 0; y < 2; ++y) {
            V of_y[2];
            for (int k = 0; k < 2; ++k) {
                const V low = of_x[2 * k], high = of_x[2 * k + 1];
                of_y[k] = about_mul_add(end(1, y), high - low, low - less(1, y));
            }
            for (int z = 0; z < 2; ++z) {
                least =
                    min(least, about_mul_add(end(2, z), of_y[1] - of_y[0], of_y[0] - less(2, z)));
            }
        }
    }
    return least;
}

/// Returns the least, over eight points, of the squared distance to the farthest center of each
/// piece, mm^2; the points are in the block's axes, relative to its low end.
template <typename V>
OPENFAB_INLINE V farthest_distance2(const PieceLanes& lanes, int first, const float (*point)[8]) {
    V most = V(kInfinity);
    for (int p = 0; p < 8; ++p) {
        V sum = V(0.0f);
        for (int a = 0; a < 3; ++a) {
            const V way =
                absolute(V::load(lanes.center[a] + first) - V(point[a][p])) + V(lanes.reach[a]);
            sum = about_mul_add(way, way, sum);
        }
        most = min(most, sum);
    }
    return most;
}

/// Bounds the distances of blocks, piece by piece.
void bound_blocks(const KernelInput& in, const Vec3i* blocks, size_t count, KernelScratch* scratch,
                  BlockBounds* bounds) {
    using V = simd::WidestFloats;
    prepare(in, blocks, count, scratch);
    PieceLanes lanes;
    make_piece_lanes(in, &lanes);
    for (size_t i = 0; i < count; ++i) {
        BlockCorners corners;
        corners.found = 0;
        if (in.root.nodes != nullptr) find_corners(in, blocks[i], kInfinity, scratch, &corners);
        if (corners.found != 0xff) {
            const float low = in.root.nodes == nullptr ? kInfinity : 0.0f;
            for (int q = 0; q < kQuarters; ++q) {
                bounds[i].low[q] = low;
                bounds[i].high[q] = kInfinity;
            }
            continue;
        }
        const float* f = in.frame;
        const auto x = static_cast<float>(blocks[i].x), y = static_cast<float>(blocks[i].y),
                   z = static_cast<float>(blocks[i].z);
        float origin[3], largest = in.largest_coordinate;
        for (int c = 0; c < 3; ++c) {
            origin[c] = (x * f[OPENFAB_FRAME_STEP_I + c] + y * f[OPENFAB_FRAME_STEP_J + c]) +
                        z * f[OPENFAB_FRAME_STEP_K + c] + f[OPENFAB_FRAME_ORIGIN + c];
            largest = larger(largest, __builtin_fabsf(origin[c]) + 2 * in.shape->half_diagonal);
        }
        alignas(32) float point[3][8];
        const Points p{Floats8::load(corners.point[0]), Floats8::load(corners.point[1]),
                       Floats8::load(corners.point[2])};
        for (int a = 0; a < 3; ++a) {
            const float* axis = lanes.axis[a];
            const Floats8 from_x = p.x - Floats8(origin[0]), from_y = p.y - Floats8(origin[1]),
                          from_z = p.z - Floats8(origin[2]);
            store(point[a], dot3(Floats8(axis[0]), Floats8(axis[1]), Floats8(axis[2]), from_x,
                                 from_y, from_z));
        }
        float r2[8], most2 = 0;
        for (int c = 0; c < 8; ++c) {
            r2[c] = corners.lower[c] * corners.lower[c];
            most2 = larger(most2, r2[c]);
        }
        // Bounds of the rounding of squares, and of positions.
        const V rounded2 = V(most2 * 0x1p-19f), rounded = V(largest * 0x1p-17f);
        const V zero = V(0.0f);
        for (int first = 0; first < kQuarters; first += V::kLanes) {
            const V low2 = least_distance2<V>(lanes, first, r2) - rounded2;
            const V high2 = farthest_distance2<V>(lanes, first, point);
            store(bounds[i].low + first, max(sqrt(max(low2, zero)) - rounded, zero));
            store(bounds[i].high + first, about_mul_add(sqrt(high2), V(1.0f + 0x1p-16f), rounded));
        }
    }
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
