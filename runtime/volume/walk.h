// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random walks from ball to empty ball that end on a surface (rule 24): where they end, a function has the mean that the
// harmonic function with these values on the surface has where they begin. Here is the lattice that they read; it is kept
// by walk_lattice.h, and computed anew by the twin of tests. How they go is in walk_lanes.inl.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "abi/voxel_hash.h"
#include "base/infinity.h"
#include "base/vec.h"

namespace openfab::volume {

/// What is known at a point: how far the surfaces are, mm, the part's own positive inside, the object's negative inside,
/// and how that changes.
struct WalkField {
    float own = 0, object = 0;
    Vec3f own_slope, object_slope;
    float over = 0;  ///< by how much the distances may be too large
};

/// A point, or a cell's lowest corner, in units of a cell of level 0 divided by 2^20, from the lowest of these cells.
using WalkPlace = std::array<uint32_t, 3>;
constexpr uint32_t kWalkUnitBits = 20;

/// A cell of the lattice, with 3 x 3 x 3 nodes. Cells of level 0 have a side of a power of two millimetres, and corners at
/// its multiples; a cell of the next level is an eighth.
struct WalkCell {
    WalkPlace lowest{};
    uint32_t bits = kWalkUnitBits;  ///< its side is 2^bits units
};

/// The nodes of a cell: number (z * 3 + y) * 3 + x.
constexpr size_t kWalkNodes = 27;
using WalkNodes = std::array<float, kWalkNodes>;

/// The cells of level 0 of a solid whose geometry is in a box: 5 to 8 along its longest side, and one more.
class WalkGrid {
  public:
    explicit WalkGrid(const Box3f& box) {
        if (box.empty()) return;
        int exponent = 0;
        std::frexp(std::max(box.longest_side(), 1e-6f) * 0.125f, &exponent);
        side_ = std::ldexp(1.0f, exponent);
        unit_ = std::ldexp(1.0f, exponent - int{kWalkUnitBits});
        per_unit_ = std::ldexp(1.0f, int{kWalkUnitBits} - exponent);
        for (int a = 0; a < 3; ++a) {
            const float first = std::floor(box.lo[a] / side_);
            origin_[a] = first * side_;
            count_.at(static_cast<size_t>(a)) =
                static_cast<uint32_t>(std::floor(box.hi[a] / side_) - first) + 1;
        }
    }

    const std::array<uint32_t, 3>& count() const { return count_; }
    std::array<float, 3> origin() const { return {origin_.x, origin_.y, origin_.z}; }
    float per_unit() const { return per_unit_; }
    /// False of a point beyond the cells, or a NaN.
    bool find(const Vec3f& p, WalkPlace* out) const {
        bool inside = true;
        for (size_t a = 0; a < 3; ++a) {
            const float at = (p[static_cast<int>(a)] - origin_[static_cast<int>(a)]) * per_unit_;
            const auto most = static_cast<float>(count_[a] << kWalkUnitBits);
            inside = inside && at >= 0 && at < most;
            (*out)[a] = static_cast<uint32_t>(static_cast<int32_t>(inside ? at : 0.0f));
        }
        return inside;
    }
    /// Returns the place of a node, part-local mm.
    Vec3f node(const WalkCell& cell, size_t number) const {
        const std::array<size_t, 3> step = {number % 3, number / 3 % 3, number / 9};
        Vec3f p;
        for (size_t a = 0; a < 3; ++a) {
            const uint32_t units =
                cell.lowest[a] + (static_cast<uint32_t>(step[a]) << (cell.bits - 1));
            p[static_cast<int>(a)] =
                origin_[static_cast<int>(a)] + static_cast<float>(units) * unit_;
        }
        return p;
    }
    float side(const WalkCell& cell) const { return unit_ * static_cast<float>(1u << cell.bits); }

  private:
    Vec3f origin_;
    float side_ = 1, unit_ = 1, per_unit_ = 1;
    std::array<uint32_t, 3> count_{};
};

/// Returns which eighth of a cell has a point, bit a for axis a.
inline size_t walk_octant(const WalkCell& cell, const WalkPlace& at) {
    const uint32_t bit = cell.bits - 1;
    return (at[0] >> bit & 1) | (at[1] >> bit & 1) << 1 | (at[2] >> bit & 1) << 2;
}

inline WalkCell walk_root(const WalkPlace& at) {
    WalkCell cell;
    for (size_t a = 0; a < 3; ++a)
        cell.lowest[a] = at[a] >> kWalkUnitBits << kWalkUnitBits;
    return cell;
}

inline WalkCell walk_child(const WalkCell& cell, size_t octant) {
    const uint32_t bits = cell.bits - 1;
    WalkCell child{cell.lowest, bits};
    for (size_t a = 0; a < 3; ++a)
        child.lowest[a] += static_cast<uint32_t>(octant >> a & 1) << bits;
    return child;
}

/// Makes a cell's distances unsigned if their sign changes between neighbours though the surface is farther than both: a
/// shape's sign is that of its value, and what is thinner than a voxel has no surface. Returns whether it did.
inline bool walk_settle(WalkNodes* at, float side) {
    const float far = 0.51f * side;
    constexpr std::array<size_t, 3> kApart = {1, 3, 9};
    bool wrong = false;
    for (size_t node = 0; node < kWalkNodes; ++node) {
        const std::array<size_t, 3> place = {node % 3, node / 3 % 3, node / 9};
        for (size_t a = 0; a < 3; ++a) {
            if (place[a] == 2) continue;
            const float one = (*at)[node], other = (*at)[node + kApart[a]];
            wrong = wrong || ((one < 0) != (other < 0) && std::fabs(one) + std::fabs(other) > far);
        }
    }
    if (!wrong) return false;
    for (float& distance : *at)
        distance = std::fabs(distance);
    return true;
}

/// Returns by how much the mean of the corners around a node is more than its distance.
inline float walk_excess(const WalkNodes& at, size_t node) {
    const std::array<size_t, 3> place = {node % 3, node / 3 % 3, node / 9};
    constexpr std::array<size_t, 3> kApart = {1, 3, 9};
    float sum = 0, count = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t other = 0;
        bool between = true;
        for (size_t a = 0; a < 3; ++a) {
            const size_t end = (corner >> a & 1) * 2;
            between = between && (place[a] == 1 || place[a] == end);
            other += end * kApart[a];
        }
        if (!between) continue;
        sum += at[other];
        count += 1;
    }
    return sum / count - at[node];
}

