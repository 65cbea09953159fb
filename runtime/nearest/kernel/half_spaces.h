// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tests of the half-spaces of a leaf's features (tree/leaf_features.h) against parts of a block,
// one feature per lane, in fixed point.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/block_frame.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "simd/fixed.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

using simd::Fixed16;

/// Bound of the error that rounding a half-space's normal causes, relative to the distance from the
/// feature: each component is off by less than half a unit.
constexpr float kNormalError = 0x1p-15f;

/// A block in the units of half-space tests: what all its leaves share.
struct HalfSpaceFrame {
    const BlockShape* shape;
    float center[3];  ///< of the block, part space
    /// Half of the block along x, y, z, three values each, then zeros.
    alignas(32) float half[16];
    bool aligned;  ///< the block's axes are those of part space
    float half_diagonal;
    /// How far beyond a half-space a part must lie to be pruned: if the half-space alone excludes
    /// the feature, and if it only tells that another feature is nearer.
    float limit, excess;
    // In units of 2^-15 of those halves: from the block's center to a sub-block's for each bit of
    // its number, from there to a quarter's, and from their centers to their outer voxel centers.
    int32_t to_sub[3], to_quarter[2], sub_reach[3], quarter_reach[3];
};

OPENFAB_INLINE HalfSpaceFrame make_half_space_frame(const BlockFrame& frame, float longest_edge) {
    constexpr float kHalf = 4;  // voxels
    const BlockShape& shape = *frame.shape;
    HalfSpaceFrame out;
    out.shape = frame.shape;
    out.aligned = true;
    for (int a = 0; a < 3; ++a) {
        out.center[a] = frame.center[a];
        for (int c = 0; c < 3; ++c) {
            const float step = frame.step[3 * a + c];
            out.half[3 * a + c] = kHalf * step;
            out.aligned &= a == c || step == 0;
        }
    }
    for (int i = 9; i < 16; ++i)
        out.half[i] = 0;
    out.half_diagonal = shape.half_diagonal;
    const float farthest = longest_edge + frame.reach;
    out.limit = frame.slack + farthest * kNormalError;
    const float rounded = farthest * kRounded;
    out.excess = rounded < frame.excess ? rounded : frame.excess;
    const auto part_of = [](float voxels) {
        return static_cast<int32_t>(voxels * (32768 / kHalf));
    };
    for (int i = 0; i < 3; ++i) {
        out.to_sub[i] = part_of(shape.sub_half[i]);
        out.sub_reach[i] = part_of(shape.sub_reach[i]);
        out.quarter_reach[i] = part_of(shape.quarter_reach[i]);
    }
    for (int i = 0; i < 2; ++i)
        out.to_quarter[i] = part_of(shape.quarter_half[i]);
    return out;
}

/// A block in the fixed-point units of one leaf. The unit is such that no distance from the leaf's
/// origin to a voxel of the block, plus the size of the leaf, exceeds kMaxDistance.
struct LeafFrame {
    int32_t center[3];             ///< center of the block, from the leaf's origin
    alignas(32) int32_t half[16];  ///< as in HalfSpaceFrame
    int32_t step;                  ///< of offsets, 2^-15
    int32_t limit, excess_limit;

    OPENFAB_INLINE LeafFrame(const HalfSpaceFrame& frame, const LeafFeatures& leaf) {
        float from_origin[3], far2 = 0;
        for (int c = 0; c < 3; ++c) {
            from_origin[c] = frame.center[c] - leaf.origin[c];
            far2 += from_origin[c] * from_origin[c];
        }
        const float size = leaf.step * HalfSpaces::kUnit;
        const float per_mm = kMaxDistance / (__builtin_sqrtf(far2) + (frame.half_diagonal + size));
        for (int c = 0; c < 3; ++c)
            center[c] = static_cast<int32_t>(from_origin[c] * per_mm);
        store(half, round_to_ints(Floats8::load(frame.half) * Floats8(per_mm)));
        store(half + 8, round_to_ints(Floats8::load(frame.half + 8) * Floats8(per_mm)));
        step = static_cast<int32_t>(size * per_mm);
        limit = limit_of(frame.limit * per_mm);
        // Drops any of `excess` along the shortest side.
        const float drop = frame.excess * larger(1.0f, frame.excess * leaf.inv_reach);
        excess_limit = limit_of((drop + frame.limit) * per_mm);
    }

  private:
    static constexpr float kMaxDistance = 32000;
    /// Bound of the rounding error, in units. At the block's center 5.3: one per coordinate, which
    /// together count at most sqrt(3), half of one per product, two for offsets. From its halves
    /// 2.4 each, as no quarter reaches farther along an axis than one half. 1.5 for each of the 8
    /// terms in a quarter's sums. One more is lost in a limit.
    static constexpr float kRounding = 26;
    static OPENFAB_INLINE int32_t limit_of(float units) {
        const float limit = units + kRounding;
        return static_cast<int32_t>(limit < 32767 ? limit : 32767);
    }
};

