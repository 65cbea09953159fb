// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rules by which a mixture becomes one material per voxel. All of them choose only materials
// that are present in the voxel, treat slices independently, and depend on nothing but the
// fractions, the voxel's index in the grid and the seed. A fablet may bring a rule of its own, which its
// slab kernel applies (compiler/OPENFL.md, section 2).

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

/// Stands for each fablet's own `@Dither`, and for the default rule where it has none.
constexpr const char* kOwnDitherName = "own";

/// Finds a rule by the name that `--dither` takes; that of kOwnDitherName is the default rule.
std::optional<DitherRule> find_dither(std::string_view name);

/// Returns "floyd_steinberg, decorrelated, …", for messages.
std::string dither_names();

}  // namespace openfab::dither
