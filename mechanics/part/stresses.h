// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stresses of a solved part, up to its surface.
//
// Strains are best in the middles of elements, but bending is greatest at the surface, half an element or more
// away. There the strain of an element is that of its middle and how it changes from element to element within
// the material; across a wall of a single element, how it changes within it. What elements of one material say of
// a node that they share is averaged, never across materials. Deep inside a material the middle stands for all.

#include "mechanics/part/part_problem.h"

namespace openfab::mechanics {

/// Of the solid elements, [z][y][x]; 0 of others. Stresses are those of the solid in an element, at the worst
/// of its corners.
struct PartFields {
    std::vector<float> von_mises_MPa;
    std::vector<float> tension_MPa, compression_MPa;  ///< largest and least principal stress
    std::vector<float> safety;  ///< strength over von Mises stress; 0: not known
};
PartFields fields_of(const PartProblem& problem, Field<double, kElastic>* moved_mm);

double von_mises_of(const std::array<double, 6>& stress);

}  // namespace openfab::mechanics
