// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Composition and determinants of affine transforms, for the nested transforms of scene files.

#include "base/vec.h"

namespace openfab {

/// Returns the transform that applies b first, then a.
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

/// Returns the cofactor matrix, the transposed inverse times the determinant; transforms normals
/// up to their length.
inline Affine3d cofactors(const Affine3d& a) {
    const auto& m = a.m;
    Affine3d out;
    out.m = {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
             m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
             m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
    return out;
}

/// Returns the determinant; negative where the transform mirrors.
inline double determinant(const Affine3d& a) {
    const Affine3d c = cofactors(a);
    return a.m[0] * c.m[0] + a.m[1] * c.m[1] + a.m[2] * c.m[2];
}

}  // namespace openfab
