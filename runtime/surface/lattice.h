// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arithmetic of dicing: edge factors, the barycentric lattice, its tiles, and interpolation on it.
// These formulas decide bits, so each is defined only here.
//
//   corners   0 is lattice point (0, 0), 1 is (N, 0), 2 is (0, N)
//   points    (a, b) with a, b >= 0 and a + b <= N
//   sides     e runs from corner e to corner (e + 1) % 3; point l of it, counted from corner e:
//             side 0: (l, 0)    side 1: (N - l, l)    side 2: (0, N - l)
// The *lower* end of an edge is the one whose position comes first in (x, y, z) order; points on
// edges count from it.

#include <array>
#include <cmath>
#include <cstdint>

#include "base/vec.h"

namespace openfab::surface {

constexpr int32_t kTileEdges = 32;         ///< micro-edges along a patch's side
constexpr int32_t kMaxEdgeFactor = 65535;  ///< finer dicing of one base edge is refused
constexpr int32_t kFanTriangles = 2048;    ///< largest fan patch
constexpr int32_t kSeamQuads = 1024;       ///< largest strip patch

/// Compares positions in (x, y, z) order.
inline bool position_less(const Vec3d& a, const Vec3d& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z;
}

/// n(e) = max(1, ceil(|e| / s)); saturates at kMaxEdgeFactor + 1. Symmetric to the bit.
inline int32_t edge_factor(const Vec3d& a, const Vec3d& b, double micro_edge_mm) {
    const Vec3d d = position_less(a, b) ? b - a : a - b;
    const double n = std::ceil(std::sqrt((d.x * d.x + d.y * d.y) + d.z * d.z) / micro_edge_mm);
    if (!(n <= kMaxEdgeFactor)) return kMaxEdgeFactor + 1;
    return n < 1 ? 1 : static_cast<int32_t>(n);
}

/// Returns the edge point (of `factor`) to which lattice point l (of `n`) snaps, both counted from
/// the lower end: the nearest. With factor <= n the map is monotone and reaches every edge
/// point.
inline int32_t snap_to_edge(int32_t l, int32_t factor, int32_t n) {
    return static_cast<int32_t>((2 * static_cast<int64_t>(l) * factor + n) /
                                (2 * static_cast<int64_t>(n)));
}

/// A patch of the lattice: the cells [a0, a1) x [b0, b1) that lie in the triangle.
struct Tile {
    int32_t a0 = 0, b0 = 0, a1 = 0, b1 = 0;
};

/// Tiles are numbered row after row of b, a rising; row B has T - B tiles, T = ceil(N / 32).
inline int32_t tile_rows(int32_t n) {
    return (n + kTileEdges - 1) / kTileEdges;
}
inline int32_t tile_count(int32_t n) {
    const int32_t rows = tile_rows(n);
    return rows * (rows + 1) / 2;
}
inline int32_t tile_number(int32_t n, int32_t column, int32_t row) {
    return row * tile_rows(n) - row * (row - 1) / 2 + column;
}
inline Tile tile_at(int32_t n, int32_t column, int32_t row) {
    const int32_t a0 = column * kTileEdges, b0 = row * kTileEdges;
    return {a0, b0, std::min(a0 + kTileEdges, n - b0), std::min(b0 + kTileEdges, n - a0)};
}
/// Returns the number of a tile that has lattice point (a, b) among its vertices.
inline int32_t tile_of_point(int32_t n, int32_t a, int32_t b) {
    int32_t column = a / kTileEdges, row = b / kTileEdges;
    // On the far side a point may be the lowest corner of a tile without cells.
    if ((column + row) * kTileEdges >= n) {
        if (column > 0 && a % kTileEdges == 0) {
            --column;
        } else {
            --row;
        }
    }
    return tile_number(n, column, row);
}

/// Returns lattice point l of a side.
inline std::array<int32_t, 2> side_point(int32_t n, int32_t side, int32_t l) {
    if (side == 0) return {l, 0};
    if (side == 1) return {n - l, l};
    return {0, n - l};
}

/// Positions are rounded to float once. The sum turns -0 into 0, so that equal positions have equal
/// bits.
inline float round_position(double x) {
    return static_cast<float>(x) + 0.0f;
}
inline Vec3f round_position(const Vec3d& p) {
    return {round_position(p.x), round_position(p.y), round_position(p.z)};
}

/// Returns whether two corners of a triangle are equal: such a triangle is left out.
inline bool degenerate(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    return a == b || b == c || c == a;
}

inline double clamp_to(double x, double a, double b) {
    const double lo = a < b ? a : b, hi = a < b ? b : a;
    return x < lo ? lo : x > hi ? hi : x;
}

/// Returns point i of n on the edge from its lower end `lo` to `hi`; never outside their box.
inline Vec3d edge_position(const Vec3d& lo, const Vec3d& hi, int32_t i, int32_t n) {
    if (i == 0) return lo;
    if (i == n) return hi;
    const double t = static_cast<double>(i) / n;
    return {clamp_to(t * (hi.x - lo.x) + lo.x, lo.x, hi.x),
            clamp_to(t * (hi.y - lo.y) + lo.y, lo.y, hi.y),
            clamp_to(t * (hi.z - lo.z) + lo.z, lo.z, hi.z)};
}
inline float edge_value(float lo, float hi, int32_t i, int32_t n) {
    if (i == 0) return lo;
    if (i == n) return hi;
    const float t = static_cast<float>(i) / static_cast<float>(n);
    return t * (hi - lo) + lo;
}

/// Interpolates inside the lattice. Weights are a / N and b / N; the caller clamps positions to the
/// triangle's box.
inline double lattice_coordinate(double v0, double v1, double v2, double wa, double wb) {
    return (wa * (v1 - v0) + wb * (v2 - v0)) + v0;
}
inline float lattice_value(float v0, float v1, float v2, float wa, float wb) {
    return (wa * (v1 - v0) + wb * (v2 - v0)) + v0;
}

/// Returns the change of a linear interpolant per lattice step.
inline float lattice_gradient(float from, float to, int32_t n) {
    return (to - from) / static_cast<float>(n);
}

/// Normalises an interpolated normal; returns the geometric normal if it cancels out.
inline Vec3f unit_normal(const Vec3f& n, const Vec3f& ng) {
    const float length2 = (n.x * n.x + n.y * n.y) + n.z * n.z;
    if (!(length2 > 0) || !(length2 <= std::numeric_limits<float>::max())) return ng;
    const float length = std::sqrt(length2);
    return {n.x / length, n.y / length, n.z / length};
}

}  // namespace openfab::surface
