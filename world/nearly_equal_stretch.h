// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "world/world.h"

namespace openfab::world {

/// The stretches S of matrices M = R S (base/polar.h) so far, by their first entry.
class Stretches {
  public:
    /// Returns the one that stands for `s`: the identity, if no entry differs from it by more than
    /// `slack`, or an earlier one from which none differs by more than `apart`; else `s`.
    std::array<double, 9> representative(const std::array<double, 9>& s, double slack,
                                         double apart);

  private:
    std::map<double, std::vector<std::array<double, 9>>> known_;
};

/// Matrices as a file writes them. With four or five decimals a rotation is none exactly.
class WrittenMatrices {
  public:
    /// Returns a rotation, or a matrix with the stretch of an earlier one, where that is what
    /// `written` may be with four or five decimals; else `written`.
    std::array<double, 9> exact(const std::array<double, 9>& written);
    /// Returns how many were changed.
    size_t changed() const { return changed_; }

  private:
    Stretches stretches_;
    size_t changed_ = 0;
};

/// Transforms that other programs write have six decimals, mostly, so a rotation is none exactly, and
/// each placement would be a shape of its own. The stretch S of M = R S (base/polar.h) becomes the
/// identity where no entry differs from it by more than 1e-6; else that of an earlier placement of the
/// mesh, where none differs from that by more than 1e-6 of the largest. Returns the number of placements
/// that were changed.
size_t equalise_stretches(World* world);

}  // namespace openfab::world
