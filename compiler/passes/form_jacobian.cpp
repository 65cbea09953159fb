// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_jacobian.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "compiler/ir/grows.h"
#include "compiler/ir/shape_distance.h"
#include "compiler/passes/carry_changes.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/expand_picks.h"
#include "compiler/passes/simplify.h"

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

using Point = std::array<ValueId, 3>;
constexpr size_t kAxes = 3;
constexpr float kMostAmount = 0x1p126f;
constexpr const char* kDisplaced = "the displacement of its surface";
constexpr const char* kWalks = "where a random walk ends";
constexpr const char* kCarried = "what the nearest surface point is, or has, where that moves";

void clean(ir::Stage* stage) {
    simplify(stage);
    eliminate_common_values(stage);
    ir::drop_dead_values(stage);
}

/// Makes a stage what is differentiated: optimised, with Picks of uniforms alone.
void prepare(ir::Stage* stage) {
    clean(stage);
    expand_picks(stage);
    clean(stage);
}

/// The changes of uniforms.
class UniformSeeds : public Seeds {
  public:
    UniformSeeds(std::span<const Direction> directions, ir::Builder* builder,
                 std::vector<NoDerivative>* none)
        : directions_(directions), builder_(*builder), none_(*none) {}

    Mask active(const ir::Instr& input) const override {
        Mask out = 0;
        if (input.kind != OPENFAB_ARG_UNIFORM) return out;
        for (size_t k = 0; k < directions_.size(); ++k) {
            const auto& seeds = directions_[k].seeds;
            const bool any = std::any_of(seeds.begin(), seeds.end(), [&](const Direction::Seed& s) {
                return s.value == input.a;
            });
            if (any) out |= Mask{1} << k;
        }
        return out;
    }
    ValueId change(const ir::Instr& input, size_t direction) override {
        for (const Direction::Seed& seed : directions_[direction].seeds) {
            if (seed.value != input.a) continue;
            return seed.weight < 0
                       ? builder_.constant(1.0f)
                       : builder_.input(Type::kFloat, OPENFAB_ARG_UNIFORM, seed.weight, 0);
        }
        return kNoValue;
    }

    void refuse(const source::Span& span, const char* what) override {
        const bool known = std::any_of(none_.begin(), none_.end(), [&](const NoDerivative& n) {
            return n.span == span && n.what == what;
        });
        if (!known) none_.push_back({span, what});
    }

  protected:
    std::span<const Direction> directions_;
    ir::Builder& builder_;
    std::vector<NoDerivative>& none_;
};

/// A shape at a point of its own space: the directions of uniforms, then those of the point.
class ShapeSeeds : public UniformSeeds {
  public:
    ShapeSeeds(std::span<const Direction> directions, const Point& at, const Point& shrink,
               ir::Builder* builder, std::vector<NoDerivative>* none)
        : UniformSeeds(directions, builder, none), at_(at), shrink_(shrink) {}

    Mask active(const ir::Instr& input) const override {
        if (input.kind == OPENFAB_ARG_SHAPE_POINT) return Mask{1} << (directions_.size() + input.a);
        return UniformSeeds::active(input);
    }
    ValueId value(const ir::Instr& input) override {
        if (input.kind == OPENFAB_ARG_SHAPE_POINT) return at_[static_cast<size_t>(input.a)];
        const int32_t axis = input.a - OPENFAB_FRAME_CENTER;
        if (input.kind != OPENFAB_ARG_FRAME || axis < 0 || axis >= 3) return kNoValue;
        const ValueId center = builder_.input(Type::kFloat, OPENFAB_ARG_FRAME, input.a, 0);
        return builder_.emit(Op::kMul, {center, shrink_[static_cast<size_t>(axis)]});
    }
    ValueId change(const ir::Instr& input, size_t direction) override {
        if (input.kind == OPENFAB_ARG_SHAPE_POINT) return builder_.constant(1.0f);
        return UniformSeeds::change(input, direction);
    }

  private:
    const Point at_;
    const Point shrink_;
};

