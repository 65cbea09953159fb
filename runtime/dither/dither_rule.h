// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rules by which a mixture becomes one material per voxel. All of them choose only materials
// that are present in the voxel, treat slices independently, and depend on nothing but the
// fractions, the voxel's index in the grid and the seed.

#include <optional>
#include <string>
#include <string_view>

namespace openfab::dither {

enum class DitherRule {
    kFloydSteinberg,  ///< error diffusion as in the paper, with the zero rule
    kDecorrelated,    ///< error diffusion with a random threshold: no worms, no columns; like the
                      ///< first, it prints too little on the sides where it starts
    kBlueNoise,  ///< an ordered dither by a void-and-cluster mask, which lies in the plane of sides
    kMajority,   ///< the largest fraction, ties go to the lowest code: no mixture is kept
};

/// The default rule.
constexpr DitherRule kDefaultDither = DitherRule::kBlueNoise;
constexpr const char* kDefaultDitherName = "blue_noise";

/// Finds a rule by the name that `--dither` takes.
std::optional<DitherRule> find_dither(std::string_view name);

/// Returns "floyd_steinberg, decorrelated, …", for messages.
std::string dither_names();

}  // namespace openfab::dither
