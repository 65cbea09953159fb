// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_looks.h"

#include <algorithm>
#include <array>

#include "compiler/ir/shape_distance.h"

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

/// Whether a value may differ within the bounds: a bool of the bounds stage, kSame: never.
using Differs = ValueId;
constexpr Differs kSame = kNoValue;

/// True for operations that tell 0 from -0. Those that do not are named one by one where a new one of
/// their family might.
bool tells_zeros(Op op, Type type) {
    switch (op) {
        case Op::kDiv:
        case Op::kMod:
            return type == Type::kFloat;
            OPENFAB_IR_CASES(LOOKUPS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(FUNCTIONS)
            OPENFAB_IR_CASES(DERIVATIVES)
            return true;
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kNeg:
        case Op::kMin:
        case Op::kMax:
        case Op::kAbs:
        case Op::kSqrt:
        case Op::kFloor:
        case Op::kCeil:
        case Op::kRound:
        case Op::kTrunc:
        case Op::kIsNan:
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(CHOICES)
            return false;
    }
    return true;
}

/// True for operations whose result may be one value while their operands are not.
bool may_decide(Op op, Type type) {
    switch (op) {
        case Op::kPick:
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(EXTREMES)
            OPENFAB_IR_CASES(FLOAT_PARTS)
            return true;
        case Op::kSample:
        case Op::kSampleBound:
        case Op::kBitCast:
        case Op::kTable:
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(ARITHMETIC)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(FUNCTIONS)
            OPENFAB_IR_CASES(DERIVATIVES)
            break;
    }
    return type != Type::kFloat;
}

class LooksForm {
  public:
    /// `shape`: of a shape, not of a volume.
    LooksForm(const ir::Stage& stage, bool shape, const std::vector<Interval>& intervals,
              ir::Builder* builder)
        : from_(stage),
          shape_(shape),
          intervals_(intervals),
          b_(*builder),
          live_(ir::live_values(stage)) {}

    std::optional<ValueId> run() {
        bool distance = false;
        for (ValueId id = 0; id < from_.instrs.size(); ++id) {
            const ir::Instr& instr = from_.instrs[id];
            distance |= live_[id] && instr.op == Op::kInput &&
                        instr.kind == (shape_ ? abi::kShapeDistance : OPENFAB_ARG_DISTANCE);
        }
        if (!distance) return std::nullopt;
        for (std::vector<Differs>& of : differs_)
            of.assign(from_.instrs.size(), kSame);
        find_loops();
        for (ValueId id = 0; id < from_.instrs.size(); ++id) {
            if (!live_[id] || outermost_[id] != kNoValue) continue;
            for (const bool bits : {false, true})
                differs_[bits ? 1 : 0][id] = find(id, bits);
        }
        Differs any = kSame;
        for (const ir::Output& output : from_.outputs) {
            const ir::Instr& instr = from_.instrs[output.value];
            const Differs differs = of(output.value, shape_);
            any = either(any, may_decide(instr.op, instr.type)
                                  ? differs
                                  : unless_single(output.value, differs, shape_));
        }
        return any == kSame ? b_.constant(false) : any;
    }

  private:
    /// Finds the outermost loop around each instruction: its Loop, LoopEnd and what is between.
    void find_loops() {
        outermost_.assign(from_.instrs.size(), kNoValue);
        int depth = 0;
        ValueId loop = kNoValue;
        for (ValueId id = 0; id < from_.instrs.size(); ++id) {
            const Op op = from_.instrs[id].op;
            if (op == Op::kLoop && depth++ == 0) loop = id;
            if (depth > 0) outermost_[id] = loop;
            if (op == Op::kLoopEnd) --depth;
        }
    }

    Differs of(ValueId id, bool bits) const { return differs_[bits ? 1 : 0][id]; }

    /// `bits`: 0 and -0 count as different.
    Differs find(ValueId id, bool bits) {
        const ir::Instr& instr = from_.instrs[id];
        const auto arg = [&](size_t k) { return of(instr.args[k], bits); };
        const auto interval = [&](size_t k) -> const Interval& {
            return intervals_[instr.args[k]];
        };
        if (instr.op == Op::kInput) return is_nearest(instr) ? b_.constant(true) : kSame;
        if (instr.op == Op::kLoopResult) return of_loop(outermost_[instr.args[0]]);
        if (instr.op == Op::kSelect) {
            const Differs taken =
                either(both(arg(1), interval(0).hi), both(arg(2), interval(0).lo));
            return unless_single(id, either(arg(0), taken), bits);
        }
        // One operand says nothing where the other decides.
        if (instr.op == Op::kAnd) {
            return unless_single(
                id, either(both(arg(0), interval(1).hi), both(arg(1), interval(0).hi)), bits);
        }
        if (instr.op == Op::kOr) {
            return unless_single(
                id, either(both(arg(0), interval(1).lo), both(arg(1), interval(0).lo)), bits);
        }
        if (shape_ && instr.type == Type::kFloat &&
            (instr.op == Op::kMin || instr.op == Op::kMax)) {
            const bool most = instr.op == Op::kMax;
            return unless_single(id,
                                 either(both(arg(0), chance(interval(0), interval(1), most)),
                                        both(arg(1), chance(interval(1), interval(0), most))),
                                 bits);
        }
        Differs any = kSame;
        const bool zeros = bits || tells_zeros(instr.op, instr.type);
        for (const ValueId operand : instr.args)
            any = either(any, of(operand, zeros));
        return may_decide(instr.op, instr.type) ? unless_single(id, any, bits) : any;
    }

    /// Whether one of two values may be the larger, or the smaller, or a NaN.
    ValueId chance(const Interval& one, const Interval& other, bool largest) {
        if (one.lo == kNoValue || other.lo == kNoValue) return b_.constant(true);
        const ValueId none =
            largest ? b_.emit(Op::kLt, {one.hi, other.lo}) : b_.emit(Op::kLt, {other.hi, one.lo});
        return b_.emit(Op::kNot, {none});
    }

    bool is_nearest(const ir::Instr& instr) const {
        if (shape_) return instr.kind == abi::kShapeDistance;
        return instr.kind == OPENFAB_ARG_NEAREST || instr.kind == OPENFAB_ARG_NEAREST_GRAD ||
               instr.kind == OPENFAB_ARG_DISTANCE;
    }

    /// What a loop gives may differ if anything that it reads does.
    Differs of_loop(ValueId loop) {
        Differs any = kSame;
        for (ValueId id = loop; id < from_.instrs.size() && outermost_[id] == loop; ++id) {
            const ir::Instr& instr = from_.instrs[id];
            if (!live_[id]) continue;
            if (instr.op == Op::kInput && is_nearest(instr)) any = b_.constant(true);
            for (const ValueId operand : instr.args)
                if (operand < loop) any = either(any, of(operand, true));
        }
        return any;
    }

    /// A value of which both ends are one does not differ.
    Differs unless_single(ValueId id, Differs differs, bool bits) {
        const Interval& interval = intervals_[id];
        if (differs == kSame || interval.lo == kNoValue) return differs;
        if (from_.instrs[id].type == Type::kBool)
            return both(both(differs, interval.lo), interval.hi);
        ValueId single = b_.emit(Op::kEq, {interval.lo, interval.hi});
        if (bits && from_.instrs[id].type == Type::kFloat) {
            single =
                b_.emit(Op::kAnd, {single, b_.emit(Op::kNe, {interval.lo, b_.constant(0.0f)})});
        }
        return both(differs, b_.emit(Op::kNot, {single}));
    }

    Differs either(Differs a, Differs b) {
        if (a == kSame || a == b) return b;
        return b == kSame ? a : b_.emit(Op::kOr, {a, b});
    }
    Differs both(Differs differs, ValueId condition) {
        return differs == kSame ? kSame : b_.emit(Op::kAnd, {differs, condition});
    }

    const ir::Stage& from_;
    const bool shape_;
    const std::vector<Interval>& intervals_;
    ir::Builder& b_;
    const std::vector<bool> live_;
    std::vector<ValueId> outermost_;
    std::array<std::vector<Differs>, 2> differs_;  ///< 1: where bits count
};

}  // namespace

std::optional<ir::ValueId> form_looks(const ir::Stage& volume,
                                      const std::vector<Interval>& intervals,
                                      ir::Builder* builder) {
    return LooksForm(volume, false, intervals, builder).run();
}

std::optional<ir::ValueId> form_shape_looks(const ir::Stage& shape,
                                            const std::vector<Interval>& intervals,
                                            ir::Builder* builder) {
    return LooksForm(shape, true, intervals, builder).run();
}

}  // namespace openfab::passes
