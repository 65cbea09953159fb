// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inverses of affine transforms, and whether they keep shapes.

#include <cmath>

#include "base/affine.h"
#include "base/vec.h"

namespace openfab {

/// Returns how much larger a map makes lengths if it does so alike in all directions, else 0.
inline double even_scale(const Affine3d& map) {
    const double s = std::cbrt(std::fabs(determinant(map)));
    for (size_t i = 0; i < 3; ++i) {
        for (size_t k = 0; k < 3; ++k) {
            double sum = 0;
            for (size_t r = 0; r < 3; ++r)
                sum += map.m[3 * r + i] * map.m[3 * r + k];
            if (!(std::fabs(sum - (i == k ? s * s : 0)) <= 1e-5 * s * s)) return 0;
        }
    }
    return s;
}

/// Returns the inverse; one that is not finite where there is none.
inline Affine3d inverse(const Affine3d& a) {
    const Affine3d c = cofactors(a);
    const double d = determinant(a);
    Affine3d out;
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j)
            out.m[3 * i + j] = c.m[3 * j + i] / d;
    }
    out.t = out.apply_vector(a.t) * -1.0;
    return out;
}

}  // namespace openfab
