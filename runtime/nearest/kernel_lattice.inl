// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The corners of blocks: the surface point nearest to each is a witness for the blocks around it,
// and its distance bounds theirs. Part of kernel.inl.

/// How far beside the nearest surface point a corner's may lie, in half diagonals of a block.
constexpr float kLatticeOff = 0.35f;

/// The 8 corners of a block, bits 0 to 2 the upper end of x, y, z.
struct BlockCorners {
    float x[8], y[8], z[8];  ///< a surface point near each
    float lower[8];          ///< no surface point is closer to it, mm
    uint32_t found;          ///< bit c: there is one within reach
};

OPENFAB_INLINE void corner_voxel(const Vec3i& block, int c, int32_t* voxel) {
    voxel[0] = block.x + ((c & 1) != 0 ? 8 : 0);
    voxel[1] = block.y + ((c & 2) != 0 ? 8 : 0);
    voxel[2] = block.z + ((c & 4) != 0 ? 8 : 0);
}

OPENFAB_INLINE LatticeEntry* lattice_entry(const int32_t* voxel, KernelScratch* scratch) {
    const uint32_t hash = static_cast<uint32_t>(voxel[0]) * 0x9e3779b1u ^
                          static_cast<uint32_t>(voxel[1]) * 0x85ebca77u ^
                          static_cast<uint32_t>(voxel[2]) * 0xc2b2ae3du;
    static_assert(kLatticeEntries == 1u << 12);
    return scratch->lattice.data + ((hash ^ hash >> 15) * 0x2c1b3c6du >> 20);
}

/// Searches the surface points nearest to the corners in `missing`, all together.
__attribute__((noinline)) void search_corners(const KernelInput& in, const BlockQuery& q,
                                              uint32_t missing, KernelScratch* scratch,
                                              BlockCorners* corners) {
    const int first = __builtin_ctz(missing);
    alignas(32) float p[3][8];
    int32_t voxel[8][3];
    float largest = in.largest_coordinate;
    const float* f = in.frame;
    for (int l = 0; l < 8; ++l) {
        // Lanes that are not missing repeat one that is.
        corner_voxel(q.block, (missing >> l & 1u) != 0 ? l : first, voxel[l]);
        for (int c = 0; c < 3; ++c) {
            p[c][l] = (static_cast<float>(voxel[l][0]) * f[OPENFAB_FRAME_STEP_I + c] +
                       static_cast<float>(voxel[l][1]) * f[OPENFAB_FRAME_STEP_J + c]) +
                      static_cast<float>(voxel[l][2]) * f[OPENFAB_FRAME_STEP_K + c] +
                      f[OPENFAB_FRAME_ORIGIN + c];
            largest = larger(largest, __builtin_fabsf(p[c][l]));
        }
    }
    const Points points{load(p[0]), load(p[1]), load(p[2])};
    const float half_diagonal = in.shape->half_diagonal;
    const float off = kLatticeOff * half_diagonal;
    // A voxel has a corner of its block within half the diagonal; a little more lets the corner
    // tell that none of its sub-block is within the radius.
    const float reach = q.radius_mm + 1.25f * half_diagonal;
    Witnesses w{set1(reach < kInfinity ? reach * reach : kInfinity),
                set1(0),
                set1(0),
                set1(0),
                0,
                set1(off * off)};
    const WarmStart& warm = scratch->warm;
    for (int i = 0; i < warm.count; ++i)
        offer_point(warm.point[0][i], warm.point[1][i], warm.point[2][i], points, &w);
    for (int c = 0; c < 8; ++c) {
        if ((corners->found >> c & 1u) != 0)
            offer_point(corners->x[c], corners->y[c], corners->z[c], points, &w);
    }
    find_witnesses({&in.root, 0}, points, scratch, &w);
    const F8 least2 = max(w.distance2 - w.enough, set1(0.0f));
    const F8 least =
        max(sqrt(least2) * set1(1.0f - 0x1p-18f) - set1(largest * 0x1p-18f), set1(0.0f));
    alignas(32) float x[8], y[8], z[8], lower[8];
    store(x, w.x);
    store(y, w.y);
    store(z, w.z);
    store(lower, least);
    for (int c = 0; c < 8; ++c) {
        if ((missing >> c & 1u) == 0) continue;
        const bool found = (w.found >> c & 1u) != 0;
        corners->x[c] = x[c];
        corners->y[c] = y[c];
        corners->z[c] = z[c];
        corners->lower[c] = lower[c];
        if (found) corners->found |= 1u << c;
        *lattice_entry(voxel[c], scratch) = {in.engine,
                                             {voxel[c][0], voxel[c][1], voxel[c][2]},
                                             {x[c], y[c], z[c]},
                                             lower[c],
                                             found ? kInfinity : q.radius_mm};
    }
}

/// Surface points near the block in the place of those near its corners.
inline void take_near_points(const BlockQuery& q, BlockCorners* corners) {
    const size_t count = q.near.size() < 8 ? q.near.size() : 8;
    for (size_t i = 0; i < count; ++i) {
        corners->x[i] = q.near[i].x;
        corners->y[i] = q.near[i].y;
        corners->z[i] = q.near[i].z;
    }
    corners->found = (1u << count) - 1;
}

/// The corners of the block, from what is kept or by searching.
inline void find_corners(const KernelInput& in, const BlockQuery& q, KernelScratch* scratch,
                         BlockCorners* corners) {
    uint32_t missing = 0;
    corners->found = 0;
    for (int c = 0; c < 8; ++c) {
        int32_t voxel[3];
        corner_voxel(q.block, c, voxel);
        const LatticeEntry& e = *lattice_entry(voxel, scratch);
        const bool known = e.engine == in.engine && e.voxel[0] == voxel[0] &&
                           e.voxel[1] == voxel[1] && e.voxel[2] == voxel[2] &&
                           e.reach >= q.radius_mm;
        if (!known) {
            missing |= 1u << c;
            continue;
        }
        if (e.reach == kInfinity) corners->found |= 1u << c;
        corners->x[c] = e.point[0];
        corners->y[c] = e.point[1];
        corners->z[c] = e.point[2];
        corners->lower[c] = e.lower;
    }
    if (missing != 0) search_corners(in, q, missing, scratch, corners);
    WarmStart& warm = scratch->warm;
    if (corners->found != 0) warm.count = 0;
    for (uint32_t found = corners->found; found != 0; found &= found - 1) {
        const int c = __builtin_ctz(found);
        warm.point[0][warm.count] = corners->x[c];
        warm.point[1][warm.count] = corners->y[c];
        warm.point[2][warm.count] = corners->z[c];
        ++warm.count;
    }
}

/// Bit s: sub-block s may have a voxel within the radius. A distance changes by no more than the
/// way from the corner.
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
