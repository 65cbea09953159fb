// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/functions/differentiate.h"

#include <algorithm>

#include "compiler/functions/differentiate_function.h"

namespace openfab::functions {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::ValueId;

class Arithmetic {
  public:
    Arithmetic(AtZero at_zero, ir::Builder* builder) : at_zero_(at_zero), builder_(*builder) {}

    ValueId of(ValueId value, const ir::Instr& instr, const std::vector<ValueId>& changes) {
        if (instr.op == Op::kPick) return of_pick(instr, changes);
        const bool select = instr.op == Op::kSelect;
        const size_t first = select ? 1 : 0;
        const size_t second = instr.args.size() > 1 ? first + 1 : first;
        const ValueId a = instr.args[first];
        const ValueId b = instr.args[second];
        const ValueId da = changes[first];
        const ValueId db = changes[second];
        switch (instr.op) {
            case Op::kAdd:
                return add(da, db);
            case Op::kSub:
                return subtract(da, db);
            case Op::kMul:
                return add(times(da, b), times(db, a));
            case Op::kDiv:
                return over(subtract(da, times(db, value)), b);
            case Op::kMod:
                return subtract(da, times_quotient(db, a, b));
            case Op::kNeg:
                return subtract(kNoValue, da);
            case Op::kMin:
                return choose(builder_.emit(Op::kLt, {a, b}), da, db);
            case Op::kMax:
                return choose(builder_.emit(Op::kGt, {a, b}), da, db);
            case Op::kAbs:
                return da == kNoValue ? kNoValue : of_abs(a, da);
            case Op::kSqrt:
                return da == kNoValue ? kNoValue : of_sqrt(value, da);
            case Op::kSelect:
                return choose(instr.args[0], da, db);
            case Op::kFloor:
            case Op::kCeil:
            case Op::kRound:
            case Op::kTrunc:
            case Op::kIsNan:
            case Op::kConvert:
                OPENFAB_IR_CASES(BITS)
                OPENFAB_IR_CASES(LOGIC)
                OPENFAB_IR_CASES(COMPARISONS)
                OPENFAB_IR_CASES(LEAVES)
                OPENFAB_IR_CASES(LOOKUPS)
                OPENFAB_IR_CASES(CONTROL)
                OPENFAB_IR_CASES(FUNCTIONS)
                OPENFAB_IR_CASES(DERIVATIVES)
                break;  // steps; or treated apart, or unknown
        }
        return kNoValue;
    }

  private:
    ValueId of_pick(const ir::Instr& pick, const std::vector<ValueId>& changes) {
        std::vector<ValueId> elements(changes.begin() + 1, changes.end());
        if (std::all_of(elements.begin(), elements.end(),
                        [](ValueId change) { return change == kNoValue; }))
            return kNoValue;
        const ValueId zero = builder_.constant(0.0f);
        std::replace(elements.begin(), elements.end(), kNoValue, zero);
        return builder_.pick(pick.args[0], elements);
    }
    ValueId add(ValueId a, ValueId b) {
        if (a == kNoValue) return b;
        return b == kNoValue ? a : builder_.emit(Op::kAdd, {a, b});
    }
    ValueId subtract(ValueId a, ValueId b) {
        if (b == kNoValue) return a;
        return a == kNoValue ? builder_.emit(Op::kNeg, {b}) : builder_.emit(Op::kSub, {a, b});
    }
    ValueId times(ValueId a, ValueId factor) {
        return a == kNoValue ? kNoValue : builder_.emit(Op::kMul, {a, factor});
    }
    ValueId over(ValueId a, ValueId divisor) {
        return a == kNoValue ? kNoValue : builder_.emit(Op::kDiv, {a, divisor});
    }
    ValueId choose(ValueId condition, ValueId a, ValueId b) {
        if (a == kNoValue && b == kNoValue) return kNoValue;
        if (a == kNoValue) a = builder_.constant(0.0f);
        if (b == kNoValue) b = builder_.constant(0.0f);
        return builder_.select(condition, a, b);
    }
    ValueId times_quotient(ValueId db, ValueId a, ValueId b) {
        if (db == kNoValue) return kNoValue;
        const ValueId whole = builder_.emit(Op::kTrunc, {builder_.emit(Op::kDiv, {a, b})});
        return times(db, whole);
    }
    ValueId of_abs(ValueId a, ValueId da) {
        const ValueId below = builder_.emit(Op::kLt, {a, builder_.constant(0.0f)});
        return builder_.select(below, builder_.emit(Op::kNeg, {da}), da);
    }
    ValueId of_sqrt(ValueId root, ValueId da) {
        const ValueId change = over(da, builder_.emit(Op::kMul, {root, builder_.constant(2.0f)}));
        if (at_zero_ == AtZero::kQuotient) return change;
        const ValueId zero = builder_.constant(0.0f);
        return builder_.select(builder_.emit(Op::kEq, {root, zero}), zero, change);
    }

    AtZero at_zero_;
    ir::Builder& builder_;
};

}  // namespace

std::vector<ValueId> differentiable_args(const ir::Instr& instr) {
    if (instr.type != ir::Type::kFloat) return {};
    switch (instr.op) {
        case Op::kSample:
        case Op::kConvert:
            OPENFAB_IR_CASES(CONTROL)
            return {};
        case Op::kSelect:
            return {instr.args[1], instr.args[2]};
        case Op::kPick:
            return {instr.args.begin() + 1, instr.args.end()};
        case Op::kSampleBound:
        case Op::kBitCast:
        case Op::kTable:
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(FUNCTIONS)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            return instr.args;
    }
    return {};
}

ValueId differentiate(ValueId value, const ir::Instr& instr, const std::vector<ValueId>& changes,
                      AtZero at_zero, ir::Builder* builder) {
    if (differentiable_args(instr).empty()) return kNoValue;
    if (ir::is_function(instr.op)) return differentiate_function(value, instr, changes, builder);
    return Arithmetic(at_zero, builder).of(value, instr, changes);
}

}  // namespace openfab::functions
