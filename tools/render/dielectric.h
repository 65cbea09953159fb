// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surface between resin and air: Fresnel's equations, smooth or with microfacets (Walter et al.
// 2007, "Microfacet models for refraction through rough surfaces"; GGX, facets that are visible from
// the ray drawn as by Heitz 2018, "Sampling the GGX distribution of visible normals").
//
// What one facet hides of the light that another sends is lost in that model: on a white part with
// all its inner reflections, a quarter at a roughness of 0.3. Here such light draws another facet, so that
// none is lost; it is on the bright side of reciprocity by as much as it would be lost else.
//
// Paths begin and end in air, so that the factor of radiance by the squares of the indices cancels;
// it is left out.

#include "base/vec.h"
#include "tools/render/optics.h"
#include "tools/render/random.h"

namespace openfab::render {

/// The share of light that is reflected, unpolarised. `cosine` > 0: of the angle at which it comes;
/// `eta`: index where it comes from over that beyond. `cosine_beyond` is that of the refracted ray; 0
/// where all is reflected.
double fresnel(double cosine, double eta, double* cosine_beyond);

struct Bounce {
    Vec3d direction;
    bool crosses = false;
};

/// Draws how a ray goes on. `normal` points to the side where it comes from: dot(direction, normal) <
/// 0. `inside`: that side is resin.
Bounce bounce_at(const SurfaceOptics& surface, const Vec3d& direction, const Vec3d& normal,
                 bool inside, Random* random);

/// Draws a facet's normal that is visible from `to_viewer`, in the frame whose third axis is the
/// surface's normal, of GGX's distribution of width `alpha`.
Vec3d visible_facet(const Vec3d& to_viewer, double alpha, Random* random);

}  // namespace openfab::render
