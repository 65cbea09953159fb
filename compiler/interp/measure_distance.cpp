// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/measure_distance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <random>

#include "compiler/interp/evaluate.h"

namespace openfab::interp {

namespace {

using Point = std::array<float, 3>;

/// Instructions that are interpreted at most: a quarter of a second.
constexpr size_t kMostWork = 20'000'000;
constexpr size_t kMostPoints = 2000;
constexpr int kSearched = 300;
/// Of a side that is judged.
constexpr size_t kFewest = 30;
/// A difference of values may exceed that of the points by a hundredth, for their rounding.
constexpr float kSlack = 1.01F;
/// The value where a distance is 0, of the distance that was gone.
constexpr float kMiss = 0.05F;
/// Of the cube. A gradient by differences over it is wrong as near to an edge of the field.
constexpr float kStep = 1e-3F;
/// The share of points at which it may be.
constexpr float kAtEdges = 0.05F;

class DefaultEnvironment : public Environment {
  public:
    explicit DefaultEnvironment(const ir::Fablet& fablet)
        : values_(static_cast<size_t>(fablet.uniform_value_count), 0) {
        for (const ir::Uniform& uniform : fablet.uniforms) {
            std::ranges::copy(uniform.default_bits,
                              values_.begin() + std::ptrdiff_t{uniform.first_index});
        }
    }

    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        if (kind == OPENFAB_ARG_UNIFORM) return values_[static_cast<size_t>(a)];
        return kind == OPENFAB_ARG_SHAPE_POINT ? std::bit_cast<uint32_t>(at[static_cast<size_t>(a)])
                                               : 0;  // the frame: the part's centre is the origin
    }
    TextureView texture(int32_t /*index*/) const override { return {}; }

    Point at{};

  private:
    std::vector<uint32_t> values_;
};

/// Returns whether all that the stage reads has a value.
bool is_known(const ir::Fablet& fablet, const ir::Stage& stage) {
    std::vector<bool> known(static_cast<size_t>(fablet.uniform_value_count), false);
    for (const ir::Uniform& uniform : fablet.uniforms) {
        const size_t first = static_cast<size_t>(uniform.first_index);
        for (size_t k = 0; k < uniform.default_bits.size(); ++k)
            known[first + k] = true;
    }
    return std::ranges::all_of(stage.instrs, [&](const ir::Instr& instr) {
        if (instr.op == ir::Op::kSample) return false;
        const bool uniform = instr.op == ir::Op::kInput && instr.kind == OPENFAB_ARG_UNIFORM;
        return !uniform || known[static_cast<size_t>(instr.a)];
    });
}

class Meter {
  public:
    Meter(const ir::Stage& stage, const ir::Fablet& fablet) : stage_(stage), environment_(fablet) {}

    std::optional<NoDistance> run() {
        if (!find_cube()) return std::nullopt;
        const size_t points = std::min(kMostPoints, kMostWork / (8 * stage_.instrs.size() + 1));
        // Inside and outside counted by themselves: the inside may be little of the cube.
        struct Side {
            size_t points = 0, missed = 0;
            std::optional<NoDistance> worst;
        };
        std::array<Side, 2> sides;
        Point before = draw();
        for (size_t i = 0; i < points; ++i) {
            const Point p = draw();
            // Near ones tell of steep places, far ones of the whole.
            if (std::optional<NoDistance> steep = compare(p, i % 2 == 0 ? before : near(p)))
                return steep;
            before = p;
            const NoDistance miss = go(p);
            Side& side = sides[miss.value < 0 ? 0 : 1];
            ++side.points;
            if (!(std::abs(miss.then) > kMiss * std::abs(miss.value) + 2 * kStep * half_)) continue;
            ++side.missed;
            if (!side.worst || std::abs(miss.then) > std::abs(side.worst->then)) side.worst = miss;
        }
        for (Side& side : sides) {
            const float share = static_cast<float>(side.missed) / static_cast<float>(side.points);
            if (side.points < kFewest || share < kAtEdges) continue;
            side.worst->share = share;
            return side.worst;
        }
        return std::nullopt;
    }

  private:
    float value(const Point& p) {
        environment_.at = p;
        return std::bit_cast<float>(evaluate(stage_, environment_)[0]);
    }

    Point draw() {
        Point p;
        for (float& x : p)
            x = (static_cast<float>(random_() >> 8) * 0x1p-23F - 1) * half_;
        return p;
    }

    Point near(const Point& p) {
        Point q = p;
        for (float& x : q)
            x += (static_cast<float>(random_() >> 8) * 0x1p-23F - 1) * half_ * 0.02F;
        return q;
    }

    /// Finds the smallest cube with an inside and an outside, and takes one twice as large.
    bool find_cube() {
        for (half_ = 1; half_ < 500; half_ *= 2) {
            bool inside = false, outside = false;
            for (int i = 0; i < kSearched && !(inside && outside); ++i)
                (value(draw()) < 0 ? inside : outside) = true;
            if (inside && outside) {
                half_ *= 2;
                return true;
            }
        }
        return false;
    }

    std::optional<NoDistance> compare(const Point& p, const Point& q) {
        const float a = value(p), b = value(q);
        const float apart = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
        if (!(std::abs(a - b) > kSlack * apart + 1e-6F * half_)) return std::nullopt;
        return NoDistance{p, a, b, q, half_, 0};
    }

    /// Goes from p by its value against the gradient.
    NoDistance go(const Point& p) {
        const float at = value(p);
        Point gradient{};
        float square = 0;
        for (size_t axis = 0; axis < p.size(); ++axis) {
            Point more = p, less = p;
            more[axis] += kStep * half_;
            less[axis] -= kStep * half_;
            gradient[axis] = value(more) - value(less);
            square += gradient[axis] * gradient[axis];
        }
        const float scale = square > 0 ? at / std::sqrt(square) : 0;
        Point foot = p;
        for (size_t axis = 0; axis < p.size(); ++axis)
            foot[axis] -= scale * gradient[axis];
        return {p, at, value(foot), {}, half_, 0};
    }

    const ir::Stage& stage_;
    DefaultEnvironment environment_;
    std::mt19937 random_{1};
    float half_ = 1;
};

}  // namespace

std::optional<NoDistance> measure_distance(const ir::Fablet& fablet) {
    ir::Stage stage = fablet.shape;
    std::erase_if(stage.outputs,
                  [](const ir::Output& o) { return o.kind != OPENFAB_ARG_SHAPE_VALUE; });
    ir::drop_dead_values(&stage);
    if (!is_known(fablet, stage)) return std::nullopt;
    return Meter(stage, fablet).run();
}

}  // namespace openfab::interp