/// Of a volume stage.
class VolumeSeeds : public UniformSeeds {
  public:
    VolumeSeeds(const ir::Fablet& fablet, std::span<const Direction> directions,
                ir::Builder* builder, std::vector<NoDerivative>* none)
        : UniformSeeds(directions, builder, none), fablet_(fablet) {
        if (fablet.has_shape) find_moving();
        for (const ir::Instr& instr : fablet.surface.instrs)
            displaced_ |= reads(instr);
    }

    Mask active(const ir::Instr& input) const override {
        if (input.kind == OPENFAB_ARG_DISTANCE) return moving_ | displaced_;
        if (input.kind == OPENFAB_ARG_NEAREST) return carried_ | displaced_;
        return UniformSeeds::active(input);
    }

    /// Emits what the voxel's own distance needs, before any loop.
    void ask_at_centre(const ir::Stage& volume) {
        const bool asks =
            std::any_of(volume.instrs.begin(), volume.instrs.end(), [](const ir::Instr& instr) {
                return instr.op == Op::kInput && instr.kind == OPENFAB_ARG_DISTANCE;
            });
        if (!asks || moving_ == 0) return;
        at_centre_ = changes_of_distance(local_centre(), kNoValue, kNoValue).by_uniforms;
    }

    ValueId change(const ir::Instr& input, size_t direction) override {
        const bool distance = input.kind == OPENFAB_ARG_DISTANCE;
        if (distance || input.kind == OPENFAB_ARG_NEAREST) {
            if (displaced_ != 0) {
                refuse(input.span, kDisplaced);
            } else if (distance && !at_centre_.empty()) {
                return at_centre_[direction];
            } else if (!distance) {
                refuse(input.span, kCarried);
            }
            return kNoValue;
        }
        return UniformSeeds::change(input, direction);
    }

    Mask active_result(const ir::Instr& query, const ir::Instr& result, Mask point) const override {
        const bool own = query.a < 0 || ir::is_walk(query);
        const Mask moves = point | (own ? carried_ | displaced_ : 0);
        return result.type == Type::kFloat ? moves : 0;
    }

    void query_changes(ValueId query, const ir::Instr& result, ValueId value,
                       std::span<const Point> points, std::vector<ValueId>* changes) override {
        const ir::Instr of = builder_.instr(query);
        if (ir::is_walk(of)) return refuse(result.span, kWalks);
        if (of.a < 0 && displaced_ != 0) return refuse(result.span, kDisplaced);
        if (result.kind != OPENFAB_QUERY_DISTANCE) return refuse(result.span, kCarried);
        const Point at = {of.args[1], of.args[2], of.args[3]};
        Distance change;
        if (of.a < 0 && moving_ != 0) {
            change = changes_of_distance(at, query, value);
        } else if (any(points)) {
            change.by_point = slope_of_distance(query, value, at);
        }
        for (size_t k = 0; any(points) && k < points.size(); ++k) {
            for (size_t axis = 0; axis < kAxes; ++axis)
                add(&(*changes)[k], times(points[k][axis], change.by_point[axis]));
        }
        for (size_t k = 0; k < change.by_uniforms.size(); ++k)
            add(&(*changes)[k], change.by_uniforms[k]);
    }

  private:
    static bool any(std::span<const Point> points) {
        return std::any_of(points.begin(), points.end(), [](const Point& p) {
            return p[0] != kNoValue || p[1] != kNoValue || p[2] != kNoValue;
        });
    }

    Mask reads(const ir::Instr& instr) const {
        return instr.op == Op::kInput ? UniformSeeds::active(instr) : 0;
    }

