// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Textbook twins of the fixed-function stages normalise and dither: one voxel at a time, in the
// plainest form. The generated kernels give the same bits.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "runtime/dither/dither_rule.h"

namespace openfab::reference {

/// Fractions of one voxel, void first; their sum is 65535. Negative and NaN amounts count as 0 and
/// are counted in `unusable` (may be null). Slots of one material are added in slot order.
std::vector<uint16_t> normalise(std::span<const float> weights,
                                std::span<const int32_t> slot_material, int32_t materials,
                                int64_t* unusable);

/// 16-bit fractions of a box of voxels: fractions[((z * size.y + y) * size.x + x) * channels + m],
/// m = 0 is void. A voxel with all fractions 0 is outside: void and pure.
struct FractionField {
    Vec3i size;
    int32_t channels = 0;
    Vec3i origin;  ///< index in the grid of the box's lowest voxel, which the hash sees
    std::vector<uint16_t> fractions;

    uint16_t* at(int32_t x, int32_t y, int32_t z) {
        return &fractions[((static_cast<size_t>(z) * size.y + y) * size.x + x) * channels];
    }
    const uint16_t* at(int32_t x, int32_t y, int32_t z) const {
        return const_cast<FractionField*>(this)->at(x, y, z);
    }
};

FractionField make_field(const Vec3i& size, int32_t materials);

/// Two or more fractions above 0.
bool is_mixed(const uint16_t* fractions, int32_t channels);

/// Error diffusion scatters errors forward, as in Floyd and Steinberg 1976, with the zero rule.
/// Returns a material code for each voxel, x fastest, then y, then z.
std::vector<uint8_t> dither(const FractionField& field, uint64_t seed,
                            dither::DitherRule rule = dither::kDefaultDither);

}  // namespace openfab::reference
