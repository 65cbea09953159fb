// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a stiffness tensor says in the words of engineers.

#include <array>
#include <optional>

#include "mechanics/cell/homogenise.h"

namespace openfab::mechanics {

/// The inverse; nothing where the cell has no stiffness in some direction.
std::optional<Stiffness> compliance_of(const Stiffness& stiffness);

struct Engineering {
    std::array<double, 3> young{};  ///< x, y, z
    std::array<double, 3> shear{};  ///< yz, xz, xy
    std::array<double, 3>
        poisson{};  ///< xy, yz, zx: of strain along the second under stress along the first
    double bulk_voigt = 0, bulk_reuss = 0, shear_voigt = 0, shear_reuss = 0;
    double young_least = 0, young_most = 0;
    std::array<double, 3> softest{}, stiffest{};  ///< directions
    double universal_anisotropy = 0;  ///< Ranganathan and Ostoja-Starzewski: 0 of the isotropic
    double zener = 0;                 ///< 2 C44 / (C11 - C12), means over axes: 1 of the isotropic
};

Engineering engineering_of(const Stiffness& stiffness, const Stiffness& compliance);

/// Young's modulus along a direction of length 1.
double young_along(const Stiffness& compliance, const std::array<double, 3>& n);

}  // namespace openfab::mechanics