/// How well means of corners meet a cell's other nodes.
struct WalkErrors {
    float miss = 0;  ///< the worst, beyond a tenth of the distance
    float over = 0;  ///< the most by which a mean is farther from the surface than the node
};

/// Of the surfaces that may be the nearer one somewhere in the cell. `object` is infinite without one.
inline WalkErrors walk_errors(const WalkNodes& own, const WalkNodes& object, float side) {
    // Twice a cell's diagonal.
    const float apart = 3.5f * side;
    WalkErrors out;
    const auto add = [&](float excess, float distance) {
        out.miss = std::max(out.miss, std::fabs(excess) - 0.1f * std::fabs(distance));
        out.over = std::max(out.over, distance < 0 ? -excess : excess);
    };
    for (size_t node = 0; node < kWalkNodes; ++node) {
        const float a = std::fabs(own[node]), b = std::fabs(object[node]);
        if (a <= b + apart) add(walk_excess(own, node), own[node]);
        if (b <= a + apart) add(walk_excess(object, node), object[node]);
    }
    return out;
}

/// Returns the least `stop` with which a cell is read, not one of its eighths: linear between its nodes it is right to an
/// eighth of `stop` and a fortieth of the distance where the surface is smooth, or it is as small as `stop`. Cells of four
/// units are always read.
inline float walk_reads_from(float side, float miss) {
    return std::min(2 * miss, side);
}

/// Reads a field between nodes: its value and its slope, in units of a cell's half. `v` is the lowest of eight nodes.
inline float walk_between(const float* v, const Vec3f& u, Vec3f* slope) {
    const float dx00 = v[1] - v[0], dx10 = v[4] - v[3], dx01 = v[10] - v[9], dx11 = v[13] - v[12];
    const float v00 = v[0] + u.x * dx00, v10 = v[3] + u.x * dx10, v01 = v[9] + u.x * dx01,
                v11 = v[12] + u.x * dx11;
    const float dy0 = v10 - v00, dy1 = v11 - v01;
    const float v0 = v00 + u.y * dy0, v1 = v01 + u.y * dy1;
    const float dx0 = dx00 + u.y * (dx10 - dx00), dx1 = dx01 + u.y * (dx11 - dx01);
    *slope = {dx0 + u.z * (dx1 - dx0), dy0 + u.z * (dy1 - dy0), v1 - v0};
    return v0 + u.z * (v1 - v0);
}

inline void walk_read(const WalkNodes& own, const WalkNodes& object, const WalkCell& cell,
                      float side, const WalkPlace& p, bool with_object, WalkField* out) {
    const uint32_t bits = cell.bits - 1, mask = (1u << bits) - 1;
    const float part = 1 / static_cast<float>(1u << bits), scale = 2 / side;
    const size_t octant = walk_octant(cell, p);
    const size_t first = (octant & 1) + (octant >> 1 & 1) * 3 + (octant >> 2) * 9;
    Vec3f u;
    for (size_t a = 0; a < 3; ++a)
        u[static_cast<int>(a)] = static_cast<float>(static_cast<int32_t>(p[a] & mask)) * part;
    out->own = walk_between(own.data() + first, u, &out->own_slope);
    out->own_slope = out->own_slope * scale;
    out->object = kInfinity;
    if (!with_object) return;
    out->object = walk_between(object.data() + first, u, &out->object_slope);
    out->object_slope = out->object_slope * scale;
}

/// Returns the state of a walk's random numbers, each of which is a hash of the state, advanced by 0x9e3779b9.
inline uint32_t walk_seed(const Vec3f& from, int32_t seed) {
    uint32_t state = abi::mix32(static_cast<uint32_t>(seed) ^ 0x2545f491u);
    for (int a = 0; a < 3; ++a)
        state = abi::mix32(state ^ std::bit_cast<uint32_t>(from[a]));
    return state;
}

}  // namespace openfab::volume
