// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The cached corners of blocks: the surface point nearest to a corner is a witness for the blocks
// around it, and its distance bounds theirs.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Tolerance of the surface points of corners, in half diagonals of a block.
constexpr float kCornerTolerance = 0.35f;
/// The same for what would have to be diced, where a query is bounded: mostly no voxel needs it.
constexpr float kUndicedTolerance = 1.0f;

OPENFAB_INLINE void corner_voxel(const Vec3i& block, int c, int32_t* voxel) {
    voxel[0] = block.x + ((c & 1) != 0 ? 8 : 0);
    voxel[1] = block.y + ((c & 2) != 0 ? 8 : 0);
    voxel[2] = block.z + ((c & 4) != 0 ? 8 : 0);
}

/// Returns the cache entry of a corner; corners of adjacent blocks never share one.
OPENFAB_INLINE CornerEntry* corner_entry(const int32_t* voxel, KernelScratch* scratch) {
    const auto x = static_cast<uint32_t>(voxel[0]) >> 3, y = static_cast<uint32_t>(voxel[1]) >> 3,
               z = static_cast<uint32_t>(voxel[2]) >> 3;
    static_assert(kCornerEntries == 1u << 13);
    return scratch->corner_cache + ((z & 1) << 12 | (y & 31) << 7 | (x & 127));
}

/// Up to 8 corners of blocks, by the voxels whose lowest they are.
struct CornerList {
    int32_t voxel[8][3];
    int count = 0;

    OPENFAB_INLINE void push(const int32_t* v) {
        for (int a = 0; a < 3; ++a)
            voxel[count][a] = v[a];
        ++count;
    }
    /// Unused lanes repeat the last corner.
    OPENFAB_INLINE const int32_t* of_lane(int l) const { return voxel[l < count ? l : count - 1]; }
};

OPENFAB_INLINE bool matches(const CornerEntry& e, const KernelInput& in, const int32_t* voxel) {
    return e.engine == in.engine && e.voxel[0] == voxel[0] && e.voxel[1] == voxel[1] &&
           e.voxel[2] == voxel[2];
}

/// Updates the witnesses of each corner with the cached points of its lower neighbours.
OPENFAB_INLINE void update_witness_neighbours(const KernelInput& in, const CornerList& list,
                                              const Points& p, KernelScratch* scratch,
                                              Witnesses* w) {
    for (int axis = 0; axis < 3; ++axis) {
        alignas(32) float point[3][8];
        for (int l = 0; l < 8; ++l) {
            int32_t voxel[3];
            __builtin_memcpy(voxel, list.of_lane(l), sizeof(voxel));
            voxel[axis] -= 8;
            const CornerEntry& e = *corner_entry(voxel, scratch);
            const bool cached = matches(e, in, voxel) && e.reach == kInfinity;
            for (int c = 0; c < 3; ++c)
                point[c][l] = cached ? e.point[c] : kInfinity;
        }
        update_witness_points(
            {Floats8::load(point[0]), Floats8::load(point[1]), Floats8::load(point[2])}, p, w);
    }
}

/// Searches the surface points nearest to the corners of a non-empty list at once, and caches them.
__attribute__((noinline)) void search_corners(const KernelInput& in, const CornerList& list,
                                              float radius, KernelScratch* scratch,
                                              CornerEntry* entries) {
    alignas(32) float p[3][8];
    float largest = in.largest_coordinate;
    const float* f = in.frame;
    for (int l = 0; l < 8; ++l) {
        const int32_t* voxel = list.of_lane(l);
        for (int c = 0; c < 3; ++c) {
            p[c][l] = (static_cast<float>(voxel[0]) * f[OPENFAB_FRAME_STEP_I + c] +
                       static_cast<float>(voxel[1]) * f[OPENFAB_FRAME_STEP_J + c]) +
                      static_cast<float>(voxel[2]) * f[OPENFAB_FRAME_STEP_K + c] +
                      f[OPENFAB_FRAME_ORIGIN + c];
            largest = larger(largest, __builtin_fabsf(p[c][l]));
        }
    }
    const Points points{Floats8::load(p[0]), Floats8::load(p[1]), Floats8::load(p[2])};
    const float half_diagonal = in.shape->half_diagonal;
    const float off = kCornerTolerance * half_diagonal;
    // Every voxel has a corner of its block within half the diagonal; with a little more the corner
    // can also rule out its whole sub-block.
    const float reach = radius + 1.25f * half_diagonal;
    Witnesses w{Floats8(reach < kInfinity ? reach * reach : kInfinity),
                Floats8(0),
                Floats8(0),
                Floats8(0),
                0,
                Floats8(off * off)};
    if (radius < kInfinity) {
        const float undiced = kUndicedTolerance * half_diagonal;
        w.undiced2 = Floats8(undiced * undiced);
    }
    WarmStart& warm = scratch->warm;
    for (int i = 0; i < warm.count; ++i)
        update_witness_point(warm.point[0][i], warm.point[1][i], warm.point[2][i], points, &w);
    update_witness_neighbours(in, list, points, scratch, &w);
    find_witnesses({&in.root, 0}, points, scratch, &w);
    const Floats8 least2 = min(max(w.distance2 - w.tolerance2, Floats8(0.0f)), w.passed2);
    const Floats8 least =
        max(sqrt(least2) * Floats8(1.0f - 0x1p-18f) - Floats8(largest * 0x1p-18f), Floats8(0.0f));
    alignas(32) float point[3][8], lower[8];
    store(point[0], w.x);
    store(point[1], w.y);
    store(point[2], w.z);
    store(lower, least);
    if (w.found != 0) warm.count = 0;
    for (int c = 0; c < list.count; ++c) {
        const bool found = (w.found >> c & 1u) != 0;
        const int32_t* voxel = list.voxel[c];
        entries[c] = {in.engine,
                      {voxel[0], voxel[1], voxel[2]},
                      {point[0][c], point[1][c], point[2][c]},
                      lower[c],
                      found ? kInfinity : radius};
        *corner_entry(voxel, scratch) = entries[c];
        if (!found) continue;
        for (int a = 0; a < 3; ++a)
            warm.point[a][warm.count] = point[a][c];
        ++warm.count;
    }
}

