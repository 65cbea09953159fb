// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Arithmetic of ints and uints, which wraps.

#include <array>
#include <utility>

#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

using ir::Instr;

// Float products of int ends below these cannot overflow: the conversions and the product err by
// less than 3 * 2^-24.
constexpr float kIntProductLimit = 2147480000.0f;
constexpr float kUintProductLimit = 4294960000.0f;

}  // namespace

Interval IntervalForm::exact_or(Op op, const Interval& a, const Interval& b,
                                const Interval& other) {
    const bool unary = ir::arity(op) == 1;
    const Id exact = unary ? emit(op, a.lo) : emit(op, a.lo, b.lo);
    Id single = emit(Op::kEq, a.lo, a.hi);
    if (!unary) single = both(single, emit(Op::kEq, b.lo, b.hi));
    return {b_.select(single, exact, other.lo), b_.select(single, exact, other.hi), ir::kNoValue};
}

Interval IntervalForm::integer_sum(Op op, Type type, const Interval& a, const Interval& b) {
    const Id b_lo = op == Op::kAdd ? b.lo : b.hi;
    const Id b_hi = op == Op::kAdd ? b.hi : b.lo;
    const Id lo = emit(op, a.lo, b_lo);
    const Id hi = emit(op, a.hi, b_hi);
    const auto wraps = [&](Id x, Id y, Id result) {
        if (type == Type::kUint) {
            return op == Op::kAdd ? emit(Op::kLt, result, x) : emit(Op::kLt, x, y);
        }
        // The sign of the result differs from that of x, as y moves it.
        const Id changed = emit(Op::kBitXor, x, result);
        const Id pushed = op == Op::kAdd ? emit(Op::kBitXor, y, result) : emit(Op::kBitXor, x, y);
        return emit(Op::kLt, emit(Op::kBitAnd, changed, pushed), b_.constant(0));
    };
    const Id bad = either(wraps(a.lo, b_lo, lo), wraps(a.hi, b_hi, hi));
    const Interval full = full_range(type);
    return {b_.select(bad, full.lo, lo), b_.select(bad, full.hi, hi), ir::kNoValue};
}

Interval IntervalForm::integer_product(Type type, const Interval& a, const Interval& b) {
    const bool is_int = type == Type::kInt;
    const Id limit = b_.constant(is_int ? kIntProductLimit : kUintProductLimit);
    const std::array<std::pair<Id, Id>, 4> corners = {
        {{a.lo, b.lo}, {a.lo, b.hi}, {a.hi, b.lo}, {a.hi, b.hi}}};
    std::array<Id, 4> products{};
    Id fits = b_.constant(true);
    for (size_t k = 0; k < corners.size(); ++k) {
        const auto [x, y] = corners[k];
        products[k] = emit(Op::kMul, x, y);
        const Id size = emit(Op::kMul, b_.convert(x, Type::kFloat), b_.convert(y, Type::kFloat));
        fits = both(fits, emit(Op::kLt, emit(Op::kAbs, size), limit));
    }
    const Interval ends = extremes(products);
    const Interval full = full_range(type);
    return {b_.select(fits, ends.lo, full.lo), b_.select(fits, ends.hi, full.hi), ir::kNoValue};
}

/// Handles division and remainder by a positive constant, right shifts by a constant and masks with
/// a nonnegative one; otherwise returns the whole range.
Interval IntervalForm::integer_rest(Op op, Type type, const Interval& a, const Interval& b) {
    const Interval full = full_range(type);
    const Id zero = constant_like(type, 0);
    const Id single = emit(Op::kEq, b.lo, b.hi);
    if (op == Op::kBitAnd) {
        const Id mask = emit(Op::kGe, b.lo, zero);
        return {b_.select(mask, zero, full.lo), b_.select(mask, b.hi, full.hi), ir::kNoValue};
    }
    if (op == Op::kShr) {
        const Id count = both(single, emit(Op::kGe, b.lo, zero));
        return {b_.select(count, emit(Op::kShr, a.lo, b.lo), full.lo),
                b_.select(count, emit(Op::kShr, a.hi, b.lo), full.hi), ir::kNoValue};
    }
    if (op != Op::kDiv && op != Op::kMod) return full;
    const Id simple = both(single, emit(Op::kGt, b.lo, zero));
    const Id quotient_lo = emit(Op::kDiv, a.lo, b.lo);
    const Id quotient_hi = emit(Op::kDiv, a.hi, b.lo);
    if (op == Op::kDiv) {
        return {b_.select(simple, quotient_lo, full.lo), b_.select(simple, quotient_hi, full.hi),
                ir::kNoValue};
    }
    const Id most = emit(Op::kSub, b.lo, constant_like(type, 1));
    const Id not_below = emit(Op::kGe, a.lo, zero);
    const Id same =
        both(emit(Op::kEq, quotient_lo, quotient_hi), either(not_below, emit(Op::kLe, a.hi, zero)));
    const Id wide_lo = b_.select(not_below, zero, emit(Op::kNeg, most));
    const Id lo = b_.select(same, emit(Op::kMod, a.lo, b.lo), wide_lo);
    const Id hi = b_.select(same, emit(Op::kMod, a.hi, b.lo), most);
    return {b_.select(simple, lo, full.lo), b_.select(simple, hi, full.hi), ir::kNoValue};
}

Interval IntervalForm::integer_interval(const Instr& instr) {
    const Interval& a = values_[instr.args[0]];
    const Interval& b = values_[instr.args.back()];
    const Type type = instr.type;
    switch (instr.op) {
        case Op::kMin:
        case Op::kMax:
            return {emit(instr.op, a.lo, b.lo), emit(instr.op, a.hi, b.hi), ir::kNoValue};
        case Op::kAdd:
        case Op::kSub:
            return exact_or(instr.op, a, b, integer_sum(instr.op, type, a, b));
        case Op::kMul:
            return exact_or(instr.op, a, b, integer_product(type, a, b));
        case Op::kAbs: {
            if (type == Type::kUint) return a;
            const Id zero = b_.constant(0);
            const Id lowest = full_range(type).lo;
            const Id straddles = both(emit(Op::kLt, a.lo, zero), emit(Op::kGt, a.hi, zero));
            const Id lo = emit(Op::kAbs, a.lo);
            const Id hi = emit(Op::kAbs, a.hi);
            const Id least = b_.select(straddles, zero, emit(Op::kMin, lo, hi));
            const Id overflow = emit(Op::kEq, a.lo, lowest);
            const Interval full = full_range(type);
            return exact_or(instr.op, a, b,
                            {b_.select(overflow, full.lo, least),
                             b_.select(overflow, full.hi, emit(Op::kMax, lo, hi)), ir::kNoValue});
        }
        case Op::kDiv:
        case Op::kMod:
        case Op::kNeg:
            OPENFAB_IR_CASES(BITS)
            return exact_or(instr.op, a, b, integer_rest(instr.op, type, a, b));
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return unknown(type);
}

}  // namespace openfab::passes
