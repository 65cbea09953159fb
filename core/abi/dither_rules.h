// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Constants of the decorrelated dither, for the generated code, the plain code for prints of many
// materials and the twin of the tests. Amounts are in 1/65535, as fractions are.
//
// The rule is Floyd-Steinberg's with a random threshold. Each material's value (its fraction and
// the errors received), less a floor, is a weight, and the hash of the voxel picks one of the
// materials in proportion. Without a floor a material would be picked with a probability of its
// value, or 0 if that is negative: too often on average, so that the error grows and is lost at
// the border. With a floor of one half the largest value would always win, as in 1976: worms, and
// nothing at all in the first rows at small fractions.

#include <cstdint>

namespace openfab::abi {

/// The floor where all four previous neighbours are mixed. Measured at fractions of 0.5 to 2 % in a
/// square of 64 voxels: the errors at the border then add up to about nothing (a surplus of 3 % of
/// the fraction; 18 % without a floor), and dots have no direction.
constexpr float kDecorrelatedInteriorFloor = 6553.5f;

/// The floor where some are not: lines one voxel wide and the borders of regions. A chain of voxels
/// with one neighbour each keeps its mean best if its first error is random, not the threshold.
constexpr float kDecorrelatedBorderFloor = 32767.5f;

/// The least weight of a present material, relative to its fraction: decides where all values are
/// below the floor, and has no effect elsewhere.
constexpr float kDecorrelatedLeast = 0x1p-12f;

/// Returns the first error of material `channel` at a voxel that received none, which begins a
/// chain of errors: its upper 16 bits, less 32768, are added to the error that is passed on. `hash`
/// is that of the voxel.
template <typename U>
U first_error_hash(U hash, uint64_t channel) {
    return hash * U(static_cast<uint32_t>(2 * channel + 3) * 0x9e3779b1u);
}

}  // namespace openfab::abi
