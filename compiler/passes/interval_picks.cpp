// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The interval form of Picks, whose elements are points: see expand_picks.
#include <cmath>

#include "compiler/ir/arithmetic.h"
#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

// Elements that are looked at one by one: what a cube reaches of a table along an axis.
constexpr uint32_t kMostElements = 8;

}  // namespace

/// Bounds those elements that the index may name if they are few. Where they are more, constants all
/// together are, and nothing is known of others.
Interval IntervalForm::pick_interval(const ir::Instr& instr) {
    const Interval index = values_[instr.args[0]];
    const Type of_index = type_of(index.lo);
    const auto last = static_cast<uint32_t>(instr.args.size() - 2);
    const auto clamped = [&](Id end) {
        const Id at = emit(Op::kMin, end, b_.constant(of_index, last));
        return of_index == Type::kInt ? emit(Op::kMax, at, b_.constant(0)) : at;
    };
    const Id first = clamped(index.lo), end = clamped(index.hi);
    std::vector<Id> elements;
    for (size_t k = 1; k < instr.args.size(); ++k) {
        if (!values_[instr.args[k]].is_point()) return unknown(instr.type);
        elements.push_back(values_[instr.args[k]].point);
    }
    const bool is_float = instr.type == Type::kFloat, is_bool = instr.type == Type::kBool;
    Id few = emit(Op::kLt, emit(Op::kSub, end, first), b_.constant(of_index, kMostElements));
    Id lo = ir::kNoValue, hi = ir::kNoValue;
    for (uint32_t k = 0; k < kMostElements; ++k) {
        const Id next = emit(Op::kAdd, first, b_.constant(of_index, k));
        const Id one = b_.pick(k == 0 ? first : emit(Op::kMin, next, end), elements);
        if (is_float) few = both(few, finite(one));
        const Id low = is_bool ? negate(one) : one;
        lo = k == 0 ? low : is_bool ? either(lo, low) : emit(Op::kMin, lo, low);
        hi = k == 0 ? one : is_bool ? either(hi, one) : emit(Op::kMax, hi, one);
    }
    if (is_bool) return make_bool(either(lo, negate(few)), either(hi, negate(few)));
    const Interval all = all_elements(instr);
    return {b_.select(few, lo, all.lo), b_.select(few, hi, all.hi), ir::kNoValue};
}

/// Bounds all elements of a Pick of numbers.
Interval IntervalForm::all_elements(const ir::Instr& pick) {
    const auto eval = [&](Op op, uint32_t a, uint32_t b) {
        return ir::eval(op, pick.type, a, b, 0);
    };
    uint32_t lo = 0, hi = 0;
    for (size_t k = 1; k < pick.args.size(); ++k) {
        const ir::Instr& element = from_.instrs[pick.args[k]];
        if (element.op != Op::kConst) return unknown(pick.type);
        if (pick.type == Type::kFloat && !std::isfinite(ir::as_float(element.bits)))
            return unknown(pick.type);
        lo = k == 1 ? element.bits : eval(Op::kMin, lo, element.bits);
        hi = k == 1 ? element.bits : eval(Op::kMax, hi, element.bits);
    }
    const auto end = [&](uint32_t bits) { return b_.constant(pick.type, bits); };
    if (pick.type == Type::kFloat) return finish(end(lo), end(hi));
    return {end(lo), end(hi), ir::kNoValue};
}

}  // namespace openfab::passes
