// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How bright a thick body looks.

namespace openfab::render {

/// Returns how bright a body without end behind a smooth surface looks, seen straight on in light that comes evenly
/// from all sides, of radiance 1. `albedo`: the share of scattering, which has no preferred direction, 0 to 1.
/// `refractive_index`: of the body, 1 to 3. Chandrasekhar, "Radiative Transfer" (1960), chapter 5: a half-space
/// reflects by products of his function H; what the surface sends back inwards is added until nothing comes out. Within
/// 0.001 of a Monte Carlo program.
double look_of_albedo(double albedo, double refractive_index);

/// Returns the albedo of the body that looks like that: 0 where the surface alone is brighter.
double albedo_of_look(double look, double refractive_index);

}  // namespace openfab::render
