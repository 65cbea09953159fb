// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The frame of a block in part space, and linear functions over it.

#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// A block of voxels in part space.
struct BlockFrame {
    float center[3];
    const float* step;  ///< along x, y, z, three values each
    const BlockShape* shape;
    /// Upper bound of the distance of every voxel to the surface, mm.
    float reach;
    /// Bound of the float error of positions and of everything computed from them, mm.
    float slack;
    /// Squared distances that differ by its square also differ in float, mm.
    float excess;
};

/// Makes the frame of a block. `reach2` is the squared reach; delta bounds the errors of squared
/// distances as in kernel_table.h, which are largest for large triangles.
inline BlockFrame make_block_frame(const KernelInput& in, const Vec3i& block, float reach2,
                                   float delta) {
    const float* f = in.frame;
    BlockFrame frame{};
    frame.step = f;
    frame.shape = in.shape;
    frame.reach = __builtin_sqrtf(reach2) * kSlack + delta;
    frame.slack = 3 * delta;
    frame.excess = __builtin_sqrtf(bound_slack(reach2, delta));
    for (int c = 0; c < 3; ++c) {
        double at = f[OPENFAB_FRAME_ORIGIN + c];
        for (int a = 0; a < 3; ++a)
            at += static_cast<double>(f[a * 3 + c]) * (block[a] + 4);
        frame.center[c] = static_cast<float>(at);
    }
    return frame;
}

/// For triangles with edges up to some length, (length + reach) kRounded is also an excess: all
/// that is computed of a feature starts from one of its corners, which is no farther from the voxel
/// than their sum. The square root of 2^-17: the roundings in two squared distances add up to at
/// most about 80 times 2^-24.
constexpr float kRounded = 0x1.7p-9f;

/// A linear function over the block.
template <typename V>
struct LinearForm {
    V center;  ///< value at the center
    V by[3];   ///< change per voxel along x, y, z
};

/// Returns how much it deviates at the outer voxel centers of a part from its value at the center.
template <typename V>
OPENFAB_INLINE V deviation(const LinearForm<V>& s, const float* half) {
    return (absolute(s.by[0]) * V(half[0]) + absolute(s.by[1]) * V(half[1])) +
           absolute(s.by[2]) * V(half[2]);
}

/// Computes the values at the centers of the parts of a box that is halved `bits` times, from the
/// value at[0] at its center.
template <int bits, typename V>
OPENFAB_INLINE void part_centers(const LinearForm<V>& s, const int32_t* axis, const float* half,
                                 V* at) {
    for (int k = 0; k < bits; ++k) {
        const V by = s.by[axis[k]] * V(half[k]);
        for (int i = 0; i < 1 << k; ++i) {
            at[i + (1 << k)] = at[i] + by;
            at[i] = at[i] - by;
        }
    }
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
