// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an element is like that holds shares of several materials and of void.

#include <span>
#include <vector>

#include "mechanics/model/materials.h"

namespace openfab::mechanics {

struct ElementProperties {
    double lambda = 0, mu = 0;  ///< MPa
    double strength = 0;        ///< MPa; 0: not known of a material in it
    double density = 0;         ///< g/cm3
    double conductivity = 0;
};

class Mixture {
  public:
    Mixture(std::vector<Material> materials, const Properties& properties);

    /// `shares` of the materials; what is missing to 1 is void, which takes its share of everything:
    /// what a law says of the solid is multiplied by the solid share.
    ElementProperties of(std::span<const float> shares) const;
    /// Why the law cannot be used with these materials; empty where it can.
    std::string complaint() const;
    const std::vector<Material>& materials() const { return materials_; }

  private:
    double table_modulus(std::span<const double> shares) const;

    std::vector<Material> materials_;
    Law law_;
    const PropertyTable* table_;
    std::vector<int> column_;  ///< of a material in the table, -1: none
};

/// Hashin and Shtrikman's bounds of the bulk and shear modulus of isotropic mixtures.
struct HsBounds {
    double bulk_lower, bulk_upper, shear_lower, shear_upper;
};
HsBounds hs_bounds(std::span<const double> shares, std::span<const double> bulk,
                   std::span<const double> shear);

}  // namespace openfab::mechanics
