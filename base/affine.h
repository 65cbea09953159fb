// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the nested transforms of scene files need besides Affine3d itself.

#include "base/vec.h"

namespace openfab::scene {

/// b first, then a.
inline Affine3d product(const Affine3d& a, const Affine3d& b) {
    Affine3d out;
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            out.m[i * 3 + j] =
                a.m[i * 3] * b.m[j] + a.m[i * 3 + 1] * b.m[3 + j] + a.m[i * 3 + 2] * b.m[6 + j];
        }
    }
    out.t = a.apply(b.t);
    return out;
}

/// Cofactors: the transposed inverse times the determinant; turns normals, but for their length.
inline Affine3d cofactors(const Affine3d& a) {
    const auto& m = a.m;
    Affine3d out;
    out.m = {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
             m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
             m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
    return out;
}

/// Negative where the transform mirrors.
inline double determinant(const Affine3d& a) {
    const Affine3d c = cofactors(a);
    return a.m[0] * c.m[0] + a.m[1] * c.m[1] + a.m[2] * c.m[2];
}

}  // namespace openfab::scene
