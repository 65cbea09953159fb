// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ways in which a mixture becomes one material a voxel. In all of them only materials that are
// present in a voxel are chosen there, slices are independent, and the choice is a function of the
// fractions, the place in the grid and the seed.

#include <optional>
#include <string>
#include <string_view>

namespace openfab::slab {

enum class DitherRule {
    kFloydSteinberg,  ///< error diffusion as in the paper, with the zero rule
    kDecorrelated,    ///< error diffusion with a random threshold: no worms, no columns; like the
                      ///< first, it leaves little on the sides that it comes in by
    kBlueNoise,  ///< an ordered dither by a void-and-cluster mask, which lies in the plane of sides
    kMajority,   ///< the largest fraction, the lowest code of equals: no mixture is kept
};

/// Where nothing is asked for.
constexpr DitherRule kDefaultDither = DitherRule::kBlueNoise;
constexpr const char* kDefaultDitherName = "blue_noise";

/// By the name that `--dither` takes.
std::optional<DitherRule> find_dither(std::string_view name);

/// "floyd_steinberg, decorrelated, …", for messages.
std::string dither_names();

}  // namespace openfab::slab