    /// Finds the directions in which the shape's surface moves.
    void find_moving() {
        for (const ir::Instr& instr : fablet_.shape.instrs)
            carried_ |= reads(instr);
        if (carried_ == 0) return;
        if (ir::grows(fablet_)) return refuse(fablet_.shape.instrs[0].span, "the beams that grow");
        shape_ = fablet_.shape;
        shape_.printfs.clear();
        std::erase_if(shape_.outputs,
                      [](const ir::Output& o) { return o.kind != OPENFAB_ARG_SHAPE_VALUE; });
        prepare(&shape_);
        for (const ir::Instr& instr : shape_.instrs) {
            moving_ |= reads(instr);
            if (instr.op == Op::kQuery ||
                (instr.op == Op::kInput && instr.kind == abi::kShapeDistance))
                refuse(instr.span, "a shape that asks another object");
        }
        if (!none_.empty()) moving_ = 0;
    }

    ValueId add(ValueId a, ValueId b) {
        if (a == kNoValue) return b;
        return b == kNoValue ? a : builder_.emit(Op::kAdd, {a, b});
    }
    void add(ValueId* to, ValueId b) { *to = add(*to, b); }
    ValueId times(ValueId a, ValueId b) {
        return a == kNoValue ? kNoValue : builder_.emit(Op::kMul, {a, b});
    }

    ValueId frame(int32_t which) {
        return builder_.input(Type::kFloat, OPENFAB_ARG_FRAME, which, 0);
    }
    ValueId shrink(size_t axis) {
        return frame(OPENFAB_FRAME_SHAPE_SHRINK + static_cast<int32_t>(axis));
    }
    ValueId or_zero(ValueId a) { return a == kNoValue ? builder_.constant(0.0f) : a; }

    /// As abi/fablet_table.h says.
    Point local_centre() {
        Point out;
        for (int32_t c = 0; c < 3; ++c) {
            constexpr std::array kSteps = {OPENFAB_FRAME_STEP_I, OPENFAB_FRAME_STEP_J,
                                           OPENFAB_FRAME_STEP_K};
            ValueId sum = kNoValue;
            for (int32_t axis = 0; axis < 3; ++axis) {
                const ValueId at = builder_.input(Type::kFloat, ir::kVoxelCoord, axis, 0);
                add(&sum, times(at, frame(kSteps[static_cast<size_t>(axis)] + c)));
            }
            out[static_cast<size_t>(c)] = add(sum, frame(OPENFAB_FRAME_ORIGIN + c));
        }
        return out;
    }

    Point result_of(ValueId query, openfab_query_result kind) {
        Point out;
        for (int32_t axis = 0; axis < 3; ++axis)
            out[static_cast<size_t>(axis)] =
                builder_.query_result(query, Type::kFloat, kind, 0, axis);
        return out;
    }

    /// How a distance changes: by its point, along each axis, and in each direction where its surface moves.
    struct Distance {
        Point by_point{kNoValue, kNoValue, kNoValue};
        std::vector<ValueId> by_uniforms;
    };

    /// Returns the change of a distance by its point: from the nearest surface point away, on the surface its normal.
    Point slope_of_distance(ValueId query, ValueId distance, const Point& at) {
        const Point nearest = result_of(query, OPENFAB_QUERY_POSITION);
        const Point normal = result_of(query, OPENFAB_QUERY_NORMAL);
        const ValueId on = builder_.emit(Op::kEq, {distance, builder_.constant(0.0f)});
        Point out;
        for (size_t axis = 0; axis < kAxes; ++axis) {
            const ValueId away = builder_.emit(Op::kSub, {at[axis], nearest[axis]});
            out[axis] =
                builder_.select(on, normal[axis], builder_.emit(Op::kDiv, {away, distance}));
        }
        return out;
    }

