// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/dielectric.h"

#include <algorithm>
#include <cmath>

namespace openfab::render {

namespace {

/// Smith's masking of a direction at `cosine` to the normal.
double masking(double cosine, double alpha) {
    const double c2 = cosine * cosine;
    if (c2 >= 1) return 1;
    const double tangent2 = (1 - c2) / c2;
    return 2 / (1 + std::sqrt(1 + alpha * alpha * tangent2));
}

}  // namespace

Vec3d visible_facet(const Vec3d& to_viewer, double alpha, Random* random) {
    const Vec3d v = normalized(Vec3d{alpha * to_viewer.x, alpha * to_viewer.y, to_viewer.z});
    const double across = v.x * v.x + v.y * v.y;
    const Vec3d t1 = across > 0 ? Vec3d{-v.y, v.x, 0} * (1 / std::sqrt(across)) : Vec3d{1, 0, 0};
    const Vec3d t2 = cross(v, t1);
    const double r = std::sqrt(random->uniform());
    double c = 0, s = 0;
    random->azimuth(&c, &s);
    const double p1 = r * c;
    const double blend = 0.5 * (1 + v.z);
    const double p2 = (1 - blend) * std::sqrt(std::max(0.0, 1 - p1 * p1)) + blend * r * s;
    const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
    const Vec3d n = t1 * p1 + t2 * p2 + v * p3;
    return normalized(Vec3d{alpha * n.x, alpha * n.y, std::max(1e-9, n.z)});
}

double fresnel(double cosine, double eta, double* cosine_beyond) {
    const double sine2 = eta * eta * std::max(0.0, 1 - cosine * cosine);
    if (sine2 >= 1) {
        *cosine_beyond = 0;
        return 1;
    }
    const double beyond = std::sqrt(1 - sine2);
    *cosine_beyond = beyond;
    const double s = (eta * cosine - beyond) / (eta * cosine + beyond);
    const double p = (cosine - eta * beyond) / (cosine + eta * beyond);
    return 0.5 * (s * s + p * p);
}

Bounce bounce_at(const SurfaceOptics& surface, const Vec3d& direction, const Vec3d& normal,
                 bool inside, Random* random) {
    if (surface.refractive_index == 1) return {direction, true};
    const double eta = inside ? surface.refractive_index : 1 / surface.refractive_index;
    const auto off = [&](const Vec3d& facet) {
        const double cosine = std::clamp(-dot(direction, facet), 0.0, 1.0);
        double beyond = 0;
        const double reflected = fresnel(cosine, eta, &beyond);
        Bounce bounce;
        bounce.crosses = random->uniform() >= reflected;
        bounce.direction =
            normalized(bounce.crosses ? direction * eta + facet * (eta * cosine - beyond)
                                      : direction + facet * (2 * cosine));
        return bounce;
    };
    constexpr int kTries = 16;
    for (int i = 0; i < kTries && surface.roughness > 0; ++i) {
        Vec3d a, b;
        make_frame(normal, &a, &b);
        const Vec3d back = direction * -1.0;
        const Vec3d m = visible_facet({dot(back, a), dot(back, b), dot(back, normal)},
                                      surface.roughness, random);
        const Bounce bounce = off(a * m.x + b * m.y + normal * m.z);
        const double out = dot(bounce.direction, normal) * (bounce.crosses ? -1 : 1);
        if (out > 0 && random->uniform() < masking(out, surface.roughness)) return bounce;
    }
    return off(normal);
}

}  // namespace openfab::render
