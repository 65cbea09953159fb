// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A random walk (rule 24), alone and one number at a time, by a lattice of which each node is asked alone: the twin of
// runtime/volume/walk_lanes.inl and walk_lattice.cpp.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "abi/voxel_hash.h"
#include "base/vec.h"
#include "runtime/volume/walk.h"

namespace openfab::reference {

/// Uniform random numbers of a walk.
class WalkRandom {
  public:
    WalkRandom(const Vec3f& from, int32_t seed) : base_(volume::walk_seed(from, seed)) {}
    /// Returns the next one, 0 to 1, without 1.
    float next() {
        base_ += 0x9e3779b9u;
        return static_cast<float>(abi::mix32(base_) >> 8) * 0x1p-24f;
    }

  private:
    uint32_t base_;
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
    Walk(const Vec3f& p, float stop, int32_t seed)
        : stop_(std::max(stop, kLeastStop)), random_(p, seed), at_(p), asks_(p) {}

    bool under_way() const { return phase_ != Phase::kEnded; }
    const Vec3f& asks() const { return asks_; }
    float stop() const { return stop_; }
    /// Goes on with what is known at the place; not `known`: nothing is.
    void take(bool known, const volume::WalkField& there) {
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
    float nearest(const volume::WalkField& field) const {
        const float object = side_ * field.object;
        return object < field.own ? object : field.own;
    }
    void arrive(const volume::WalkField& field) {
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

/// Walks in a part.
class PlainWalks {
  public:
    using Distance = std::function<float(const Vec3f& p)>;
    /// `own`: to the surface, positive inside; `object`: negative inside it, or none.
    PlainWalks(const Box3f& bounds, Distance own, Distance object)
        : grid_(bounds), own_(std::move(own)), object_(std::move(object)) {}

    WalkEnd end(const Vec3f& p, float stop, int32_t seed) {
        Walk walk(p, stop, seed);
        while (walk.under_way()) {
            volume::WalkField field;
            const bool known = read(walk.asks(), walk.stop(), &field);
            walk.take(known, field);
        }
        return walk.result();
    }

  private:
    using Nodes = std::pair<volume::WalkNodes, volume::WalkNodes>;

    bool read(const Vec3f& p, float stop, volume::WalkField* out) {
        volume::WalkPlace at;
        if (!grid_.find(p, &at)) return false;
        volume::WalkCell cell = volume::walk_root(at);
        while (true) {
            const auto& [own, object] = nodes(cell);
            const float side = grid_.side(cell);
            const volume::WalkErrors errors = volume::walk_errors(own, object, side);
            if (errors.miss <= 0.5f * stop || side <= stop || cell.bits <= 2) {
                out->over = errors.over;
                volume::walk_read(own, object, cell, side, at, object_ != nullptr, out);
                return true;
            }
            cell = volume::walk_child(cell, volume::walk_octant(cell, at));
        }
    }
    const Nodes& nodes(const volume::WalkCell& cell) {
        const auto [at, fresh] = known_.try_emplace({cell.bits, cell.lowest});
        auto& [own, object] = at->second;
        if (!fresh) return at->second;
        for (size_t k = 0; k < volume::kWalkNodes; ++k) {
            const Vec3f p = grid_.node(cell, k);
            own[k] = own_(p);
            object[k] = object_ ? object_(p) : std::numeric_limits<float>::infinity();
        }
        volume::walk_settle(&own, grid_.side(cell));
        if (object_) volume::walk_settle(&object, grid_.side(cell));
        return at->second;
    }

    const volume::WalkGrid grid_;
    const Distance own_, object_;
    std::map<std::pair<uint32_t, volume::WalkPlace>, Nodes> known_;
};

}  // namespace openfab::reference