    /// Returns the changes of the distance to the shape's surface. A declared distance is the shape's value at the point
    /// itself, and is differentiated as such; a query, which may be given, is made only where one is searched for.
    Distance changes_of_distance(const Point& at, ValueId query, ValueId distance) {
        if (!fablet_.shape_is_distance) {
            if (query == kNoValue) query = builder_.query(-1, builder_.constant(true), at);
            return searched_changes(at, query, distance);
        }
        const ValueId zero = builder_.constant(0.0f);
        const ValueId scale = frame(OPENFAB_FRAME_SHAPE_DISTANCE);
        const ValueId declared = builder_.emit(Op::kNe, {scale, zero});
        const ValueId searched = builder_.emit(Op::kEq, {scale, zero});
        const Distance other = searched_changes(at, builder_.query(-1, searched, at), kNoValue);
        const Distance of_value = shape_changes(at);
        Distance out;
        for (size_t axis = 0; axis < kAxes; ++axis) {
            // The scale of values and the shrinkage of space are 1 together.
            out.by_point[axis] = builder_.select(declared, or_zero(of_value.by_point[axis]),
                                                 or_zero(other.by_point[axis]));
        }
        for (size_t k = 0; k < directions_.size(); ++k) {
            const ValueId change = times(of_value.by_uniforms[k], scale);
            if (change == kNoValue && other.by_uniforms[k] == kNoValue) {
                out.by_uniforms.push_back(kNoValue);
                continue;
            }
            out.by_uniforms.push_back(
                builder_.select(declared, or_zero(change), or_zero(other.by_uniforms[k])));
        }
        return out;
    }

    /// Of a distance that is searched for: the change of the shape's value at the nearest point by the length of its
    /// gradient there.
    Distance searched_changes(const Point& at, ValueId query, ValueId distance) {
        // Beside the surface, on the side of the point: many formulas have an edge where they are 0.
        constexpr float kBeside = 0x1p-14f;
        if (distance == kNoValue)
            distance = builder_.query_result(query, Type::kFloat, OPENFAB_QUERY_DISTANCE, 0, 0);
        Distance out;
        out.by_point = slope_of_distance(query, distance, at);
        const ValueId zero = builder_.constant(0.0f);
        const ValueId step =
            builder_.select(builder_.emit(Op::kGt, {distance, zero}), builder_.constant(kBeside),
                            builder_.constant(-kBeside));
        Point beside = result_of(query, OPENFAB_QUERY_POSITION);
        for (size_t axis = 0; axis < kAxes; ++axis)
            beside[axis] = add(beside[axis], times(out.by_point[axis], step));
        const Distance value = shape_changes(beside);
        ValueId square = kNoValue;
        for (size_t axis = 0; axis < kAxes; ++axis) {
            const ValueId of_part = times(value.by_point[axis], shrink(axis));
            add(&square, times(of_part, of_part));
        }
        out.by_uniforms.assign(directions_.size(), kNoValue);
        if (square == kNoValue) return out;
        const ValueId length = builder_.emit(Op::kSqrt, {square});
        const ValueId flat = builder_.emit(Op::kEq, {length, zero});
        for (size_t k = 0; k < directions_.size(); ++k) {
            const ValueId change = value.by_uniforms[k];
            if (change == kNoValue) continue;
            out.by_uniforms[k] =
                builder_.select(flat, zero, builder_.emit(Op::kDiv, {change, length}));
        }
        return out;
    }

    /// Returns the changes of the shape's value at a point of the part, in the space of the stage.
    Distance shape_changes(const Point& at) {
        const Point by = {shrink(0), shrink(1), shrink(2)};
        Point there;
        for (size_t axis = 0; axis < kAxes; ++axis)
            there[axis] = times(at[axis], by[axis]);
        ShapeSeeds seeds(directions_, there, by, &builder_, &none_);
        const ir::Stage shape = with_open_noises(shape_, seeds);
        ChangeCarrier carrier(shape, directions_.size() + kAxes, &seeds, &builder_);
        carrier.run();
        const ValueId value = shape.outputs[0].value;
        Distance out;
        for (size_t axis = 0; axis < kAxes; ++axis)
            out.by_point[axis] = carrier.change(value, directions_.size() + axis);
        for (size_t k = 0; k < directions_.size(); ++k)
            out.by_uniforms.push_back(carrier.change(value, k));
        return out;
    }

    const ir::Fablet& fablet_;
    ir::Stage shape_;     ///< its value
    Mask carried_ = 0;    ///< directions in which anything of the shape changes
    Mask moving_ = 0;     ///< in which its surface moves
    Mask displaced_ = 0;  ///< in which the displacement, or what it hands on, changes
    std::vector<ValueId> at_centre_;
};

