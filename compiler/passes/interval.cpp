// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/interval.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "base/infinity.h"

namespace openfab::passes {

namespace {

using ir::Instr;

constexpr uint32_t kQuietNan = 0x7fc00000u;

}  // namespace

IntervalForm::IntervalForm(const ir::Stage& from, ir::Stage* to, InputKinds kinds,
                           UnknownInput unknown)
    : from_(from), b_(to), kinds_(std::move(kinds)), unknown_(std::move(unknown)) {}

const std::vector<Interval>& IntervalForm::run() {
    values_.reserve(from_.instrs.size());
    int depth = 0;
    for (const Instr& instr : from_.instrs) {
        b_.set_span(instr.span);
        if (instr.op == Op::kLoop) ++depth;
        const bool used = depth == 0 && instr.op != Op::kPrintf && instr.op != Op::kQuery;
        values_.push_back(used ? interval_of(instr) : Interval{});
        if (instr.op == Op::kLoopEnd) --depth;
    }
    return values_;
}

Interval IntervalForm::unknown(Type type) {
    if (type == Type::kFloat) return {nan(), nan(), ir::kNoValue};
    if (type == Type::kBool) return make_bool(b_.constant(true), b_.constant(true));
    return full_range(type);
}

Interval IntervalForm::make_point(Id value) {
    if (type_of(value) != Type::kBool) return {value, value, value};
    return {negate(value), value, value};
}

Interval IntervalForm::make_bool(Id may_be_false, Id may_be_true) {
    return {may_be_false, may_be_true, ir::kNoValue};
}

ir::ValueId IntervalForm::nan() {
    return b_.constant(std::bit_cast<float>(kQuietNan));
}

ir::ValueId IntervalForm::finite(Id value) {
    return emit(Op::kLt, emit(Op::kAbs, value), b_.constant(kInfinity));
}

Interval IntervalForm::finish_if(Id known, Id lo, Id hi) {
    return select_known(both(known, bounded(lo, hi)), lo, hi);
}

Interval IntervalForm::finish(Id lo, Id hi) {
    return select_known(bounded(lo, hi), lo, hi);
}

Interval IntervalForm::select_known(Id known, Id lo, Id hi) {
    const Id unknown = nan();
    return {b_.select(known, lo, unknown), b_.select(known, hi, unknown), ir::kNoValue};
}

/// One test for both ends: their distance is infinite or NaN where one of them is.
ir::ValueId IntervalForm::bounded(Id lo, Id hi) {
    if (lo == hi) return finite(lo);
    return emit(Op::kLt, emit(Op::kSub, hi, lo), b_.constant(kInfinity));
}

ir::ValueId IntervalForm::is_known(const Interval& a) {
    return a.is_point() ? finite(a.lo) : negate(emit(Op::kIsNan, a.lo));
}

/// A NaN candidate only occurs beside others that are not finite, or all are NaN: see
/// product_interval.
Interval IntervalForm::extremes(const std::array<Id, 4>& c) {
    const Id lo = emit(Op::kMin, emit(Op::kMin, c[0], c[1]), emit(Op::kMin, c[2], c[3]));
    const Id hi = emit(Op::kMax, emit(Op::kMax, c[0], c[1]), emit(Op::kMax, c[2], c[3]));
    return {lo, hi, ir::kNoValue};
}

Interval IntervalForm::interval_of(const Instr& instr) {
    if (instr.op == Op::kConst) return make_point(b_.append(instr));
    if (instr.op == Op::kInput) return input_interval(instr);
    if (instr.op == Op::kLoopResult) return unknown(instr.type);
    if (instr.op == Op::kQueryResult) return query_result_interval(instr);
    const bool points = std::all_of(instr.args.begin(), instr.args.end(),
                                    [&](Id arg) { return values_[arg].is_point(); });
    if (points) {
        Instr copy = instr;
        for (Id& arg : copy.args)
            arg = values_[arg].point;
        return make_point(b_.append(std::move(copy)));
    }
    switch (instr.op) {
        case Op::kSample:
            return sample_interval(instr);
        case Op::kConvert:
            return convert_interval(instr);
        case Op::kSelect:
            return select_interval(instr);
        case Op::kPick:
            return pick_interval(instr);
        case Op::kBitCast:
            return unknown(instr.type);
        case Op::kAnd:
        case Op::kOr:
        case Op::kNot:
            return bool_interval(instr.op, values_[instr.args[0]], values_[instr.args.back()]);
        case Op::kEq:
        case Op::kNe:
        case Op::kLt:
        case Op::kLe:
        case Op::kGt:
        case Op::kGe:
            return comparison_interval(instr.op, values_[instr.args[0]], values_[instr.args[1]]);
            OPENFAB_IR_CASES(FUNCTIONS)
            return function_interval(instr);
            OPENFAB_IR_CASES(ARITHMETIC)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            break;
        case Op::kSampleBound:
        case Op::kTable:
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(DERIVATIVES)
            return unknown(instr.type);  // treated above, or made later
    }
    if (from_.instrs[instr.args[0]].type == Type::kFloat) return float_interval(instr);
    return integer_interval(instr);
}

Interval IntervalForm::input_interval(const Instr& instr) {
    const auto make = [&](int32_t kind) {
        Instr end = instr;
        end.kind = kind;
        return b_.append(std::move(end));
    };
    if (unknown_(instr.kind)) return unknown(instr.type);
    const auto kinds = kinds_(instr.kind);
    if (!kinds) return make_point(make(instr.kind));
    const Id lo = make((*kinds)[0]);
    const Id hi = make((*kinds)[1]);
    // Converts the bounds of a bool input, given as 0 or 1.
    if (instr.type == Type::kBool) return make_bool(negate(lo), hi);
    if (instr.type == Type::kFloat) return finish(lo, hi);
    return {lo, hi, ir::kNoValue};
}

Interval IntervalForm::bool_interval(Op op, const Interval& a, const Interval& b) {
    if (op == Op::kAnd) return make_bool(either(a.lo, b.lo), both(a.hi, b.hi));
    if (op == Op::kOr) return make_bool(both(a.lo, b.lo), either(a.hi, b.hi));
    return make_bool(a.hi, a.lo);
}

/// Each end is written as "not certainly the opposite", which is conservative if an end is NaN.
Interval IntervalForm::comparison_interval(Op op, const Interval& a, const Interval& b) {
    if (type_of(a.lo) == Type::kBool) {
        const Id may_differ = either(both(a.lo, b.hi), both(a.hi, b.lo));
        const Id may_equal = either(both(a.lo, b.lo), both(a.hi, b.hi));
        return op == Op::kEq ? make_bool(may_differ, may_equal) : make_bool(may_equal, may_differ);
    }
    if (op == Op::kLt) {
        return make_bool(negate(emit(Op::kLt, a.hi, b.lo)), negate(emit(Op::kGe, a.lo, b.hi)));
    }
    if (op == Op::kLe) {
        return make_bool(negate(emit(Op::kLe, a.hi, b.lo)), negate(emit(Op::kGt, a.lo, b.hi)));
    }
    if (op == Op::kGt) return comparison_interval(Op::kLt, b, a);
    if (op == Op::kGe) return comparison_interval(Op::kLe, b, a);
    const Id single = both(emit(Op::kEq, a.lo, a.hi), emit(Op::kEq, b.lo, b.hi));
    const Id equal = both(single, emit(Op::kEq, a.lo, b.lo));
    const Id apart = either(emit(Op::kLt, a.hi, b.lo), emit(Op::kLt, b.hi, a.lo));
    if (op == Op::kEq) return make_bool(negate(equal), negate(apart));
    return make_bool(negate(apart), negate(equal));
}

Interval IntervalForm::hull(const Interval& a, const Interval& b, Type type) {
    const Id lo = emit(Op::kMin, a.lo, b.lo);
    const Id hi = emit(Op::kMax, a.hi, b.hi);
    if (type != Type::kFloat) return {lo, hi, ir::kNoValue};
    return select_known(both(is_known(a), is_known(b)), lo, hi);
}

Interval IntervalForm::select_interval(const Instr& instr) {
    const Interval condition = values_[instr.args[0]];
    const Interval yes = values_[instr.args[1]];
    const Interval no = values_[instr.args[2]];
    if (instr.type == Type::kBool) {
        return make_bool(either(both(condition.hi, yes.lo), both(condition.lo, no.lo)),
                         either(both(condition.hi, yes.hi), both(condition.lo, no.hi)));
    }
    const bool is_float = instr.type == Type::kFloat;
    const Interval joined = hull(yes, no, instr.type);
    const Interval first = is_float && yes.is_point() ? finish(yes.lo, yes.hi) : yes;
    const Interval second = is_float && no.is_point() ? finish(no.lo, no.hi) : no;
    const auto pick = [&](Id a, Id b, Id ab) {
        return b_.select(condition.hi, b_.select(condition.lo, ab, a), b);
    };
    return {pick(first.lo, second.lo, joined.lo), pick(first.hi, second.hi, joined.hi),
            ir::kNoValue};
}

Interval IntervalForm::full_range(Type type) {
    if (type == Type::kInt) {
        return {b_.constant(std::numeric_limits<int32_t>::min()),
                b_.constant(std::numeric_limits<int32_t>::max()), ir::kNoValue};
    }
    return {b_.constant(uint32_t{0}), b_.constant(std::numeric_limits<uint32_t>::max()),
            ir::kNoValue};
}

Interval IntervalForm::convert_interval(const Instr& instr) {
    const Interval x = values_[instr.args[0]];
    const Type from = from_.instrs[instr.args[0]].type;
    const Type to = instr.type;
    if (from == to) return x;
    if (to == Type::kBool)
        return comparison_interval(Op::kNe, x, make_point(constant_like(from, 0)));
    if (from == Type::kBool) {
        const Id zero = constant_like(to, 0);
        const Id one = constant_like(to, 1);
        return {b_.select(x.lo, zero, one), b_.select(x.hi, one, zero), ir::kNoValue};
    }
    const Id lo = b_.convert(x.lo, to);
    const Id hi = b_.convert(x.hi, to);
    if (to == Type::kFloat) return {lo, hi, ir::kNoValue};
    const Interval full = full_range(to);
    Id known = ir::kNoValue;
    if (from == Type::kFloat) {
        known = negate(either(emit(Op::kIsNan, x.lo), emit(Op::kIsNan, x.hi)));
    } else {
        // int and uint agree on 0 .. 2^31 - 1 and, modulo 2^32, elsewhere: order is preserved on
        // either side of 2^31.
        const Id lo_below = emit(Op::kLt, from == Type::kInt ? x.lo : lo, b_.constant(0));
        const Id hi_below = emit(Op::kLt, from == Type::kInt ? x.hi : hi, b_.constant(0));
        known = emit(Op::kEq, lo_below, hi_below);
    }
    return {b_.select(known, lo, full.lo), b_.select(known, hi, full.hi), ir::kNoValue};
}

ir::ValueId IntervalForm::constant_like(Type type, float value) {
    switch (type) {
        case Type::kInt:
            return b_.constant(static_cast<int32_t>(value));
        case Type::kUint:
            return b_.constant(static_cast<uint32_t>(value));
        case Type::kBool:
        case Type::kFloat:
            break;
    }
    return b_.constant(value);
}

Interval IntervalForm::float_interval(const Instr& instr) {
    const Interval& a = values_[instr.args[0]];
    const Interval& b = values_[instr.args.back()];
    switch (instr.op) {
        case Op::kAdd:
            return finish(emit(Op::kAdd, a.lo, b.lo), emit(Op::kAdd, a.hi, b.hi));
        case Op::kSub:
            return finish(emit(Op::kSub, a.lo, b.hi), emit(Op::kSub, a.hi, b.lo));
        case Op::kMul:
            return product_interval(instr, a, b);
        case Op::kDiv:
            return quotient_interval(instr, a, b);
        case Op::kMod:
            return remainder_interval(a, b);
        case Op::kNeg:
            return {emit(Op::kNeg, a.hi), emit(Op::kNeg, a.lo), ir::kNoValue};
        case Op::kAbs: {
            const std::optional<Interval> folded = folded_interval(instr.args[0]);
            return folded ? *folded : magnitude_interval(a);
        }
        case Op::kSqrt:
            return root_interval(a);
        case Op::kMin:
        case Op::kMax: {
            // With a NaN the result is the second operand or NaN: unknown either way.
            const Id known = both(is_known(a), is_known(b));
            return select_known(known, emit(instr.op, a.lo, b.lo), emit(instr.op, a.hi, b.hi));
        }
        case Op::kIsNan: {
            const Id known = both(finite(a.lo), finite(a.hi));
            return make_bool(b_.constant(true), negate(known));
        }
        case Op::kFloor:
        case Op::kCeil:
        case Op::kRound:
        case Op::kTrunc:
            return finish(emit(instr.op, a.lo), emit(instr.op, a.hi));
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return unknown(instr.type);
}

Interval IntervalForm::square_interval(const Interval& a) {
    const Id lo = emit(Op::kMul, a.lo, a.lo);
    const Id hi = emit(Op::kMul, a.hi, a.hi);
    const Id zero = b_.constant(0.0f);
    const Id straddles = both(emit(Op::kLe, a.lo, zero), emit(Op::kGe, a.hi, zero));
    const Id least = b_.select(straddles, zero, emit(Op::kMin, lo, hi));
    return finish(least, emit(Op::kMax, lo, hi));
}

/// An infinite or NaN point operand makes all candidates infinite or NaN, which `finish` detects.
Interval IntervalForm::product_interval(const Instr& instr, const Interval& a, const Interval& b) {
    if (instr.args[0] == instr.args[1]) return square_interval(a);
    if (a.is_point()) return by_point(Op::kMul, instr.args[0], b, a);
    if (b.is_point()) return by_point(Op::kMul, instr.args[1], a, b);
    const Interval ends = extremes({emit(Op::kMul, a.lo, b.lo), emit(Op::kMul, a.lo, b.hi),
                                    emit(Op::kMul, a.hi, b.lo), emit(Op::kMul, a.hi, b.hi)});
    return finish(ends.lo, ends.hi);
}

/// A product with a point, or a quotient by one other than 0: of a constant the sign tells which
/// end is which.
Interval IntervalForm::by_point(Op op, Id id, const Interval& a, const Interval& point) {
    const Id first = emit(op, a.lo, point.lo);
    const Id last = emit(op, a.hi, point.lo);
    const Instr& instr = from_.instrs[id];
    if (instr.op != Op::kConst)
        return finish(emit(Op::kMin, first, last), emit(Op::kMax, first, last));
    return std::bit_cast<float>(instr.bits) < 0 ? finish(last, first) : finish(first, last);
}

Interval IntervalForm::quotient_interval(const Instr& instr, const Interval& a, const Interval& b) {
    const Instr& divisor = from_.instrs[instr.args[1]];
    if (divisor.op == Op::kConst && std::bit_cast<float>(divisor.bits) != 0)
        return by_point(Op::kDiv, instr.args[1], a, b);
    return general_quotient(a, b);
}

Interval IntervalForm::general_quotient(const Interval& a, const Interval& b) {
    const Id zero = b_.constant(0.0f);
    const Id known = either(emit(Op::kGt, b.lo, zero), emit(Op::kLt, b.hi, zero));
    const Interval ends = extremes({emit(Op::kDiv, a.lo, b.lo), emit(Op::kDiv, a.lo, b.hi),
                                    emit(Op::kDiv, a.hi, b.lo), emit(Op::kDiv, a.hi, b.hi)});
    // An infinite point dividend gives infinite candidates; an infinite point divisor correctly
    // gives zeros.
    return finish_if(known, ends.lo, ends.hi);
}

/// a - b * trunc(a / b), composed as it is defined.
Interval IntervalForm::remainder_interval(const Interval& a, const Interval& b) {
    const Interval quotient = general_quotient(a, b);
    const Interval whole = finish(emit(Op::kTrunc, quotient.lo), emit(Op::kTrunc, quotient.hi));
    const Interval part =
        extremes({emit(Op::kMul, b.lo, whole.lo), emit(Op::kMul, b.lo, whole.hi),
                  emit(Op::kMul, b.hi, whole.lo), emit(Op::kMul, b.hi, whole.hi)});
    const Interval checked = finish(part.lo, part.hi);
    return finish(emit(Op::kSub, a.lo, checked.hi), emit(Op::kSub, a.hi, checked.lo));
}

Interval IntervalForm::magnitude_interval(const Interval& a) {
    const Id lo = emit(Op::kAbs, a.lo);
    if (a.is_point()) return {lo, lo, ir::kNoValue};
    // NaN ends stay NaN: neither comparison holds.
    const Id hi = emit(Op::kAbs, a.hi);
    const Id zero = b_.constant(0.0f);
    const Id straddles = both(emit(Op::kLe, a.lo, zero), emit(Op::kGe, a.hi, zero));
    const Id least = b_.select(straddles, zero, emit(Op::kMin, lo, hi));
    return {least, emit(Op::kMax, lo, hi), ir::kNoValue};
}

Interval IntervalForm::root_interval(const Interval& a) {
    const Id known = emit(Op::kGe, a.lo, b_.constant(0.0f));
    return select_known(known, emit(Op::kSqrt, a.lo), emit(Op::kSqrt, a.hi));
}

}  // namespace openfab::passes
