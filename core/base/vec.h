// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small fixed vectors, boxes and the affine transforms of parts. Plain arithmetic, no contraction
// (the build sets -ffp-contract=off), so results are the same on every machine.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace openfab {

template <typename T>
struct Vec2 {
    T x{}, y{};
    bool operator==(const Vec2&) const = default;
};

template <typename T>
struct Vec3 {
    T x{}, y{}, z{};
    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    bool operator==(const Vec3&) const = default;
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
using Vec3i = Vec3<int32_t>;

template <typename T>
constexpr Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename T>
constexpr Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename T>
constexpr Vec3<T> operator*(const Vec3<T>& a, T s) {
    return {a.x * s, a.y * s, a.z * s};
}
template <typename T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <typename T>
T length(const Vec3<T>& a) {
    return std::sqrt(dot(a, a));
}
template <typename To, typename From>
constexpr Vec3<To> vec_cast(const Vec3<From>& a) {
    return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

/// Axis-aligned box; empty (lo > hi) by default.
template <typename T>
struct Box3 {
    Vec3<T> lo{std::numeric_limits<T>::max(), std::numeric_limits<T>::max(),
               std::numeric_limits<T>::max()};
    Vec3<T> hi{std::numeric_limits<T>::lowest(), std::numeric_limits<T>::lowest(),
               std::numeric_limits<T>::lowest()};

    bool empty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
    void add(const Vec3<T>& p) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], p[a]);
            hi[a] = std::max(hi[a], p[a]);
        }
    }
    void add(const Box3& b) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], b.lo[a]);
            hi[a] = std::max(hi[a], b.hi[a]);
        }
    }
    Vec3<T> center() const { return (lo + hi) * T(0.5); }
    Vec3<T> size() const { return hi - lo; }
    T longest_side() const { return std::max({size().x, size().y, size().z}); }
    bool overlaps(const Box3& b) const {
        for (int a = 0; a < 3; ++a) {
            if (lo[a] > b.hi[a] || hi[a] < b.lo[a]) return false;
        }
        return true;
    }
    bool operator==(const Box3&) const = default;
};

using Box3f = Box3<float>;
using Box3d = Box3<double>;
using Box3i = Box3<int32_t>;

/// The map p -> m p + t, with m row-major.
struct Affine3d {
    std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};
    Vec3d t;

    Vec3d apply(const Vec3d& p) const { return apply_vector(p) + t; }
    Vec3d apply_vector(const Vec3d& p) const {
        return {m[0] * p.x + m[1] * p.y + m[2] * p.z, m[3] * p.x + m[4] * p.y + m[5] * p.z,
                m[6] * p.x + m[7] * p.y + m[8] * p.z};
    }
    bool operator==(const Affine3d&) const = default;
};

}  // namespace openfab