/// Normalises amounts with their changes.
class Fractions {
  public:
    Fractions(const ir::Stage& volume, const ChangeCarrier& carrier, ir::Builder* builder)
        : volume_(volume), carrier_(carrier), builder_(*builder), zero_(builder->constant(0.0f)) {
        for (const ir::Output& output : volume.outputs) {
            const ValueId amount = carrier.value(output.value);
            above_.push_back(builder_.emit(Op::kGt, {amount, zero_}));
            clean_.push_back(builder_.select(above_.back(), amount, zero_));
            total_ = total_ == kNoValue ? clean_.back()
                                        : builder_.emit(Op::kAdd, {total_, clean_.back()});
        }
        const ValueId most = builder_.constant(kMostAmount);
        usable_ = builder_.emit(Op::kAnd, {builder_.emit(Op::kGt, {total_, zero_}),
                                           builder_.emit(Op::kLt, {total_, most})});
        for (const ValueId amount : clean_)
            fractions_.push_back(builder_.emit(Op::kDiv, {amount, total_}));
    }

    /// Returns the change of each slot's fraction.
    std::vector<ValueId> changes(size_t direction) {
        std::vector<ValueId> of_amounts;
        ValueId of_total = kNoValue;
        for (size_t slot = 0; slot < clean_.size(); ++slot) {
            ValueId change = carrier_.change(volume_.outputs[slot].value, direction);
            if (change != kNoValue) {
                change = builder_.select(above_[slot], change, zero_);
                of_total =
                    of_total == kNoValue ? change : builder_.emit(Op::kAdd, {of_total, change});
            }
            of_amounts.push_back(change);
        }
        if (of_total == kNoValue) return std::vector<ValueId>(clean_.size(), zero_);
        std::vector<ValueId> out;
        for (size_t slot = 0; slot < clean_.size(); ++slot) {
            const ValueId share = builder_.emit(Op::kMul, {fractions_[slot], of_total});
            const ValueId own = of_amounts[slot] == kNoValue ? zero_ : of_amounts[slot];
            const ValueId change =
                builder_.emit(Op::kDiv, {builder_.emit(Op::kSub, {own, share}), total_});
            out.push_back(builder_.select(usable_, change, zero_));
        }
        return out;
    }

  private:
    const ir::Stage& volume_;
    const ChangeCarrier& carrier_;
    ir::Builder& builder_;
    const ValueId zero_;
    ValueId total_ = kNoValue, usable_ = kNoValue;
    std::vector<ValueId> above_, clean_, fractions_;
};

}  // namespace

Jacobian form_jacobian(const ir::Fablet& fablet, std::span<const Direction> directions) {
    Jacobian out;
    ir::Stage volume = fablet.volume;
    prepare(&volume);
    out.stage.kind = ir::StageKind::kVolume;
    out.stage.printfs = volume.printfs;
    ir::Builder builder(&out.stage);
    VolumeSeeds seeds(fablet, directions, &builder, &out.none);
    volume = with_open_noises(volume, seeds);
    seeds.ask_at_centre(volume);
    ChangeCarrier carrier(volume, directions.size(), &seeds, &builder);
    carrier.run();
    for (ir::Output output : volume.outputs) {
        output.value = carrier.value(output.value);
        out.stage.outputs.push_back(std::move(output));
    }
    Fractions fractions(volume, carrier, &builder);
    for (size_t k = 0; k < directions.size(); ++k) {
        const std::vector<ValueId> changes = fractions.changes(k);
        for (size_t slot = 0; slot < changes.size(); ++slot) {
            const auto number = static_cast<int32_t>(out.stage.outputs.size());
            out.stage.outputs.push_back({fmt::format("{}_{}", volume.outputs[slot].name, k),
                                         OPENFAB_ARG_WEIGHT, number, 0, changes[slot]});
        }
    }
    if (!out.none.empty()) out.stage = {};
    ir::drop_dead_values(&out.stage);
    return out;
}

}  // namespace openfab::passes
