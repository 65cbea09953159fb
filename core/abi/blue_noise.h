// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a voxel lies in the masks of the ordered dither (runtime/dither/blue_noise.h). The templates
// serve generated code (U is a Halide Expr of type uint32) and plain C++ (U is uint32_t), as those
// of voxel_hash.h do, so both give the same bits.

#include <cstdint>

#include "abi/voxel_hash.h"

namespace openfab::abi {

/// Pixel x - kBlueNoiseRow y, modulo the number of pixels, is at (x, y). So squares of that many rows
/// tile the plane, each one pixel off its neighbours: a line of voxels goes on in the next line of
/// the mask instead of repeating its own, which averages the errors of long thin features.
constexpr uint32_t kBlueNoiseRow = 64;
constexpr uint32_t kBlueNoisePixels = kBlueNoiseRow * kBlueNoiseRow + 1;
/// The pixels that the mask moves by from one slice to the next: copies of a pixel in nearby slices
/// are far apart, 21 pixels for up to 5 slices, and a column of 64 voxels meets all parts of it.
constexpr uint32_t kBlueNoiseSliceStep = 1273;

/// The ranks of a pixel and of those that its place has in the next seven slices, in 1/65536.
using BlueNoiseMask = uint16_t[kBlueNoisePixels][8];

/// The direction that the border of a region faces at a voxel, by the number that OpenFL's
/// `BlueNoise` takes.
enum class BlueNoiseFace : uint32_t { kInside, kLowX, kHighX, kLowY, kHighY };

/// The shift and rotation of the mask of one face by a seed (fold_seed of voxel_hash.h). Indices of
/// voxels are taken modulo the number of pixels before.
template <typename U>
struct BlueNoiseShift {
    U pixel, turn;

    BlueNoiseShift(U seed, BlueNoiseFace face)
        : BlueNoiseShift(mix32(seed + U(static_cast<uint32_t>(face) * 0x9e3779b1u))) {}

    /// Returns a voxel's pixel in the mask inside a region.
    U inside(U x, U y, U z) const {
        return (upright(x, y) + U(kBlueNoiseSliceStep) * z) % U(kBlueNoisePixels);
    }
    /// Returns a voxel's pixel in the vertical mask of a side, `along` which y runs where the side
    /// faces x, x where it faces y.
    U upright(U along, U z) const {
        return (pixel + along + U(kBlueNoisePixels - kBlueNoiseRow) * z) % U(kBlueNoisePixels);
    }

  private:
    explicit BlueNoiseShift(U bits)
        : pixel((bits & U(0xffffu)) % U(kBlueNoisePixels)), turn(bits >> U(16u)) {}
};

/// The rotation of ranks from voxel to voxel, a 16th of the step between two ranks: it prints
/// fractions below one level of the mask. Ten times as much would make the ends of a short rod use
/// other pixels than its middle: 1 % in 8 x 8 x 64 voxels would err by 8 instead of 5 % (root mean
/// square). Indices are not taken modulo anything.
template <typename U>
U blue_noise_drift(U x, U y, U z) {
    return x + y + z;
}

/// Returns the threshold of a rank of the mask, turned and drifted: in [0, 65535), to be compared
/// with sums of 16-bit fractions as that of a hash is.
template <typename U>
U blue_noise_threshold(U rank) {
    return fraction_threshold(rank << U(16u));
}

}  // namespace openfab::abi
