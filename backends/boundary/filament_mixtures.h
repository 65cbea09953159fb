// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mixtures of filaments in quarters, which a slicer prints as layers of one and of the other: four layers of voxels hold
// each. A mixture has three filaments at most, the largest amounts.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "backends/boundary/mixture_colors.h"

namespace openfab::boundary {

/// Shares of filaments in quarters, three bits each from the lowest; 0 is none.
using Quarters = uint64_t;
constexpr uint32_t kQuartersOfAll = 4;

/// Rounds the amounts of the first materials to quarters by the largest remainder; of equal ones the first.
Quarters quarters_of(std::span<const float> amounts);
/// Returns how many quarters a filament has, from 0.
inline uint32_t share_of(Quarters mixture, size_t filament) {
    return static_cast<uint32_t>(mixture >> (3 * filament)) & 7;
}

/// The filaments of a printer and their mixtures, numbered from 1.
class FilamentMixtures {
  public:
    void begin(const std::vector<pipeline::SliceMaterial>& materials);
    /// Returns the number of a mixture, which is new or was there; 0 where none is left.
    uint8_t number(Quarters mixture);

    size_t filaments() const { return materials_.size(); }
    /// Returns the filaments and, behind them, their mixtures, with names and colours.
    std::vector<pipeline::SliceMaterial> all() const;
    /// Returns the mixtures as PrusaSlicer 2.9.6 reads them; empty where there are none.
    /// Source: PrusaSlicer 2.9.6, libslic3r/Feature/FullSpectrum.
    std::string json() const;

  private:
    std::vector<pipeline::SliceMaterial> materials_;
    std::vector<Quarters> mixtures_;
    std::map<Quarters, uint8_t> numbers_;
};

}  // namespace openfab::boundary
