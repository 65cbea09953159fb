// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by lookups in pictures and in volumes: see sample.h.

#include <cmath>
#include <cstdint>

namespace openfab::interp {

// The values of world::Wrap and world::Filter; the interpreter includes no runtime code.
constexpr int32_t kWrapRepeat = 1;
constexpr int32_t kWrapMirror = 2;
constexpr int32_t kWrapBlack = 3;
constexpr int32_t kFilterTrilinear = 0;
constexpr int32_t kFilterNearest = 2;

constexpr float kMaxWidth = 1073741824.0f;  // 2^30

inline float bound(float x, float lo, float hi) {
    return x > lo ? (x < hi ? x : hi) : lo;
}

inline float wrap_coordinate(int32_t wrap, float u) {
    float p = u;
    if (wrap == kWrapRepeat) p = u - std::floor(u);
    if (wrap == kWrapMirror) {
        const float h = u * 0.5f;
        p = (h - std::floor(h)) * 2.0f;
    }
    return bound(p, -2.0f, 3.0f);
}

inline int32_t wrap_texel(int32_t wrap, int32_t x, int32_t n) {
    if (wrap == kWrapRepeat) x = x < 0 ? x + n : (x >= n ? x - n : x);
    if (wrap == kWrapMirror) x = x < 0 ? -1 - x : (x >= n ? 2 * n - 1 - x : x);
    return x < 0 ? 0 : (x >= n ? n - 1 : x);
}

}  // namespace openfab::interp