/// Tests the half-spaces of 16 features of a leaf.
class LeafTest {
  public:
    /// Loads the first of the `stride` lanes stored at `values`: faces in the lanes below `faces`,
    /// then edges in those below `edges`, then vertices.
    OPENFAB_INLINE LeafTest(const HalfSpaceFrame& frame, const LeafFrame& leaf,
                            const int16_t* values, size_t stride, int32_t faces, int32_t edges) {
        const Fixed16 lane = simd::fixed_lane_numbers();
        const Fixed16 own = Fixed16(leaf.limit), excess_limit = Fixed16(leaf.excess_limit);
        const Fixed16 limits[2] = {select(Fixed16(faces) > lane, own, excess_limit),
                                   select(Fixed16(edges) > lane, own, excess_limit)};
        for (int k = 0; k < kHalfSpaces; ++k, values += 4 * stride) {
            const Fixed16 d[3] = {Fixed16::load_unaligned(values),
                                  Fixed16::load_unaligned(values + stride),
                                  Fixed16::load_unaligned(values + 2 * stride)};
            at_center_[k] = along(d, leaf.center) +
                            times(Fixed16::load_unaligned(values + 3 * stride), Fixed16(leaf.step));
            Fixed16 half[3];
            for (int a = 0; a < 3; ++a) {
                const int32_t* h = leaf.half + 3 * a;
                half[a] = frame.aligned ? times(d[a], Fixed16(h[a])) : along(d, h);
            }
            for (int i = 0; i < 3; ++i) {
                const Fixed16 to = times(half[frame.shape->sub_axis[i]], Fixed16(frame.to_sub[i]));
                to_sub_[k][i][0] = Fixed16(0) - to;
                to_sub_[k][i][1] = to;
            }
            Fixed16 sub_reach = Fixed16(0), quarter_reach = Fixed16(0);
            for (int a = 0; a < 3; ++a) {
                const Fixed16 way = absolute(half[a]);
                sub_reach = sub_reach + times(way, Fixed16(frame.sub_reach[a]));
                quarter_reach = quarter_reach + times(way, Fixed16(frame.quarter_reach[a]));
            }
            const Fixed16 limit = limits[k / 2];
            sub_limit_[k] = add_capped(sub_reach, limit);
            Fixed16 to_quarter[2];
            for (int i = 0; i < 2; ++i)
                to_quarter[i] =
                    times(half[frame.shape->quarter_axis[i]], Fixed16(frame.to_quarter[i]));
            for (int q = 0; q < 4; ++q) {
                Fixed16 r = quarter_reach;
                for (int i = 0; i < 2; ++i)
                    r = (q >> i & 1) != 0 ? r - to_quarter[i] : r + to_quarter[i];
                quarter_limit_[k][q] = add_capped(r, limit);
            }
        }
    }
    /// Enters a sub-block. Returns bit l set if the feature of lane l is a candidate there.
    OPENFAB_INLINE uint32_t enter(int sub) {
        Fixed16 excluded = Fixed16(0);
        for (int k = 0; k < kHalfSpaces; ++k) {
            const auto& to = to_sub_[k];
            at_[k] = (at_center_[k] + to[0][sub & 1]) + (to[1][sub >> 1 & 1] + to[2][sub >> 2]);
            excluded = excluded | (at_[k] > sub_limit_[k]);
        }
        return ~bits(excluded);
    }
    /// Returns the candidates of a quarter of that sub-block.
    OPENFAB_INLINE uint32_t candidates_in(int quarter) const {
        Fixed16 excluded = Fixed16(0);
        for (int k = 0; k < kHalfSpaces; ++k)
            excluded = excluded | (at_[k] > quarter_limit_[k][quarter]);
        return ~bits(excluded);
    }

  private:
    static OPENFAB_INLINE Fixed16 along(const Fixed16* d, const int32_t* way) {
        return (times(d[0], Fixed16(way[0])) + times(d[1], Fixed16(way[1]))) +
               times(d[2], Fixed16(way[2]));
    }

    Fixed16 at_center_[kHalfSpaces];     ///< at the block's center
    Fixed16 to_sub_[kHalfSpaces][3][2];  ///< from there to a sub-block's, by bits of its number
    Fixed16 at_[kHalfSpaces];            ///< at the sub-block's center
    Fixed16 sub_limit_[kHalfSpaces], quarter_limit_[kHalfSpaces][4];
};

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
