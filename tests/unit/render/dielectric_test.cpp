// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Fresnel's formulas and the facets of rough surfaces, against closed forms and quadrature.

#include "tools/render/dielectric.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace openfab::render {
namespace {

TEST(Dielectric, ReflectsByFresnel) {
    double beyond = 0;
    // Straight on.
    EXPECT_NEAR(fresnel(1, 1 / 1.5, &beyond), 0.04, 1e-12);
    EXPECT_NEAR(beyond, 1, 1e-12);
    EXPECT_NEAR(fresnel(1, 1.5, &beyond), 0.04, 1e-12);
    // At Brewster's angle half of the light is polarised such that none is reflected, and the
    // directions of the others are at right angles.
    const double n = 1.5, cosine = 1 / std::sqrt(1 + n * n);
    const double across = (n * n - 1) / (n * n + 1);
    EXPECT_NEAR(fresnel(cosine, 1 / n, &beyond), across * across / 2, 1e-12);
    EXPECT_NEAR(beyond * beyond + cosine * cosine, 1, 1e-12);
    // All of it beyond the critical angle and along the surface.
    EXPECT_EQ(fresnel(0.7, n, &beyond), 1);
    EXPECT_EQ(beyond, 0);
    EXPECT_NEAR(fresnel(0, 1 / n, &beyond), 1, 1e-12);
}

/// The mean of visible normals of Heitz, "Sampling the GGX distribution of visible normals", Journal of
/// Computer Graphics Techniques 7(4), 2018: in proportion to GGX's density and the cosine to the viewer.
TEST(Dielectric, FacetsAreThoseThatTheViewerSees) {
    for (const double alpha : {0.1, 0.4, 0.8}) {
        for (const double slant : {0.0, 0.7, 1.3}) {
            const Vec3d viewer{std::sin(slant), 0, std::cos(slant)};
            Vec3d expected;
            double whole = 0;
            constexpr int kSteps = 600;
            for (int i = 0; i < kSteps; ++i) {
                // The share of facets that are steeper is w * w.
                const double w = (i + 0.5) / kSteps;
                const double tangent = alpha * std::sqrt(1 - w * w) / w;
                const double c = 1 / std::sqrt(1 + tangent * tangent), s = tangent * c;
                for (int j = 0; j < kSteps; ++j) {
                    const double turn = 2 * std::numbers::pi * (j + 0.5) / kSteps;
                    const Vec3d m{s * std::cos(turn), s * std::sin(turn), c};
                    const double weight = w * std::max(0.0, dot(m, viewer)) / c;
                    expected = expected + m * weight;
                    whole += weight;
                }
            }
            expected = expected * (1 / whole);
            Random random(1, 2, 3);
            Vec3d sum;
            constexpr int kSamples = 200'000;
            for (int i = 0; i < kSamples; ++i)
                sum = sum + visible_facet(viewer, alpha, &random);
            const Vec3d mean = sum * (1.0 / kSamples);
            for (int a = 0; a < 3; ++a)
                EXPECT_NEAR(mean[a], expected[a], 0.003) << alpha << ' ' << slant << ' ' << a;
        }
    }
}

}  // namespace
}  // namespace openfab::render