OPENFAB_INLINE void take_corner(const CornerEntry& e, int c, BlockCorners* corners) {
    for (int a = 0; a < 3; ++a)
        corners->point[a][c] = e.point[a];
    corners->lower[c] = e.lower;
    if (e.reach == kInfinity) corners->found |= 1u << c;
}

OPENFAB_INLINE void start_from(const BlockCorners& corners, WarmStart* warm) {
    if (corners.found != 0) warm->count = 0;
    for (uint32_t found = corners.found; found != 0; found &= found - 1) {
        for (int a = 0; a < 3; ++a)
            warm->point[a][warm->count] = corners.point[a][__builtin_ctz(found)];
        ++warm->count;
    }
}

/// Gets the corners of the block from the cache or by searching.
inline void find_corners(const KernelInput& in, const Vec3i& block, float radius,
                         KernelScratch* scratch, BlockCorners* corners) {
    CornerList missing;
    int corner[8];
    corners->found = 0;
    for (int c = 0; c < 8; ++c) {
        int32_t voxel[3];
        corner_voxel(block, c, voxel);
        const CornerEntry& e = *corner_entry(voxel, scratch);
        if (matches(e, in, voxel) && e.reach >= radius) {
            take_corner(e, c, corners);
        } else {
            corner[missing.count] = c;
            missing.push(voxel);
        }
    }
    start_from(*corners, &scratch->warm);
    if (missing.count == 0) return;
    CornerEntry entries[8];
    search_corners(in, missing, radius, scratch, entries);
    for (int i = 0; i < missing.count; ++i)
        take_corner(entries[i], corner[i], corners);
    start_from(*corners, &scratch->warm);
}

/// Caches the corners of many blocks; those of all that are missing are searched together.
void prepare(const KernelInput& in, const Vec3i* blocks, size_t count, KernelScratch* scratch) {
    if (in.root.nodes == nullptr) return;
    CornerList missing;
    CornerEntry entries[8];
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 8; ++c) {
            int32_t voxel[3];
            corner_voxel(blocks[i], c, voxel);
            CornerEntry& e = *corner_entry(voxel, scratch);
            if (matches(e, in, voxel) && e.reach == kInfinity) continue;
            // Counts as cached from here on: other blocks share the corner.
            e = {in.engine,
                 {voxel[0], voxel[1], voxel[2]},
                 {kInfinity, kInfinity, kInfinity},
                 0.0f,
                 kInfinity};
            missing.push(voxel);
            if (missing.count < 8) continue;
            search_corners(in, missing, kInfinity, scratch, entries);
            missing.count = 0;
        }
    }
    if (missing.count != 0) search_corners(in, missing, kInfinity, scratch, entries);
}

/// Returns bit s set if sub-block s may have a voxel within the radius: a distance changes by no
/// more than the distance from the corner.
OPENFAB_INLINE uint32_t sub_blocks_in_reach(const KernelInput& in, const BlockCorners& corners,
                                            float radius) {
    uint32_t mask = 0xff;
    for (int c = 0; c < 8; ++c) {
        for (int s = 0; s < 8; ++s) {
            if (corners.lower[c] - in.shape->farthest[c][s] > radius) mask &= ~(1u << s);
        }
    }
    return mask;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
