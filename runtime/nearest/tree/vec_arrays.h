// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Points as the records of trees keep them: three floats.

#include "base/vec.h"

namespace openfab::nearest {

inline Vec3f to_vec(const float* v) {
    return {v[0], v[1], v[2]};
}

inline void store(const Vec3f& v, float* out) {
    for (int a = 0; a < 3; ++a)
        out[a] = v[a];
}

inline void store(const Vec3d& v, float* out) {
    for (int a = 0; a < 3; ++a)
        out[a] = static_cast<float>(v[a]);
}

}  // namespace openfab::nearest
