// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random walks from ball to empty ball that end on a surface (rule 24): where they end, a function has the mean that the
// harmonic function with these values on the surface has where they begin. Here is what defines an end; who walks
// supplies the lattice, from memory (walk_lattice.h) or by computing each node anew (the twin of tests).
//
// Source: Sawhney and Crane, "Monte Carlo geometry processing", ACM Transactions on Graphics 39 (2020), where balls are
// about the point; exits of other balls are by Poisson's kernel.

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

/// Whether a cell is read, not one of its eighths: linear between its nodes it is right to an eighth of `stop` and a
/// fortieth of the distance where the surface is smooth, or it is as small as `stop`.
inline bool walk_reads(float side, uint32_t bits, float miss, float stop) {
    return miss <= 0.5f * stop || side <= stop || bits <= 2;
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

/// Uniform random numbers of a walk.
class WalkRandom {
  public:
    WalkRandom() = default;
    WalkRandom(const Vec3f& from, int32_t seed) {
        base_ = abi::mix32(static_cast<uint32_t>(seed) ^ 0x2545f491u);
        for (int a = 0; a < 3; ++a)
            base_ = abi::mix32(base_ ^ std::bit_cast<uint32_t>(from[a]));
    }
    /// Returns the next one, 0 to 1, without 1.
    float next() {
        base_ += 0x9e3779b9u;
        return static_cast<float>(abi::mix32(base_) >> 8) * 0x1p-24f;
    }

  private:
    uint32_t base_ = 0;
};

/// Cosine and sine of `turn` turns, 0 to 1, within 1e-6.
inline Vec2<float> walk_direction(float turn) {
    const float quarters = 4 * turn;
    const auto quarter = static_cast<int32_t>(quarters);
    const float a = (quarters - static_cast<float>(quarter) - 0.5f) * 1.57079633f, a2 = a * a;
    const float c = 1 + a2 * (-0.5f + a2 * (1.0f / 24 + a2 * (-1.0f / 720 + a2 * (1.0f / 40320))));
    const float s = a * (1 + a2 * (-1.0f / 6 + a2 * (1.0f / 120 + a2 * (-1.0f / 5040))));
    switch (quarter & 3) {
        case 0:
            return {c, s};
        case 1:
            return {-s, c};
        case 2:
            return {-c, -s};
        default:
            return {s, -c};
    }
}

/// Where a walk ends.
struct WalkEnd {
    Vec3f at;  ///< part-local mm
    bool on_object = false;
};

/// A walk under way: as long as it is, what is known at `asks` is to be told to `take`.
class Walk {
  public:
    Walk() = default;
    Walk(const Vec3f& p, float stop, int32_t seed)
        : stop_(std::max(stop, kLeastStop)), random_(p, seed), at_(p), asks_(p) {}

    bool under_way() const { return phase_ != Phase::kEnded; }
    const Vec3f& asks() const { return asks_; }
    float stop() const { return stop_; }
    /// Goes on with what is known at the place; not `known`: nothing is.
    void take(bool known, const WalkField& there) {
        switch (phase_) {
            case Phase::kEnded:
                return;
            case Phase::kBegins:
                if (!known) return end();
                // From inside the object it ends at its surface, too.
                side_ = there.object < 0 ? -1.0f : 1.0f;
                arrive(there);
                reach_ = kFirstReach * height_;
                return step();
            case Phase::kRises:
                if (!known || !(nearest(there) > stop_)) return end();
                arrive(there);
                return step();
            case Phase::kTries:
                return leave(known ? empty(nearest(there), there.over) : 0.0f);
            case Phase::kLeaves:
                if (!known) return end();
                arrive(there);
                return step();
        }
    }
    WalkEnd result() const { return {at_ - up_ * height_, on_object_}; }

  private:
    enum class Phase : uint8_t { kBegins, kRises, kTries, kLeaves, kEnded };

    // Most steps of a walk, which one in a million reaches.
    static constexpr int32_t kMostSteps = 256;
    static constexpr float kLeastStop = 1e-4f;
    static constexpr float kFirstReach = 2, kWorth = 0.7f, kShrink = 0.3f;

    void end() { phase_ = Phase::kEnded; }
    void ask(Phase phase, const Vec3f& p) {
        phase_ = phase;
        asks_ = p;
    }
    float nearest(const WalkField& field) const {
        const float object = side_ * field.object;
        return object < field.own ? object : field.own;
    }
    void arrive(const WalkField& field) {
        const float object = side_ * field.object;
        on_object_ = object < field.own;
        at_ = asks_;
        height_ = on_object_ ? object : field.own;
        over_ = field.over;
        const Vec3f slope = on_object_ ? field.object_slope * side_ : field.own_slope;
        up_ = slope * (1 / std::max(length(slope), 1e-20f));
    }

    /// Returns the radius of a ball that is empty. Between nodes of a smooth field errors are a quarter of those between
    /// corners.
    static float empty(float height, float over) { return height - 0.5f * over; }

    void step() {
        if (++steps_ > kMostSteps) return end();
        if (height_ < stop_) {
            // A lot between the surface and a place farther than `stop`, or it would be cast there again.
            const float away = 1.25f * stop_;
            if (!(random_.next() * away < height_)) return end();
            return ask(Phase::kRises, at_ + up_ * (away - height_));
        }
        // A ball that touches the surface where it is nearest may be larger than one about the place.
        if (height_ < 0.5f * reach_) return ask(Phase::kTries, at_ + up_ * (reach_ - height_));
        reach_ = std::max(reach_, height_);
        leave_ball_about();
    }

    /// `large`: the radius of the ball that was tried.
    void leave(float large) {
        const float inside = large - reach_ + height_;
        if (inside > kWorth * height_ && large > empty(height_, over_)) {
            const float touch = reach_ - large;
            reach_ = large;
            return leave_ball(touch, large, std::min(inside / large, 1.0f));
        }
        reach_ = std::max(kShrink * reach_, height_);
        leave_ball_about();
    }
    void leave_ball_about() {
        const float radius = std::max(empty(height_, over_), 0.5f * height_);
        leave_ball(height_ - radius, radius, 1);
    }
    void leave_ball(float touch, float radius, float depth) {
        ask(Phase::kLeaves, exit(at_ - up_ * height_, touch, radius, depth));
    }

    /// Returns where the walk leaves a ball of that radius, which begins at the height `touch` above the foot, and in which
    /// the walk is at the share `depth` of the radius under the ball's surface, straight below its centre.
    Vec3f exit(const Vec3f& foot, float touch, float radius, float depth) {
        const float v = 2 * random_.next();
        const float out_of = 1 - depth, below = depth + out_of * v;
        // 1 - cos of the angle from straight below.
        const float fall = depth * depth * (2 - v) * (2 + out_of * v) / (2 * below * below);
        const Vec2<float> way = walk_direction(random_.next());
        const Vec3f side =
            std::fabs(up_.x) > 0.6f ? Vec3f{-up_.z, 0, up_.x} : Vec3f{0, up_.z, -up_.y};
        const Vec3f across = side * (1 / std::max(length(side), 1e-20f));
        const Vec3f round = across * way.x + cross(up_, across) * way.y;
        const float flat = radius * std::sqrt(std::max(fall * (2 - fall), 0.0f));
        return foot + up_ * (touch + radius * fall) + round * flat;
    }

    float stop_ = kLeastStop;
    WalkRandom random_;
    Vec3f at_, up_, asks_;
    float height_ = 0, over_ = 0, side_ = 1, reach_ = 0;
    int32_t steps_ = 0;
    bool on_object_ = false;
    Phase phase_ = Phase::kBegins;
};

}  // namespace openfab::volume
