// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interval form of a stage: every value becomes a pair of values that bound it for all points
// of a box at once.
//
//   number   lo <= value <= hi. Floats are either both finite or both NaN, which means that nothing
//            is known (the value may be a NaN or infinite). Ends are rounded to nearest as the value
//            itself is: rounding is monotone, so bounds of the computed value follow from bounds of
//            its computed operands; nothing need be widened.
//   bool     lo: it may be false, hi: it may be true
//
// A point (uniforms, frame, constants and what follows from them alone) is the value itself,
// computed as in the stage, and may be infinite or NaN. If lo and hi have equal bits, every point
// of the box has that value (0 and -0 count as equal). Errs wide: operands are taken as
// independent; int results that may overflow are the whole range; a division by an interval that
// contains 0 is unknown; so are the results of loops and queries.

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

struct Interval {
    ir::ValueId lo = ir::kNoValue;
    ir::ValueId hi = ir::kNoValue;
    ir::ValueId point = ir::kNoValue;  ///< the value itself where it is a point

    bool is_point() const { return point != ir::kNoValue; }
};

/// Builds the interval form of one stage in another.
class IntervalForm {
  public:
    /// Maps an input kind to those of its lower and upper ends; none: the input is a point.
    using InputKinds = std::function<std::optional<std::array<int32_t, 2>>(int32_t kind)>;
    /// True for inputs that have no interval form: their values are unknown.
    using UnknownInput = std::function<bool(int32_t kind)>;

    IntervalForm(const ir::Stage& from, ir::Stage* to, InputKinds kinds, UnknownInput unknown);

    /// Returns the interval of every instruction of `from`, by id; empty inside loops.
    const std::vector<Interval>& run();
    ir::Builder& builder() { return b_; }

  private:
    using Id = ir::ValueId;
    using Op = ir::Op;
    using Type = ir::Type;

    Interval interval_of(const ir::Instr& instr);
    Interval input_interval(const ir::Instr& instr);
    // interval_functions.cpp
    Interval function_interval(const ir::Instr& instr);
    Interval monotone_interval(Op op, const Interval& a, bool falls);
    Interval wave_interval(Op op, const Interval& a);
    Interval tangent_interval(const Interval& a);
    Interval angle_interval(const Interval& y, const Interval& x);
    Interval power_interval(const Interval& x, const Interval& y);
    Interval noise_interval(const ir::Instr& instr);
    Interval around_centre(const ir::Instr& instr, size_t axes, float one, float all, Id farthest);
    Interval widened(Id first, Id last);
    Interval hash_interval(const ir::Instr& instr);
    // interval_integers.cpp
    Interval integer_interval(const ir::Instr& instr);
    Interval integer_sum(Op op, Type type, const Interval& a, const Interval& b);
    Interval integer_product(Type type, const Interval& a, const Interval& b);
    Interval integer_rest(Op op, Type type, const Interval& a, const Interval& b);
    /// Returns the exact result if both operands are single values, else `other`.
    Interval exact_or(Op op, const Interval& a, const Interval& b, const Interval& other);
    // interval_sawtooth.cpp
    /// A value that rises, or falls, between breaks at which it starts anew.
    struct Sawtooth {
        Id at_lo, at_hi;               ///< at the ends of the box
        Id before_break, after_break;  ///< the limits on either side of a break
        Id breaks;                     ///< how many are in the box
        Id known;
    };
    std::optional<Sawtooth> sawtooth(Id value, int depth);
    /// Returns the magnitude of a sawtooth; nothing of another value.
    std::optional<Interval> folded_interval(Id value);
    // interval_samples.cpp
    Interval sample_interval(const ir::Instr& instr);
    Interval query_result_interval(const ir::Instr& instr);
    Interval or_zero(const Interval& guard, const Interval& value);
    Id distance_from_centre(const ir::Instr& query);
    Id offset_from_centre(Id coordinate, int32_t axis);
    Interval voxel_centre(int32_t axis);
    bool is_frame(Id value, int32_t index) const;
    bool is_centre(Id value, int32_t axis) const;
    Id frame(int32_t index);
    Id magnitude(Id value) { return magnitude_interval(values_[value]).hi; }
    Interval convert_interval(const ir::Instr& instr);
    Interval select_interval(const ir::Instr& instr);
    Interval pick_interval(const ir::Instr& instr);
    Interval all_elements(const ir::Instr& pick);
    Interval bool_interval(Op op, const Interval& a, const Interval& b);
    Interval comparison_interval(Op op, const Interval& a, const Interval& b);
    Interval float_interval(const ir::Instr& instr);
    Interval product_interval(const ir::Instr& instr, const Interval& a, const Interval& b);
    Interval by_point(Op op, Id id, const Interval& a, const Interval& point);
    Interval quotient_interval(const ir::Instr& instr, const Interval& a, const Interval& b);
    Interval general_quotient(const Interval& a, const Interval& b);
    Interval remainder_interval(const Interval& a, const Interval& b);
    Interval magnitude_interval(const Interval& a);
    Interval square_interval(const Interval& a);
    Interval root_interval(const Interval& a);

    Interval make_point(Id value);
    Interval make_bool(Id may_be_false, Id may_be_true);
    /// Returns both ends if they are `bounded`, else unknown.
    Interval finish(Id lo, Id hi);
    Interval finish_if(Id known, Id lo, Id hi);
    /// Returns both ends where `known`, else unknown; for ends that are finite then.
    Interval select_known(Id known, Id lo, Id hi);
    /// Returns whether both ends are finite, and a finite distance apart.
    Id bounded(Id lo, Id hi);
    /// Returns whether something is known of a float.
    Id is_known(const Interval& a);
    Interval extremes(const std::array<Id, 4>& candidates);
    Interval hull(const Interval& a, const Interval& b, Type type);
    Interval full_range(Type type);
    Interval unknown(Type type);

    Id emit(Op op, Id a) { return b_.emit(op, {a}); }
    Id emit(Op op, Id a, Id b) { return b_.emit(op, {a, b}); }
    Id negate(Id condition) { return emit(Op::kNot, condition); }
    Id both(Id a, Id b) { return emit(Op::kAnd, a, b); }
    Id either(Id a, Id b) { return emit(Op::kOr, a, b); }
    Id nan();
    Id finite(Id value);
    Id constant_like(Type type, float value);
    Type type_of(Id value) { return b_.type(value); }

    const ir::Stage& from_;
    ir::Builder b_;
    InputKinds kinds_;
    UnknownInput unknown_;
    std::vector<Interval> values_;
};

}  // namespace openfab::passes
