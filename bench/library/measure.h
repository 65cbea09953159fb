// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What one function of the standard library costs a voxel, and how tight its interval form is.

#include <optional>

#include "tests/support/library_call.h"

namespace openfab::bench {

/// Blocks of 8 voxels of 0.05 mm a side are scattered over a cube of this edge.
constexpr float kRegionMm = 32;
constexpr float kVoxelMm = 0.05F;
constexpr int kRounds = 25;

struct Cost {
    double ns = 0;      ///< a voxel, beyond the copy of a position
    double spread = 0;  ///< of that, half the distance between quartiles
    double copies = 0;  ///< the kernel's time over that of the copy
};

/// Medians over all blocks. Empty where there is nothing to compare.
struct Bounds {
    bool known = false;           ///< some block has an interval
    std::optional<double> width;  ///< of the interval over that of the values; none: mostly unknown
    /// Shares of the blocks: those of which all values lie on one side of the level at which a
    /// fablet would change its material (or in which no amount changes), and those of which the
    /// interval tells so.
    std::optional<double> one_sided, decided;
};

struct Figures {
    Cost cost;
    Bounds bounds;
};

/// Compiles the call for AVX2 and measures it. A call that does not compile ends the program.
Figures measure(const testing::LibraryCall& sample);

}  // namespace openfab::bench
